"""Frames as a camera gives them out that mixes each with those before it: trigger after trigger, then some are lost."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

import numpy as np
from numba import njit

from irtiming.errors import ReductionError
from irtiming.records.arrays import Pixels, Ticks
from irtiming.twin.frames import SimulatedFrames
from irtiming.twin.in_camera import InCamera
from irtiming.twin.noise import Values


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ProcessedFrames:
    """Stack of those frames that arrive.

    ``detector`` has a frame for each trigger; ``kept``, shape (n_frame,), are the triggers whose frames arrive, in order.
    """

    detector: SimulatedFrames
    kept: Ticks
    in_camera: InCamera

    @property
    def shape(self) -> tuple[int, int, int]:
        """Frames, rows and columns."""
        return (self.kept.size, *self.detector.shape[1:])

    def blocks(self) -> Iterator[tuple[int, Pixels]]:
        """Index of the first frame and values (frame, row, column), block after block, in order.

        A block is valid until the next one is asked for.
        """
        stages: _Stages | None = None
        given = 0
        for first, block in self.detector.unrounded_blocks():
            if stages is None:
                stages = _Stages(block[0], self.in_camera)
            frames = np.empty(block.shape, np.uint16)
            for seen, frame in zip(block, frames, strict=True):
                stages.follow(seen, out=frame)
            wanted = self.kept[(self.kept >= first) & (self.kept < first + len(block))] - first
            if wanted.size:
                yield given, frames[wanted]
            given += wanted.size

    def pick(self, indices: list[int]) -> Pixels:
        """The named frames, shape (len(indices), row, column); all that come before them are made too.

        Raises
        ------
        ReductionError
            If there is no such frame.
        """
        n_frame, rows, columns = self.shape
        for index in indices:
            if not 0 <= index < n_frame:
                raise ReductionError(f"frame {index} of {n_frame} asked for; ask for 0 to {n_frame - 1}")
        frames = np.empty((len(indices), rows, columns), np.uint16)
        last = max(indices, default=-1)
        for first, block in self.blocks():
            for place, index in enumerate(indices):
                if first <= index < first + len(block):
                    frames[place] = block[index - first]
            if first + len(block) > last:
                break
        return frames


class _Stages:
    """What the camera remembers: the frame before as the detector gave it, the filter's, and the last ones for the mean.

    It calculates with more digits than it gives out. One that does not would have no filter at all for changes of less than half
    a DN over its share.
    """

    def __init__(self, first: Values, in_camera: InCamera) -> None:
        self._shares = np.array([in_camera.memory_share, in_camera.filter_share])
        self._before = first.copy()
        self._filtered = self._before.copy()
        self._last = np.repeat(self._before[None], in_camera.averaged_frames, axis=0)
        self._number = 0

    def follow(self, frame: Values, *, out: Pixels) -> None:
        """Write what the camera gives out for what its detector gave."""
        slot = self._number % len(self._last)
        _mix(frame, self._shares, self._before, self._filtered, self._last[slot])
        np.rint(self._last[slot] if len(self._last) == 1 else np.mean(self._last, axis=0), out=out, casting="unsafe")
        self._number += 1


@njit(cache=True, nogil=True)
def _mix(frame: Values, shares: Values, before: Values, filtered: Values, out: Values) -> None:
    """One frame through memory and filter; ``before`` and ``filtered`` are brought up to date."""
    memory, kept = shares[0], shares[1]
    for row in range(frame.shape[0]):
        for column in range(frame.shape[1]):
            value = frame[row, column]
            remembered = (1 - memory) * value + memory * before[row, column]
            before[row, column] = value
            mixed = (1 - kept) * remembered + kept * filtered[row, column]
            filtered[row, column] = mixed
            out[row, column] = mixed
