"""Sum of each frame's corrected values over the whole opening."""

from typing import final

import numpy as np

from irtiming.records.arrays import Array
from irtiming.reduce import kernels
from irtiming.reduce.frame_pass import Block
from irtiming.reduce.nonuniformity import Correction


@final
class PixelSum:
    """Weighted sum of each frame: ``total_dn`` (n_frame,), corrected DN.

    Parameters
    ----------
    weight, correct
        Weights of corrected values and the correction, both of the region of interest, shape (roi rows, roi columns).
    n_frames
        Of the recording.
    """

    def __init__(self, weight: Array, correct: Correction, *, n_frames: int) -> None:
        self._weights = (weight * correct.gain).astype(np.float32)
        self._constant = float(np.sum(weight * correct.offset_dn))
        self.total_dn = np.zeros(n_frames)

    def add(self, block: Block) -> None:
        """Sum some frames."""
        self.total_dn[block.now] = kernels.weighted_sum(block.part, self._weights) + self._constant
