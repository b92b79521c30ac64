"""A blur of another shape than a Gaussian: what pixels exchange with others near them, along rows and along columns.

A symmetric blur differs from a Gaussian of its width by how much light it leaves in the middle and on its flanks; exchanges over
one and over two pixels make any such difference that is small.
"""

import numpy as np
from scipy import ndimage

from irtiming.records.arrays import ComplexArray

EXCHANGES = ((0, 1), (1, 1), (0, 2), (1, 2))
"""Axes, and distances in px."""

U_EXCHANGED = 0.1
"""Prior: of the share that is exchanged, beside a Gaussian blur."""


def exchanged(image: ComplexArray, share: float, *, axis: int, away: int) -> ComplexArray:
    """An image where each pixel exchanges that share of its light with those so many pixels away along an axis; same shape."""
    weights = np.zeros(2 * away + 1)
    weights[[0, away, -1]] = share / 2, -share, share / 2
    change = ndimage.correlate1d(image.view(float).reshape(*image.shape, 2), weights, axis=axis, mode="nearest")
    return np.asarray(image + change[..., 0] + 1j * change[..., 1])
