"""Places from which a pixel's light comes: its own square, blurred, in equal parts that fill the plane evenly.

Where a pixel's light comes over the edge of the mask's opening, thousands of rays say how much; elsewhere a hundred or so do.
"""

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from numba import njit

from irtiming.records.arrays import Array
from irtiming.twin.optics import Optics

Offsets: TypeAlias = npt.NDArray[np.float32]

VARIANTS = 16
"""Shifted copies of the places, among pixels as if by chance, lest an edge runs along places of many pixels."""

_GRADES, _GRADE_VARIANTS = 12, 4  # steps from the middle of the image to its corners, and variants of each
_REACH = 4.0  # standard deviations of the blur
_HALF_DIAGONAL_PX = 0.71
_EDGE_RAY_BUDGET = 3e6
_MOST_EDGE_RAYS = 10_000
_GOLDEN = (math.sqrt(5) - 1) / 2
_PLASTIC = 1.324717957244746  # root of x^3 = x + 1: its powers fill a plane as those of the golden ratio a line


def reach_px(optics: Optics) -> float:
    """How far from its centre a pixel's light may come: what lies within is looked at for the edge of the opening."""
    return _HALF_DIAGONAL_PX + _REACH * max(optics.blur_rows_columns_px) * math.sqrt(max(1.0, 1 + optics.blur_growth))


def edge_rays(rows: int, columns: int) -> int:
    """Rays of a pixel on the edge of the opening, in an image of that size: there are as many such pixels as it is long."""
    return round(min(_EDGE_RAY_BUDGET / math.sqrt(rows * columns), _MOST_EDGE_RAYS))


def graded_spread(n: int, optics: Optics, *, variants: int) -> Offsets:
    """`pixel_spread` of pixels in the middle of the image and of others in steps to its corners, one step where all are alike.

    Pixels of several steps need fewer variants each.

    Returns
    -------
    Shape (steps, variants, n, 2): steps of equal size in the square of the distance, from 0 to half a diagonal.
    """
    steps, copies = (_GRADES, min(variants, _GRADE_VARIANTS)) if optics.blur_growth != 0 else (1, variants)
    wider = np.sqrt(1 + optics.blur_growth * (np.arange(steps) + 0.5) / steps)
    rows_px, columns_px = optics.blur_rows_columns_px
    return np.stack([
        pixel_spread(n, (rows_px * one, columns_px * one), turn_rad=optics.blur_turn_rad, variants=copies)
        for one in wider.tolist()
    ])  # fmt: skip


def pixel_spread(n: int, blur_rows_columns_px: tuple[float, float], *, turn_rad: float = 0.0, variants: int) -> Offsets:
    """Places, px from a pixel's centre, from which its light comes in equal parts: its own square, blurred.

    Parameters
    ----------
    n
        Places of one variant; they fill the plane evenly.
    blur_rows_columns_px
        Standard deviation of the Gaussian from row to row and from column to column, px.
    turn_rad
        By which its two axes are turned, from right to down.
    variants
        Shifted copies, each with the mean 0 and the covariance of the blur, and 1/12 more along rows and columns.

    Returns
    -------
    Shape (variants, n, 2): row, column.
    """
    order = np.arange(n, dtype=float)
    if turn_rad == 0:
        even = _shifted([(order + 0.5) / n, 0.5 + order * _GOLDEN], variants)
        place = np.stack([_smeared(even[..., axis], blur_rows_columns_px[axis]) for axis in (0, 1)], axis=-1)
    else:
        place = _turned(order, blur_rows_columns_px, turn_rad, variants)
    place = place - place.mean(axis=1, keepdims=True)
    turn = np.array([[math.cos(turn_rad), math.sin(turn_rad)], [-math.sin(turn_rad), math.cos(turn_rad)]])
    wanted = turn @ np.diag(np.square(blur_rows_columns_px)) @ turn.T + np.eye(2) / 12
    slant = np.mean(place[..., 0] * place[..., 1], axis=1) / np.mean(place[..., 0] ** 2, axis=1)
    place[..., 1] -= slant[:, None] * place[..., 0]
    along = wanted[0, 1] / wanted[0, 0]
    own = np.array([wanted[0, 0], wanted[1, 1] - along * wanted[0, 1]])
    place *= np.sqrt(own / np.mean(place**2, axis=1, keepdims=True))
    place[..., 1] += along * place[..., 0]
    return place.astype(np.float32)


def _turned(order: Array, blur_rows_columns_px: tuple[float, float], turn_rad: float, variants: int) -> Array:
    """Places of a round blur and the pixel's square, moved along the wide axis by what the blur is wider there."""
    rows_px, columns_px = blur_rows_columns_px
    even = _shifted([(order + 0.5) / order.size, 0.5 + order / _PLASTIC, 0.5 + order / _PLASTIC**2], variants)
    narrow, beyond = min(rows_px, columns_px), math.sqrt(abs(columns_px**2 - rows_px**2))
    place = _smeared(even[..., :2], narrow)
    wide_rad = turn_rad if columns_px > rows_px else turn_rad + math.pi / 2
    return place + beyond * _gaussian(even[..., 2:]) * np.array([math.sin(wide_rad), math.cos(wide_rad)])


def _shifted(axes: Sequence[Array], variants: int) -> Array:
    """Places in a cube of side 1, with shifted copies of them, shape (variants, n, axes)."""
    shift = np.random.Generator(np.random.SFC64(1)).random((variants, 1, len(axes)))
    return np.mod(np.mod(np.stack(axes, axis=1), 1.0) + shift, 1.0)


def _gaussian(even: Array) -> Array:
    """Places of a Gaussian of the standard deviation 1, of parts of it from 0 to 1, any shape."""
    grid = np.linspace(-6, 6, 40_001)
    below = np.cumsum(np.exp(-(grid**2) / 2))
    return np.asarray(np.interp(even, (below - 0.5 * np.exp(-(grid**2) / 2)) / below[-1], grid))


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
