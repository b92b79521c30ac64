"""One pass over a stack of frames: range of each, clipped pixels, dead and repeated frames, light of each part of the image."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.records.arrays import Array, Pixels, Ticks
from irtiming.records.recording import FrameStack

_TILES_DOWN, _TILES_ACROSS = 6, 8


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class FrameSurvey:
    """What a pass over the frames found.

    Shapes (n_frame,): ``lowest_dn``, ``highest_dn``. ``saturated_share`` and ``zero_share`` are the shares of
    all pixel values at the highest value of the readout or above, and at 0. ``dead_frames`` have one value in
    all pixels, ``repeated_frames`` equal the frame before; both are indices of frames. ``tiles_dn`` is the mean value of each
    tile of the image, shape (n_frame, tiles down, tiles across).
    """

    lowest_dn: Array
    highest_dn: Array
    saturated_share: float
    zero_share: float
    dead_frames: Ticks
    repeated_frames: Ticks
    tiles_dn: Array


def survey(frames: FrameStack, *, bit_depth: int, progress: Callable[[int, int], None] | None = None) -> FrameSurvey:
    """Look at every frame once; one block is in memory at a time.

    Parameters
    ----------
    frames
        Any stack, DN.
    bit_depth
        Bits of a pixel value: the highest value is 2 ** bit_depth - 1.
    progress
        Called with frames read and all frames after each block.

    Raises
    ------
    ArchiveError
        If a frame of a file cannot be read.
    """
    n_frames, rows, columns = frames.shape
    highest = 2**bit_depth - 1
    lowest_dn, highest_dn = np.zeros(n_frames), np.zeros(n_frames)
    n_saturated = n_zero = 0
    tiles_dn = np.zeros((n_frames, min(rows, _TILES_DOWN), min(columns, _TILES_ACROSS)))
    repeated: list[int] = []
    previous: Pixels | None = None
    for first, block in frames.blocks():
        last = first + len(block)
        lowest_dn[first:last] = block.min(axis=(1, 2))
        highest_dn[first:last] = block.max(axis=(1, 2))
        for index in range(first, last):
            frame = block[index - first]
            tiles_dn[index] = _tiles(frame, tiles_dn.shape[1:])
            n_saturated += int(np.count_nonzero(frame >= highest)) if highest_dn[index] >= highest else 0
            n_zero += int(np.count_nonzero(frame == 0)) if lowest_dn[index] == 0 else 0
            if previous is not None and _equal(frame, previous):
                repeated.append(index)
            previous = frame
        previous = block[-1].copy()
        if progress is not None:
            progress(last, n_frames)
    n_values = n_frames * rows * columns
    return FrameSurvey(
        lowest_dn=lowest_dn,
        highest_dn=highest_dn,
        saturated_share=n_saturated / n_values,
        zero_share=n_zero / n_values,
        dead_frames=np.flatnonzero(lowest_dn == highest_dn).astype(np.int64),
        repeated_frames=np.array(repeated, dtype=np.int64),
        tiles_dn=tiles_dn,
    )


def _tiles(frame: Pixels, tiles: tuple[int, ...]) -> Array:
    """Mean value of each of so many tiles down and across; rows and columns beyond the last whole tile are left out."""
    down, across = tiles
    high, wide = frame.shape[0] // down, frame.shape[1] // across
    cut = frame[: down * high, : across * wide].reshape(down, high, across, wide)
    return np.asarray(cut.sum(axis=(1, 3), dtype=np.float64) / (high * wide))


def _equal(frame: Pixels, previous: Pixels) -> bool:
    middle = len(frame) // 2
    return bool(np.array_equal(frame[middle], previous[middle]) and np.array_equal(frame, previous))
