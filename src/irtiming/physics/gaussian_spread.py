"""Points of light that a Gaussian spreads over the pixels around them."""

import math
from typing import Any

import numpy as np
from numba import njit
from scipy.special import ndtr

from irtiming.records.arrays import Array, ComplexArray
from irtiming.records.blur import Blur

REACH = 5.0
"""Blurs beyond which no light comes."""

_TABLE_END, _TABLE_STEPS = 7, 128  # of the Gaussian's integral, in and per standard deviation


def _cubics() -> Array:
    """Coefficients of the cubic in each step of the table, by Hermite: the Gaussian's integral from zero on, shape (n, 4)."""
    place = np.arange(-_TABLE_END * _TABLE_STEPS, _TABLE_END * _TABLE_STEPS + 2) / _TABLE_STEPS
    value, slope = ndtr(place) - 0.5, np.exp(-(place**2) / 2) / (math.sqrt(2 * np.pi) * _TABLE_STEPS)
    rise, first, last = np.diff(value), slope[:-1], slope[1:]
    return np.stack([value[:-1], first, 3 * rise - 2 * first - last, first + last - 2 * rise], axis=1)


_GAUSSIAN = _cubics()


def deposit(
    places: tuple[Array, Array], values: ComplexArray, *, blur: Blur, widening: Array, size: tuple[int, int]
) -> ComplexArray:
    """Light of each point, spread over the pixels around it, in several images of the same points; shape (k, *size).

    Parameters
    ----------
    places
        Rows and columns, px from the middle of the first pixel, shapes (n,).
    values
        Light of each point in each image, shape (k, n).
    blur
        Of the image.
    widening
        By which it is wider at each point, shape (n,).
    size
        Number of rows and of columns.
    """
    light = np.ascontiguousarray(np.concatenate([values.real, values.imag]).T)
    spread = np.asarray((_deposit_askew if blur.correlation else _deposit)(*places, light, blur, widening, size))
    return np.asarray(spread[: len(values)] + 1j * spread[len(values) :])


@njit(cache=True, nogil=True)
def _below(at: float) -> float:
    """Part of a Gaussian about zero below a place, counted in steps of the table from its beginning, less a half; to 1e-11."""
    inside = min(max(at, 0.0), 2.0 * _TABLE_END * _TABLE_STEPS)
    k = int(inside)
    on = inside - k
    return float(_GAUSSIAN[k, 0] + on * (_GAUSSIAN[k, 1] + on * (_GAUSSIAN[k, 2] + on * _GAUSSIAN[k, 3])))


@njit(cache=True, nogil=True)
def _along_axis(place: float, first: int, last: int, blur: float, out: Array) -> None:
    """Part of a Gaussian about a place that falls into each of these pixels, from the beginning of ``out`` on."""
    at, pixel = ((first - 0.5 - place) / blur + _TABLE_END) * _TABLE_STEPS, _TABLE_STEPS / blur
    below = _below(at)
    for j in range(last - first + 1):
        above = _below(at + (j + 1) * pixel)
        out[j] = above - below
        below = above


@njit(cache=True, nogil=True)
def _deposit(row: Array, column: Array, light: Array, blur: Blur, widening: Array, size: tuple[int, int]) -> Any:
    """See deposit; light (n, 2 k) and what it becomes, shape (2 k, *size), real parts before imaginary ones."""
    n_row, n_column = size
    n = light.shape[1]
    out = np.zeros((n, n_row, n_column))
    down, across = np.empty(n_row), np.empty(n_column)
    for k in range(row.size):
        rows_px, columns_px = blur.rows_px * widening[k], blur.columns_px * widening[k]
        reach, beside = REACH * rows_px + 0.5, REACH * columns_px + 0.5
        first_row, last_row = max(0, math.ceil(row[k] - reach)), min(n_row - 1, math.floor(row[k] + reach))
        first, last = max(0, math.ceil(column[k] - beside)), min(n_column - 1, math.floor(column[k] + beside))
        if first_row > last_row or first > last:
            continue
        _along_axis(row[k], first_row, last_row, rows_px, down)
        _along_axis(column[k], first, last, columns_px, across)
        for part in range(n):
            for i in range(first_row, last_row + 1):
                along = light[k, part] * down[i - first_row]
                for j in range(last - first + 1):
                    out[part, i, first + j] += along * across[j]
    return out


@njit(cache=True, nogil=True)
def _density(at: float) -> float:
    """Of the Gaussian at a place that is counted in the same way, per standard deviation: the slope of `_below`; to 1e-8."""
    inside = min(max(at, 0.0), 2.0 * _TABLE_END * _TABLE_STEPS)
    k = int(inside)
    on = inside - k
    return float(_TABLE_STEPS * (_GAUSSIAN[k, 1] + on * (2 * _GAUSSIAN[k, 2] + on * 3 * _GAUSSIAN[k, 3])))


@njit(cache=True, nogil=True)
def _side(place: float) -> tuple[float, float]:
    """Part of a Gaussian below a place, less a half, and its density there, per standard deviation, as is the place."""
    at = (place + _TABLE_END) * _TABLE_STEPS
    return _below(at), _density(at)


@njit(cache=True, nogil=True)
def _deposit_askew(row: Array, column: Array, light: Array, blur: Blur, widening: Array, size: tuple[int, int]) -> Any:
    """The same of a blur that is correlated: light of one row lies about a place of its own, and is narrower there.

    Of a standard Gaussian between two ends the mean is the density at the first less that at the last, over the share; the mean
    square is 1 and as much more as the ends times those densities say.
    """
    n_row, n_column = size
    n = light.shape[1]
    out = np.zeros((n, n_row, n_column))
    across = np.empty(n_column)
    own = blur.columns_px**2 * (1 - blur.correlation**2)
    for k in range(row.size):
        rows_px, slant_px = blur.rows_px * widening[k], blur.correlation * blur.columns_px * widening[k]
        reach = REACH * rows_px + 0.5
        first_row, last_row = max(0, math.ceil(row[k] - reach)), min(n_row - 1, math.floor(row[k] + reach))
        if first_row > last_row:
            continue
        straight, slanted = own * widening[k] ** 2, slant_px**2
        high = (first_row - 0.5 - row[k]) / rows_px
        below_high, at_high = _side(high)
        for i in range(first_row, last_row + 1):
            low, at_low, below_low = high, at_high, below_high
            high = low + 1 / rows_px
            below_high, at_high = _side(high)
            share = below_high - below_low
            nearest = max(low, -high, 0.0)
            if nearest >= REACH or share <= 0:
                continue
            mean = (at_low - at_high) / share
            variance = max(0.0, 1 + (low * at_low - high * at_high) / share - mean**2)
            place, width = column[k] + slant_px * mean, math.sqrt(straight + slanted * variance)
            beside = width * math.sqrt(REACH**2 - nearest**2) + 0.5  # the ends of an ellipse
            first, last = max(0, math.ceil(place - beside)), min(n_column - 1, math.floor(place + beside))
            if first > last:
                continue
            _along_axis(place, first, last, width, across)
            for part in range(n):
                along = light[k, part] * share
                for j in range(last - first + 1):
                    out[part, i, first + j] += along * across[j]
    return out
