"""The inner loops of the reduction in the words of the array API standard, for frames that are in the memory of a GPU.

Each gives what its namesake among the compiled loops gives: whole numbers exactly, sums of weighted values to the rounding of the
same width. What comes back, a number per frame or row, is in this machine's memory; what pixels are added to is where they are.
"""

import numpy as np
from array_api_compat import array_namespace

from irtiming.records.arrays import Array, Mask, Pixels, Ticks
from irtiming.reduce.device_memory import to_host


def count_above(frames: Pixels, thresholds: Pixels) -> Ticks:
    """Pixels above their own threshold in each frame, shape (frame,)."""
    xp = array_namespace(frames)
    return to_host(xp.count_nonzero(frames > xp.asarray(thresholds), axis=(1, 2)))


def weighted_sum(frames: Pixels, weights: np.ndarray) -> Array:
    """Sum of weight times value over each frame, shape (frame,)."""
    return np.asarray(weighted_row_sum(frames, weights).sum(axis=1))


def count_at_limits(frames: Pixels, full_scale: int, every: int = 1) -> Ticks:
    """Pixels at zero and at full scale in each frame, looking at every nth row, shape (2, frame)."""
    xp = array_namespace(frames)
    some = frames[:, ::every, :]
    at_ends = (some == 0, some >= full_scale)
    return np.stack([to_host(xp.count_nonzero(at_end, axis=(1, 2))) for at_end in at_ends])


def sum_within(frames: Pixels, taken: Pixels, every: int = 1) -> Ticks:
    """Sum of the taken pixels of every nth row, shape (frame, nth row)."""
    xp = array_namespace(frames)
    some = frames[:, ::every, :] & xp.asarray(taken)
    bits = xp.astype(some, xp.uint32)  # of one width throughout, which GPUs add up fastest
    return to_host(xp.sum(bits, axis=2, dtype=xp.uint32)).astype(np.int64)


def weighted_row_sum(frames: Pixels, weights: np.ndarray, every: int = 1) -> Array:
    """Sum of weight times value over every nth row, shape (frame, nth row)."""
    xp = array_namespace(frames)
    sums = xp.sum(xp.astype(frames[:, ::every, :], xp.float32) * xp.asarray(weights), axis=2)
    return to_host(xp.astype(sums, xp.float64))


def repeats(frames: Pixels, before: Pixels) -> Mask:
    """Which frames are, bit by bit, the one before them, shape (frame,)."""
    xp = array_namespace(frames)
    then = xp.concat([before[None, ...], frames[:-1, ...]])
    return to_host(xp.all(frames == then, axis=(1, 2)))


def add_projection(frames: Pixels, cosine: Array, sine: Array, into: Array) -> None:
    """Add cosine[frame] * value, sine[frame] * value and value to ``into``, shape (3, row, column), which is where frames are."""
    xp = array_namespace(frames)
    weights = xp.asarray(np.stack([cosine, sine, np.ones(len(cosine))]))
    lines = xp.reshape(xp.astype(frames, xp.float64), (frames.shape[0], -1))
    into += xp.reshape(weights @ lines, into.shape)


def gather(frames: Pixels, spans: Ticks, into: Pixels) -> None:
    """Copy spans of pixels side by side into ``into`` (frame, pixel), which is where the frames are."""
    xp, n_columns = array_namespace(frames), frames.shape[2]
    place = np.concatenate([np.arange(row * n_columns + first, row * n_columns + end) for row, first, end in spans])
    into[:, :] = xp.take(xp.reshape(frames, (frames.shape[0], -1)), xp.asarray(place), axis=1)


def add_waves(values: Pixels, weights: np.ndarray, base: np.ndarray, into: np.ndarray) -> None:
    """Add weights (wave, frame) times values (frame, pixel) less ``base`` (pixel,) to ``into``; but weights, all on the GPU."""
    xp = array_namespace(values)
    into += xp.asarray(weights) @ (xp.astype(values, xp.float32) - base)
