"""Places from which a pixel's light comes: its own square, blurred, in equal parts that fill the plane evenly.

Where a pixel's light comes over the edge of the mask's opening, thousands of rays say how much; elsewhere a hundred or so do.
"""

import math
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from numba import njit

from irtiming.records.arrays import Array

Offsets: TypeAlias = npt.NDArray[np.float32]

VARIANTS = 16
"""Shifted copies of the places, among pixels as if by chance, lest an edge runs along places of many pixels."""

_REACH = 4.0  # standard deviations of the blur
_HALF_DIAGONAL_PX = 0.71
_EDGE_RAY_BUDGET = 3e6
_MOST_EDGE_RAYS = 10_000
_GOLDEN = (math.sqrt(5) - 1) / 2


def reach_px(blur_rows_columns_px: tuple[float, float]) -> float:
    """How far from its centre a pixel's light may come: what lies within is looked at for the edge of the opening."""
    return _HALF_DIAGONAL_PX + _REACH * max(blur_rows_columns_px)


def edge_rays(rows: int, columns: int) -> int:
    """Rays of a pixel on the edge of the opening, in an image of that size: there are as many such pixels as it is long."""
    return round(min(_EDGE_RAY_BUDGET / math.sqrt(rows * columns), _MOST_EDGE_RAYS))


def pixel_spread(n: int, blur_rows_columns_px: tuple[float, float], *, variants: int) -> Offsets:
    """Places, px from a pixel's centre, from which its light comes in equal parts: its own square, blurred.

    Parameters
    ----------
    n
        Places of one variant; they fill the plane evenly.
    blur_rows_columns_px
        Standard deviation of the Gaussian from row to row and from column to column, px.
    variants
        Shifted copies, each with the mean 0, the variance 1/12 + blur^2 along each axis and no covariance.

    Returns
    -------
    Shape (variants, n, 2): row, column.
    """
    order = np.arange(n)
    shift = np.random.Generator(np.random.SFC64(1)).random((variants, 1, 2))
    even = np.stack([(order + 0.5) / n, np.mod(0.5 + order * _GOLDEN, 1.0)], axis=1)
    even = np.mod(even + shift, 1.0)
    place = np.stack([_smeared(even[..., axis], blur_rows_columns_px[axis]) for axis in (0, 1)], axis=-1)
    place = place - place.mean(axis=1, keepdims=True)
    slant = np.mean(place[..., 0] * place[..., 1], axis=1) / np.mean(place[..., 0] ** 2, axis=1)
    place[..., 1] -= slant[:, None] * place[..., 0]
    place *= np.sqrt((1 / 12 + np.square(blur_rows_columns_px)) / np.mean(place**2, axis=1, keepdims=True))
    return place.astype(np.float32)


def _smeared(even: Array, blur_px: float) -> Array:
    """Places along one axis, px, of parts of the light from 0 to 1, any shape."""
    if blur_px == 0:
        return even - 0.5
    grid = np.linspace(-0.5 - 6 * blur_px, 0.5 + 6 * blur_px, 40_001)
    density = _within_pixel(grid, blur_px)
    below = np.cumsum(density) - 0.5 * density
    return np.interp(even, below / density.sum(), grid)


@njit(cache=True, nogil=True)
def _within_pixel(place: Array, blur_px: float) -> Array:
    """Part of a Gaussian about each place that falls between -1/2 and 1/2, shape (n,)."""
    found, scale = np.empty(place.size), 1 / (blur_px * math.sqrt(2.0))
    for k in range(place.size):
        found[k] = 0.5 * (math.erfc(-(place[k] + 0.5) * scale) - math.erfc(-(place[k] - 0.5) * scale))
    return found
