"""Points of light that a Gaussian spreads over the pixels around them."""

import math
from typing import Any

import numpy as np
from numba import njit
from scipy.special import ndtr

from irtiming.records.arrays import Array, ComplexArray

REACH = 5.0
"""Blurs beyond which no light comes."""

_TABLE_END, _TABLE_STEPS = 7, 128  # of the Gaussian's integral, in and per standard deviation
_TABLE_PLACES = np.arange(-_TABLE_END * _TABLE_STEPS, _TABLE_END * _TABLE_STEPS + 2) / _TABLE_STEPS
_GAUSSIAN = np.stack(
    [ndtr(_TABLE_PLACES) - 0.5, np.exp(-(_TABLE_PLACES**2) / 2) / (math.sqrt(2 * np.pi) * _TABLE_STEPS)], axis=1
)
"""Its integral from zero on, and how much that grows in a step of the table: cubics in between."""


def deposit(
    places: tuple[Array, Array], values: ComplexArray, *, blur: tuple[float, float], size: tuple[int, int]
) -> ComplexArray:
    """Light of each point, spread over the pixels around it, in several images of the same points; shape (k, *size).

    Parameters
    ----------
    places
        Rows and columns, px from the middle of the first pixel, shapes (n,).
    values
        Light of each point in each image, shape (k, n).
    blur
        Standard deviations over rows and over columns, px.
    size
        Number of rows and of columns.
    """
    light = np.ascontiguousarray(np.concatenate([values.real, values.imag]).T)
    spread = np.asarray(_deposit(*places, light, blur, size))
    return np.asarray(spread[: len(values)] + 1j * spread[len(values) :])


@njit(cache=True, nogil=True)
def _below(place: float) -> float:
    """Part of a Gaussian about zero below a place in units of its standard deviation, less a half; to 1e-11."""
    at = (place + _TABLE_END) * _TABLE_STEPS
    k = int(min(max(at, 0.0), 2.0 * _TABLE_END * _TABLE_STEPS))
    on = min(max(at - k, 0.0), 1.0)
    low, high, slope, next_slope = _GAUSSIAN[k, 0], _GAUSSIAN[k + 1, 0], _GAUSSIAN[k, 1], _GAUSSIAN[k + 1, 1]
    rise = high - low
    return float(low + on * (slope + on * (3 * rise - 2 * slope - next_slope + on * (slope + next_slope - 2 * rise))))


@njit(cache=True, nogil=True)
def _along_axis(place: float, first: int, last: int, blur: float, out: Array) -> None:
    """Part of a Gaussian about a place that falls into each of these pixels."""
    below = _below((first - 0.5 - place) / blur)
    for j in range(first, last + 1):
        above = _below((j + 0.5 - place) / blur)
        out[j] = above - below
        below = above


@njit(cache=True, nogil=True)
def _deposit(row: Array, column: Array, light: Array, blur: tuple[float, float], size: tuple[int, int]) -> Any:
    """See deposit; light (n, 2 k) and what it becomes, shape (2 k, *size), real parts before imaginary ones."""
    n_row, n_column = size
    n = light.shape[1]
    out = np.zeros((n, n_row, n_column))
    down, across = np.empty(n_row), np.empty(n_column)
    reach, beside = REACH * blur[0] + 0.5, REACH * blur[1] + 0.5
    for k in range(row.size):
        first_row, last_row = max(0, math.ceil(row[k] - reach)), min(n_row - 1, math.floor(row[k] + reach))
        first, last = max(0, math.ceil(column[k] - beside)), min(n_column - 1, math.floor(column[k] + beside))
        _along_axis(row[k], first_row, last_row, blur[0], down)
        _along_axis(column[k], first, last, blur[1], across)
        for i in range(first_row, last_row + 1):
            for part in range(n):
                along = light[k, part] * down[i]
                for j in range(first, last + 1):
                    out[part, i, j] += along * across[j]
    return out
