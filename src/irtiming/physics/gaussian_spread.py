"""Points of light that a Gaussian spreads over the pixels around them."""

import math
from functools import lru_cache
from typing import Any, NamedTuple, final

import numpy as np
from numba import njit
from scipy.special import ndtr

from irtiming.records.arrays import Array, ComplexArray
from irtiming.records.blur import Blur

REACH = 5.0
"""Blurs beyond which no light comes."""

_LEFT_OUT = 1e-6  # by the series in the correlation, of terms that are a tenth of a point's light at most
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
    spread = np.asarray(_deposit(places, light, blur, widening, size, _series(blur.correlation)))
    return np.asarray(spread[: len(values)] + 1j * spread[len(values) :])


@njit(cache=True, nogil=True)
def _below(at: float) -> float:
    """Part of a Gaussian about zero below a place, counted in steps of the table from its beginning, less a half; to 1e-11."""
    inside = min(max(at, 0.0), 2.0 * _TABLE_END * _TABLE_STEPS)
    k = int(inside)
    on = inside - k
    return float(_GAUSSIAN[k, 0] + on * (_GAUSSIAN[k, 1] + on * (_GAUSSIAN[k, 2] + on * _GAUSSIAN[k, 3])))


@njit(cache=True, nogil=True)
def _density(at: float) -> float:
    """Of the Gaussian at a place that is counted in the same way, per standard deviation: the slope of `_below`; to 1e-8."""
    inside = min(max(at, 0.0), 2.0 * _TABLE_END * _TABLE_STEPS)
    k = int(inside)
    on = inside - k
    return float(_TABLE_STEPS * (_GAUSSIAN[k, 1] + on * (2 * _GAUSSIAN[k, 2] + on * 3 * _GAUSSIAN[k, 3])))


@final
class _Series(NamedTuple):
    """The series in the correlation r, for compiled code: weights r^k / k of its terms, the first of which is 1.

    Hermite functions h_k, derivatives of the density over the root of k!, follow from those before by ``up`` and ``back``:
    h_0 is the density, h_k = up_k x h_(k - 1) - back_k h_(k - 2).
    """

    weight: Array
    up: Array
    back: Array


@lru_cache(maxsize=16)
def _series(correlation: float) -> _Series:
    """As many terms as it takes; a search asks for few correlations."""
    n_terms = 1
    while abs(correlation) ** n_terms > n_terms * (1 - abs(correlation)) * _LEFT_OUT:
        n_terms += 1
    order = np.maximum(np.arange(n_terms), 1)
    weight = np.where(np.arange(n_terms) == 0, 1.0, correlation**order / order)
    return _Series(weight=weight, up=1 / np.sqrt(order), back=np.sqrt((order - 1) / order))


@njit(cache=True, nogil=True)
def _along_axis(x: float, width: float, n: int, series: _Series, room: Array, out: Array) -> None:
    """Part of a standard Gaussian that falls into each pixel, and what the Hermite functions gain across it, from 0 on.

    The first of ``n`` pixels begins at ``x``; ``out`` is filled, with ``room`` for one more, shapes (n_terms, n or more).
    """
    at, pixel = (x + _TABLE_END) * _TABLE_STEPS, width * _TABLE_STEPS
    below = _below(at)
    for j in range(n):
        above = _below(at + (j + 1) * pixel)
        out[0, j] = above - below
        below = above
    if len(out) == 1:
        return
    for j in range(n + 1):
        room[0, j], room[1, j] = 0.0, _density(at + j * pixel)
    for k in range(1, len(out)):
        for j in range(n):
            out[k, j] = room[k, j + 1] - room[k, j]
        if k + 1 < len(out):
            up, back = series.up[k], series.back[k]
            for j in range(n + 1):
                room[k + 1, j] = (x + j * width) * up * room[k, j] - back * room[k - 1, j]


@njit(cache=True, nogil=True)
def _deposit(
    places: tuple[Array, Array], light: Array, blur: Blur, widening: Array, size: tuple[int, int], series: _Series
) -> Any:
    """See deposit; light (n, 2 k) and what it becomes, shape (2 k, *size), real parts before imaginary ones.

    By the tetrachoric series (Pearson, Phil. Trans. R. Soc. A 195 (1900) 1) a Gaussian with correlation r has, between two
    places x in rows and two y in columns, in standard deviations,

        Phi(x) Phi(y) + sum over k >= 1 of r^k / k h_(k - 1)(x) h_(k - 1)(y)

    with the differences that Phi and h have between the two.
    """
    (row, column), (n_row, n_column), n_terms, n = places, size, series.weight.size, light.shape[1]
    out = np.zeros((n, n_row, n_column))
    down, across, line = np.empty((n_terms, n_row)), np.empty((n_terms, n_column)), np.empty(n_column)
    room = np.empty((n_terms, max(n_row, n_column) + 1))
    for point in range(row.size):
        rows_px, columns_px = blur.rows_px * widening[point], blur.columns_px * widening[point]
        reach, beside = REACH * rows_px + 0.5, REACH * columns_px + 0.5
        first_row, last_row = max(0, math.ceil(row[point] - reach)), min(n_row - 1, math.floor(row[point] + reach))
        first, last = max(0, math.ceil(column[point] - beside)), min(n_column - 1, math.floor(column[point] + beside))
        if first_row > last_row or first > last:
            continue
        n_down, n_across = last_row - first_row + 1, last - first + 1
        _along_axis((first_row - 0.5 - row[point]) / rows_px, 1 / rows_px, n_down, series, room, down)
        _along_axis((first - 0.5 - column[point]) / columns_px, 1 / columns_px, n_across, series, room, across)
        for i in range(n_down):
            share = down[0, i]
            for j in range(n_across):
                line[j] = share * across[0, j]
            for k in range(1, n_terms):
                share = series.weight[k] * down[k, i]
                for j in range(n_across):
                    line[j] += share * across[k, j]
            for part in range(n):
                amount, pixels = light[point, part], out[part, first_row + i]
                for j in range(n_across):
                    pixels[first + j] += amount * line[j]
    return out
