"""The compiled inner loops of the reduction; each reads every raw pixel once, in the order of memory.

Frames, or pixels, are shared among threads where that pays: not in loops that take less time than a thread needs to wake up.
Sums over a row stay in the narrowest type that holds them: sixteen pixels then fit one vector register where eight bytes per
count would fit four, and memory, not arithmetic, sets the pace. For the same reason frames go four at a time where each pixel is
compared with something of its own, or added to it: that is then read once for four. Frames in a GPU's memory are left to the
loops of `array_kernels`.
"""

from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numba import njit, prange

from irtiming.records.arrays import Array, Mask, Pixels, Ticks
from irtiming.reduce import array_kernels

_TILE = 512  # pixels

_Given = ParamSpec("_Given")
_Found = TypeVar("_Found")


def _or_on_a_gpu(compiled: Callable[_Given, _Found]) -> Callable[_Given, _Found]:
    """The compiled loop, or its namesake where the frames, which come first, are not in this machine's memory."""
    elsewhere: Callable[_Given, _Found] = getattr(array_kernels, compiled.__name__)

    @wraps(compiled)
    def loop(*given: Any, **named: Any) -> _Found:
        return (compiled if isinstance(given[0], np.ndarray) else elsewhere)(*given, **named)

    return loop


@_or_on_a_gpu
@njit(parallel=True, cache=True)
def count_above(frames: Pixels, thresholds: Pixels) -> Ticks:
    """Pixels above their own threshold in each frame.

    Parameters
    ----------
    frames
        Shape (frame, row, column), at most 65535 columns.
    thresholds
        Shape (row, column).

    Returns
    -------
    Shape (frame,).
    """
    n_frames, n_rows, n_columns = frames.shape
    counts = np.zeros(n_frames, np.int64)
    last = n_frames - 1
    for four in prange(-(-n_frames // 4)):
        a = 4 * four  # where there are not as many, the last one again
        b, c, d = min(a + 1, last), min(a + 2, last), min(a + 3, last)
        in_a, in_b, in_c, in_d = 0, 0, 0, 0
        for row in range(n_rows):
            of_a, of_b, of_c, of_d = frames[a, row], frames[b, row], frames[c, row], frames[d, row]
            limit = thresholds[row]
            n_a, n_b, n_c, n_d = np.uint16(0), np.uint16(0), np.uint16(0), np.uint16(0)
            for column in range(n_columns):
                least = limit[column]
                n_a = np.uint16(n_a + np.uint16(of_a[column] > least))
                n_b = np.uint16(n_b + np.uint16(of_b[column] > least))
                n_c = np.uint16(n_c + np.uint16(of_c[column] > least))
                n_d = np.uint16(n_d + np.uint16(of_d[column] > least))
            in_a, in_b, in_c, in_d = in_a + n_a, in_b + n_b, in_c + n_c, in_d + n_d
        counts[a], counts[b], counts[c], counts[d] = in_a, in_b, in_c, in_d
    return counts


@_or_on_a_gpu
@njit(parallel=True, cache=True, fastmath=True)
def weighted_sum(frames: Pixels, weights: np.ndarray) -> Array:
    """Sum of weight times value over each frame, shape (frame,); weights float32 (row, column)."""
    n_frames, n_rows, n_columns = frames.shape
    sums = np.zeros(n_frames, np.float64)
    for frame in prange(n_frames):
        total = 0.0
        for row in range(n_rows):
            values, weight = frames[frame, row], weights[row]
            part = np.float32(0)
            for column in range(n_columns):
                part += weight[column] * np.float32(values[column])
            total += part
        sums[frame] = total
    return sums


@_or_on_a_gpu
@njit(cache=True)
def count_at_limits(frames: Pixels, full_scale: int, every: int = 1) -> Ticks:
    """Pixels at zero and at full scale in each frame (frame, row, column), looking at every nth row, shape (2, frame)."""
    n_frames, n_rows, n_columns = frames.shape
    counts = np.zeros((2, n_frames), np.int64)
    top = np.uint16(full_scale)
    for frame in range(n_frames):
        for row in range(0, n_rows, every):
            values = frames[frame, row]
            zeros, full = np.uint16(0), np.uint16(0)
            for column in range(n_columns):
                zeros = np.uint16(zeros + np.uint16(values[column] == np.uint16(0)))
                full = np.uint16(full + np.uint16(values[column] >= top))
            counts[0, frame] += zeros
            counts[1, frame] += full
    return counts


@_or_on_a_gpu
@njit(cache=True)
def sum_within(frames: Pixels, taken: Pixels, every: int = 1) -> Ticks:
    """Sum of the taken pixels of every nth row, shape (frame, nth row).

    ``frames`` (frame, row, column), at most 65537 columns; ``taken`` (nth row, column) has all bits set where a pixel is taken,
    none elsewhere.
    """
    n_frames, _, n_columns = frames.shape
    sums = np.zeros((n_frames, taken.shape[0]), np.int64)
    for frame in range(n_frames):
        for row in range(taken.shape[0]):
            values, bits = frames[frame, row * every], taken[row]
            total = np.uint32(0)
            for column in range(n_columns):
                total = np.uint32(total + np.uint32(values[column] & bits[column]))
            sums[frame, row] = total
    return sums


@_or_on_a_gpu
@njit(cache=True, fastmath=True)
def weighted_row_sum(frames: Pixels, weights: np.ndarray, every: int = 1) -> Array:
    """Sum of weight times value over every nth row, shape (frame, nth row).

    ``frames`` (frame, row, column); ``weights`` float32 (nth row, column).
    """
    n_frames, _, n_columns = frames.shape
    sums = np.zeros((n_frames, weights.shape[0]), np.float64)
    for frame in range(n_frames):
        for row in range(weights.shape[0]):
            values, weight = frames[frame, row * every], weights[row]
            total = np.float32(0)
            for column in range(n_columns):
                total += weight[column] * np.float32(values[column])
            sums[frame, row] = total
    return sums


@_or_on_a_gpu
@njit(cache=True)
def repeats(frames: Pixels, before: Pixels) -> Mask:
    """Which frames are, bit by bit, the one before them, shape (frame,); ``before`` (row, column) precedes the first."""
    n_frames, n_rows, n_columns = frames.shape
    same = np.ones(n_frames, np.bool_)
    for frame in range(n_frames):
        last = frames[frame - 1] if frame > 0 else before
        for row in range(n_rows):
            now, then = frames[frame, row], last[row]
            for column in range(n_columns):
                if now[column] != then[column]:
                    same[frame] = False
                    break
            if not same[frame]:
                break
    return same


@_or_on_a_gpu
@njit(cache=True, fastmath=True)
def add_projection(frames: Pixels, cosine: Array, sine: Array, into: Array) -> None:
    """Add cosine[frame] * value, sine[frame] * value and value to ``into``, shape (3, row, column), in double precision."""
    n_frames, n_rows, n_columns = frames.shape
    for row in range(n_rows):
        along, across, plain = into[0, row], into[1, row], into[2, row]
        for a in range(0, n_frames - 3, 4):
            b, c, d = a + 1, a + 2, a + 3
            of_a, of_b, of_c, of_d = frames[a, row], frames[b, row], frames[c, row], frames[d, row]
            for column in range(n_columns):
                in_a, in_b = np.float64(of_a[column]), np.float64(of_b[column])
                in_c, in_d = np.float64(of_c[column]), np.float64(of_d[column])
                along[column] += (cosine[a] * in_a + cosine[b] * in_b) + (cosine[c] * in_c + cosine[d] * in_d)
                across[column] += (sine[a] * in_a + sine[b] * in_b) + (sine[c] * in_c + sine[d] * in_d)
                plain[column] += (in_a + in_b) + (in_c + in_d)
        for frame in range(n_frames - n_frames % 4, n_frames):
            values, c, s = frames[frame, row], cosine[frame], sine[frame]
            for column in range(n_columns):
                value = np.float64(values[column])
                along[column] += c * value
                across[column] += s * value
                plain[column] += value


@_or_on_a_gpu
@njit(cache=True)
def gather(frames: Pixels, spans: Ticks, into: Pixels) -> None:
    """Copy spans of pixels, shape (span, 3) with row, first and end column, side by side into ``into`` (frame, pixel)."""
    for frame in range(frames.shape[0]):
        place = 0
        for span in range(spans.shape[0]):
            row, first, end = spans[span]
            n_pixels = end - first
            values, copies = frames[frame, row, first:end], into[frame, place : place + n_pixels]
            for pixel in range(n_pixels):
                copies[pixel] = values[pixel]
            place += n_pixels


@_or_on_a_gpu
@njit(parallel=True, cache=True, fastmath=True)
def add_waves(values: Pixels, weights: np.ndarray, base: np.ndarray, into: np.ndarray) -> None:
    """Add weights (wave, frame) times values (frame, pixel) less ``base`` (pixel,) to ``into`` (wave, pixel); all float32.

    Some hundred pixels at a time become numbers with a point, which stay near the processor while every wave is done.
    """
    n_frames, n_pixels = values.shape
    for number in prange(-(-n_pixels // _TILE)):
        first, end = number * _TILE, min((number + 1) * _TILE, n_pixels)
        tile = np.empty((n_frames, end - first), np.float32)
        for frame in range(n_frames):
            here, less, row = values[frame, first:end], base[first:end], tile[frame]
            for pixel in range(end - first):
                row[pixel] = np.float32(here[pixel]) - less[pixel]
        part = np.dot(weights, tile)
        for wave in range(weights.shape[0]):
            total, more = into[wave, first:end], part[wave]
            for pixel in range(end - first):
                total[pixel] += more[pixel]
