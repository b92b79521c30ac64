"""How numbers scatter about zero, whatever a few that are far off say, and what those count for (Huber)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from irtiming.records.arrays import Array

OF_NORMAL = 1.4826
"""Standard deviation of normal noise over the median of its absolute values."""


def spread(beside: NDArray[np.floating[Any]]) -> float:
    """Standard deviation of normal noise with the same median of its absolute values.

    Parameters
    ----------
    beside
        Any shape; deviations, or their sizes.
    """
    return OF_NORMAL * float(np.median(np.abs(beside)))


def huber_loss(size: Array, limit: float) -> Array:
    """Square of each deviation's size, shape (n,), which beyond a limit grows along its tangent."""
    return np.where(size <= limit, size**2, 2 * limit * size - limit**2)


def huber_weight(size: Array, limit: float) -> Array:
    """Weight of each, shape (n,), whose least squares make the sum of `huber_loss` least."""
    return np.minimum(1.0, limit / np.maximum(size, 1e-300))
