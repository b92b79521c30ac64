"""Frames that repeat the one before, bit by bit: a camera that is frozen, or that sent one twice."""

from typing import TYPE_CHECKING, final

import numpy as np

from irtiming.reduce import device_memory, kernels
from irtiming.reduce.frame_pass import Block

if TYPE_CHECKING:
    from irtiming.records.arrays import Pixels


@final
class Repeats:
    """Frames that are the one before: ``is_repeated`` (n_frame,).

    Parameters
    ----------
    noise_dn
        Of one pixel from frame to frame, DN: without any, two frames of the same scene are alike, and none counts as repeated.
    n_frames
        Of the recording.
    """

    def __init__(self, noise_dn: float, *, n_frames: int) -> None:
        self._is_noisy = noise_dn > 0
        self._last: Pixels | None = None
        self.is_repeated = np.zeros(n_frames, bool)

    def add(self, block: Block) -> None:
        """Compare some frames with those before."""
        if not self._is_noisy:
            return
        before = ~block.part[0, ...] if self._last is None else self._last
        self.is_repeated[block.now] = kernels.repeats(block.part, before)
        self._last = device_memory.copied(block.part[-1, ...])
