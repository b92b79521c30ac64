"""The compiled inner loops that turn frames into the scene; each reads every raw pixel once, in the order of memory.

A frame is worked through in bands of `TILE` rows, so that what a band takes stays in the processor's cache from the correction to
the interpolation. Pixels are float32 between: 24 bits hold every count of 16 bits and eight more.
"""

import numpy as np
from numba import njit

TILE = 8
"""Rows and columns of the tiles that have a gain each."""


@njit(cache=True, fastmath=True, nogil=True)
def correct(
    frame: np.ndarray,
    memory: np.ndarray,
    numbers: np.ndarray,
    noise_power: float,
    gains: np.ndarray,
    corrected: np.ndarray,
) -> None:
    """One frame as the scene that the pixels saw, each tile as far as its correction stands out of the noise.

    Parameters
    ----------
    frame
        Shape (row, column), counts of any kind.
    memory
        Shape (3, row, column), float32: the frame before, what its pixels saw, and the scene; this frame's are left there.
    numbers
        Shape (1 or n, 6), float32: share of the filter; e, a, b of the lag, in n steps of the pixel's value; the lowest of these
        values, and the steps per unit of value.
    noise_power
        Variance that noise alone gives the correction, plus its covariance with the frame.
    gains
        Shape (tile row, tile column), float32; filled with the Wiener gain of each tile.
    corrected
        Shape (row, column), float32; filled.
    """
    n_rows, n_columns = frame.shape
    is_plain = numbers.shape[0] == 1 and numbers[0, 0] == 0  # the frame before is what its pixels saw: one is enough
    power, gain = np.empty(n_columns, np.float32), np.empty(n_columns, np.float32)
    for band in range(gains.shape[0]):
        first, end = band * TILE, min(n_rows, (band + 1) * TILE)
        power[:] = 0
        for row in range(first, end):
            if numbers.shape[0] == 1 and is_plain:
                _invert_plain(frame[row], memory[1, row], memory[2, row], numbers[0], corrected[row])
            elif numbers.shape[0] == 1:
                _invert(frame[row], memory[0, row], memory[1, row], memory[2, row], numbers[0], corrected[row])
            else:
                _invert_by_value(frame[row], memory[0, row], memory[1, row], memory[2, row], numbers, corrected[row])
            _add_squares(corrected[row], power)
        for tile in range(gains.shape[1]):
            left, right = tile * TILE, min(n_columns, (tile + 1) * TILE)
            mean = power[left:right].sum() / np.float32((end - first) * (right - left))
            gains[band, tile] = max(0.0, 1 - noise_power / mean) if mean > 0 else 0.0
            gain[left:right] = gains[band, tile]
        for row in range(first, end):
            _blend(memory[1 if is_plain else 0, row], gain, corrected[row])


@njit(cache=True, fastmath=True, nogil=True)
def _invert(
    values: np.ndarray, last: np.ndarray, pixel: np.ndarray, scene: np.ndarray, numbers: np.ndarray, change: np.ndarray
) -> None:
    """One row: s = (x - e x' - a s') / b with x = (y - k y') / (1 - k), all (column,); ``change`` becomes s - y.

    Loops are short, since the compiler packs numbers of a loop only where few arrays could overlap.
    """
    share, decay, before = numbers[0], numbers[1], numbers[2]
    open_share, over_now = np.float32(1) / (np.float32(1) - share), np.float32(1) / numbers[3]
    n = len(values)
    for k in range(n):
        last[k] = (np.float32(values[k]) - share * last[k]) * open_share
    for k in range(n):
        scene[k] = (last[k] - decay * pixel[k] - before * scene[k]) * over_now
    for k in range(n):
        pixel[k] = last[k]
    for k in range(n):
        last[k] = np.float32(values[k])
    for k in range(n):
        change[k] = scene[k] - last[k]


@njit(cache=True, fastmath=True, nogil=True)
def _invert_plain(
    values: np.ndarray, pixel: np.ndarray, scene: np.ndarray, numbers: np.ndarray, change: np.ndarray
) -> None:
    """The same without a filter, all (column,): a third less to read and write."""
    decay, before, over_now = numbers[1], numbers[2], np.float32(1) / numbers[3]
    n = len(values)
    for k in range(n):
        scene[k] = (np.float32(values[k]) - decay * pixel[k] - before * scene[k]) * over_now
    for k in range(n):
        pixel[k] = np.float32(values[k])
    for k in range(n):
        change[k] = scene[k] - pixel[k]


@njit(cache=True, fastmath=True, nogil=True)
def _invert_by_value(
    values: np.ndarray, last: np.ndarray, pixel: np.ndarray, scene: np.ndarray, numbers: np.ndarray, change: np.ndarray
) -> None:
    """The same where e, a and b depend on the value half way from the frame before; ``numbers`` (step of values, 6)."""
    share, lowest, per_value = numbers[0, 0], numbers[0, 4], numbers[0, 5]
    open_share, most = np.float32(1) / (np.float32(1) - share), np.float32(numbers.shape[0] - 1)
    for k in range(len(values)):
        value = np.float32(values[k])
        observed = (value - share * last[k]) * open_share
        place = ((observed + pixel[k]) * np.float32(0.5) - lowest) * per_value + np.float32(0.5)
        at = int(min(max(place, np.float32(0)), most))
        scene[k] = (observed - numbers[at, 1] * pixel[k] - numbers[at, 2] * scene[k]) / numbers[at, 3]
        pixel[k], last[k] = observed, value
        change[k] = scene[k] - value


@njit(cache=True, fastmath=True, nogil=True)
def _add_squares(values: np.ndarray, total: np.ndarray) -> None:
    """Add the square of each value, both (column,)."""
    for k in range(len(values)):
        total[k] += values[k] * values[k]


@njit(cache=True, fastmath=True, nogil=True)
def _blend(frame: np.ndarray, gain: np.ndarray, change: np.ndarray) -> None:
    """``change`` becomes the frame plus gain times change, all (column,)."""
    for k in range(len(frame)):
        change[k] = frame[k] + gain[k] * change[k]


@njit(cache=True, fastmath=True, nogil=True)
def interpolate(
    knots: np.ndarray, order: np.ndarray, starts: np.ndarray, weights: np.ndarray, scene: np.ndarray
) -> None:
    """Each row between its readings, at one instant; float32.

    Parameters
    ----------
    knots
        Shape (n_knot, row, column), float32: the latest frames in a ring.
    order
        Shape (n_used,): places of the frames in the ring, the earliest first.
    starts
        Shape (row,): first of the four frames of ``order`` that a row takes.
    weights
        Shape (row, 4), float32.
    scene
        Shape (row, column), float32; filled.
    """
    n_last = len(order) - 1
    for row in range(scene.shape[0]):
        at, out = starts[row], scene[row]
        one, two = knots[order[at], row], knots[order[min(at + 1, n_last)], row]
        three, four = knots[order[min(at + 2, n_last)], row], knots[order[min(at + 3, n_last)], row]
        a, b, c, d = weights[row, 0], weights[row, 1], weights[row, 2], weights[row, 3]
        for column in range(scene.shape[1]):
            out[column] = a * one[column] + b * two[column] + c * three[column] + d * four[column]


@njit(cache=True, fastmath=True, nogil=True)
def to_counts(scene: np.ndarray, highest: int, counts: np.ndarray) -> None:
    """Rounded to whole counts from 0 to ``highest``; both (row, column)."""
    top = np.float32(highest)
    for row in range(scene.shape[0]):
        values, out = scene[row], counts[row]
        for column in range(scene.shape[1]):
            value = values[column] + np.float32(0.5)
            out[column] = np.uint16(min(max(value, np.float32(0)), top))
