"""Pixels above a threshold of their own in each frame."""

from typing import final

import numpy as np

from irtiming.records.arrays import Pixels
from irtiming.reduce import kernels
from irtiming.reduce.frame_pass import Block


@final
class Counts:
    """Pixels above their threshold in each frame: ``count`` (n_frame,).

    Parameters
    ----------
    thresholds
        Of the region of interest, raw values, shape (roi rows, roi columns).
    n_frames
        Of the recording.
    """

    def __init__(self, thresholds: Pixels, *, n_frames: int) -> None:
        self._thresholds = np.ascontiguousarray(thresholds)
        self.count = np.zeros(n_frames, np.int64)

    def add(self, block: Block) -> None:
        """Count in some frames."""
        self.count[block.now] = kernels.count_above(block.part, self._thresholds)
