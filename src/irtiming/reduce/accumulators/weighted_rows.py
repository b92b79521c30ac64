"""Weighted sums over the rows of frames: whole numbers where weights are 0 and 1, but for some pixels."""

from typing import final

import numpy as np

from irtiming.records.arrays import Array, Pixels
from irtiming.reduce import device_memory, kernels
from irtiming.reduce.nonuniformity import Correction

_ALL_BITS = 0xFFFF


@final
class WeightedRows:
    """Sums over rows with given weights of corrected values.

    Parameters
    ----------
    weight, correct
        Weights of corrected values, and the correction; shape (row, column).
    every
        Only every nth row of the frames has weights, from the first on.
    """

    def __init__(self, weight: Array, correct: Correction, *, every: int = 1) -> None:
        self._every = every
        self._constant = np.sum(weight * correct.offset_dn, axis=1)
        self._is_corrected = not correct.is_none
        self._weights = (weight * correct.gain).astype(np.float32)
        self._bits = np.where(weight >= 1, _ALL_BITS, 0).astype(np.uint16)
        beyond = weight - (weight >= 1)
        self._odd = [(row, column, beyond[row, column]) for row, column in np.argwhere(beyond)]

    def of(self, frames: Pixels) -> Array:
        """Sums of frames (frame, row, column), shape (frame, row with weights), corrected DN."""
        if self._is_corrected:
            return np.asarray(kernels.weighted_row_sum(frames, self._weights, self._every) + self._constant)
        sums = kernels.sum_within(frames, self._bits, self._every).astype(float)
        for row, column, beyond in self._odd:
            sums[:, row] += beyond * device_memory.to_host(frames[:, self._every * row, column])
        return np.asarray(sums)
