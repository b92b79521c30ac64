"""Frames most of whose pixels are at an end of the scale."""

from typing import final

import numpy as np

from irtiming.reduce import kernels
from irtiming.reduce.frame_pass import Block

_MOSTLY = 0.5  # of the pixels
_SOME_ROWS = 4  # every fourth row is enough to tell


@final
class Limits:
    """Frames with more than half of their pixels at zero, or at full scale: ``is_dead`` (n_frame,).

    Parameters
    ----------
    full_scale
        Largest value that the camera gives, DN.
    n_frames
        Of the recording.
    """

    def __init__(self, full_scale: int, *, n_frames: int) -> None:
        self._full_scale = full_scale
        self.is_dead = np.zeros(n_frames, bool)

    def add(self, block: Block) -> None:
        """Look at some frames."""
        most = kernels.count_at_limits(block.part, self._full_scale, _SOME_ROWS).max(axis=0)
        self.is_dead[block.now] = most > _MOSTLY * block.part[0, ::_SOME_ROWS, :].size
