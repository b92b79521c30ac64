"""One frame of any file, for the eye."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.archive.frames.opening import open_frames
from irtiming.archive.scene_file import made_from
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Array, read_only
from irtiming.records.frame_view import PairOrder, ViewOrder


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class FrameView:
    """A frame in grey, shape (row, column), uint8, from its lowest values (black) to its highest (white).

    ``index`` is that of the frame, of ``n_frames``; ``lowest`` and ``highest`` are the values that black and white stand for.
    """

    grey: Array
    index: int
    n_frames: int
    lowest: float
    highest: float


def view(order: ViewOrder) -> FrameView:
    """The frame.

    Raises
    ------
    ArchiveError
        If the file cannot be read, or has no such frame.
    """
    source = open_frames(order.path)
    n_frames = source.shape[0]
    index = n_frames // 2 if order.index < 0 else order.index
    if index >= n_frames:
        raise ArchiveError(f"has {n_frames} frames, frame {index} is not among them", where=str(order.path))
    frame = np.nan_to_num(np.asarray(source.pick([index])[0], float))
    step = max(1, -(-frame.shape[1] // order.widest_px))
    small = frame[::step, ::step]
    low, high = order.levels or (float(np.percentile(small, 0.5)), float(np.percentile(small, 99.5)))
    grey = np.clip((small - low) * (255 / (high - low if high > low else 1.0)), 0, 255).astype(np.uint8)
    return FrameView(grey=read_only(grey), index=index, n_frames=n_frames, lowest=low, highest=high)


@final
@dataclass(frozen=True, kw_only=True)
class Pair:
    """A frame as it came and as it was made, with the same values for black and white; ``index`` is that in the scene."""

    before: FrameView
    after: FrameView
    index: int


def pair(order: PairOrder) -> Pair:
    """The frame of the scene, and the one that it was made from.

    Raises
    ------
    ArchiveError
        If a file cannot be read, or the second is no scene.
    """
    numbers = made_from(order.after)
    index = numbers.size // 2 if order.index < 0 else min(order.index, numbers.size - 1)
    first = view(ViewOrder(path=order.before, index=int(numbers[index]), widest_px=order.widest_px))
    levels = (first.lowest, first.highest)
    second = view(ViewOrder(path=order.after, index=index, widest_px=order.widest_px, levels=levels))
    return Pair(before=first, after=second, index=index)
