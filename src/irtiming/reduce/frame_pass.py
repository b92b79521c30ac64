"""The single pass over the frames of a recording: it feeds accumulators, each of which gathers one thing.

Accumulators of one kind are given every frame as it comes: sums, counts, levels. From these a judge tells which frames show the
scene. Since some are known to be bad only when later ones have come, as many frames as the judge looks ahead are held back.
Accumulators of the other kind are given the good frames only, stretch by stretch between shutter events: nothing ever has to be
taken out again.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol, final

import numpy as np

from irtiming.records.arrays import Mask, Pixels, Ticks
from irtiming.records.choices import Choices
from irtiming.records.recording import Recording
from irtiming.records.reduced import Region
from irtiming.reduce import device_memory

SHORTEST = 60
"""Frames between two shutter events that are worth offsets of their own; fewer are dropped."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Block:
    """Some frames in a row.

    ``now`` are their numbers in the recording; ``whole`` (frame, row, column) the frames, ``part`` what they show of the region
    of interest, contiguous in memory. Both are valid until the next block; both may be in the memory of a GPU.
    """

    now: slice
    whole: Pixels
    part: Pixels


class OfEveryFrame(Protocol):
    """Gathers something of every frame."""

    def add(self, block: Block) -> None:
        """Take frames in, each once, in order."""
        ...


class OfGoodFrames(Protocol):
    """Gathers something of the frames that show the scene."""

    def add(self, index: Ticks, frames: Pixels) -> None:
        """Take the region of interest of frames in, shape (frame, row, column), with their numbers in the recording (frame,)."""
        ...

    def keep(self, index: Ticks) -> None:
        """End a stretch: what came since the last one belongs together; ``index`` (frame,) are its frames."""
        ...

    def drop(self) -> None:
        """End a stretch that was too short: forget what came since the last one."""
        ...


class Judge(OfEveryFrame, Protocol):
    """Tells which frames show the scene; it is given each block after the accumulators that it asks."""

    @property
    def reach(self) -> int:
        """By how many frames a frame's judgement looks ahead."""
        ...

    def decide(self, first: int, end: int, *, n_read: int) -> tuple[Mask, Mask]:
        """Good frames among ``first`` to ``end`` (excluded), ``n_read`` of them read, and those near an event, shapes (n,)."""
        ...


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Stretches:
    """Which frames were kept.

    ``segment`` (n_frame,) is the number of the stretch of each frame, -1 for frames that are not kept; ``short`` (n, 2) are first
    and end frame, excluded, of each stretch that was too short.
    """

    segment: Ticks
    short: Ticks


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Accumulators:
    """Those of every frame, in the order in which they are to be fed; the judge; those of the good frames."""

    every: Sequence[OfEveryFrame]
    judge: Judge
    good: Sequence[OfGoodFrames]


def run(
    recording: Recording, roi: Region, *, feeding: Accumulators, progress: Callable[[int], None], choices: Choices
) -> Stretches:
    """Read all frames once.

    Parameters
    ----------
    recording, roi
        Its frames, and their region of interest.
    feeding
        What is given them.
    progress
        Is given the number of frames done so far.
    choices
        Of the processor that sums them.

    Raises
    ------
    ReductionError
        If a GPU is wanted and there is none.
    """
    moved = device_memory.mover(choices.processor)
    rows, columns = slice(*roi[:2]), slice(*roi[2:])
    n_frames = recording.frames.shape[0]
    held = _HeldBack(feeding.judge, feeding.good, n_frames=n_frames)
    for first, read in recording.frames.blocks():
        whole = moved(read)
        part = device_memory.contiguous(whole[:, rows, columns])
        block = Block(now=slice(first, first + len(read)), whole=whole, part=part)
        for one in (*feeding.every, feeding.judge):
            one.add(block)
        held.add(block, at_end=block.now.stop == n_frames)
        progress(block.now.stop)
    held.close()
    return Stretches(segment=held.segment, short=np.array(held.short, np.int64).reshape(-1, 2))


@final
class _HeldBack:
    """Frames that are not yet judged, and the stretch that is growing."""

    def __init__(self, judge: Judge, good: Sequence[OfGoodFrames], *, n_frames: int) -> None:
        self.segment = np.full(n_frames, -1)
        self.short: list[tuple[int, int]] = []
        self._judge, self._good = judge, good
        self._held: Pixels | None = None
        self._held_first = 0
        self._stretch: list[Ticks] = []
        self._n_segments = 0

    def add(self, block: Block, *, at_end: bool) -> None:
        """Judge what can be judged, hold back the rest."""
        part, first, n_read = block.part, block.now.start, block.now.stop
        end = n_read if at_end else max(self._held_first, n_read - self._judge.reach)
        good, near = self._judge.decide(self._held_first, end, n_read=n_read)
        held = part[:0, ...] if self._held is None else self._held
        n_held = held.shape[0]
        for start, stop in pairwise([0, *(np.flatnonzero(np.diff(near)) + 1), near.size]):
            if stop > start and near[start]:
                self.close()
            elif stop > start:
                earlier = slice(min(start, n_held), min(stop, n_held))
                self._take(held[earlier, ...], self._held_first + earlier.start, good[earlier])
                own = slice(max(start - n_held, 0), max(stop - n_held, 0))
                self._take(part[own, ...], first + own.start, good[max(start, n_held) : max(stop, n_held)])
        self._held = device_memory.joined(held[min(near.size, n_held) :, ...], part[max(near.size - n_held, 0) :, ...])
        self._held_first = end

    def _take(self, frames: Pixels, first: int, good: Mask) -> None:
        index = first + np.flatnonzero(good)
        if not index.size:
            return
        frames = frames if good.all() else device_memory.taken(frames, good)
        for one in self._good:
            one.add(index, frames)
        self._stretch.append(index)

    def close(self) -> None:
        """End the stretch; a short one is dropped."""
        if not self._stretch:
            return
        index = np.concatenate(self._stretch)
        if index.size < SHORTEST:
            self.short.append((int(index[0]), int(index[-1]) + 1))
        else:
            self.segment[index] = self._n_segments
            self._n_segments += 1
        for one in self._good:
            if index.size < SHORTEST:
                one.drop()
            else:
                one.keep(index)
        self._stretch = []
