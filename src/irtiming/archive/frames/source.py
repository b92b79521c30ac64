"""Frames of any file: what it tells of them, and the frames themselves, block by block."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, Protocol, TypeAlias, final

import numpy as np
import numpy.typing as npt

from irtiming.archive import layout
from irtiming.archive.frames.bounds import refusing
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Array, Ticks
from irtiming.records.camera_frame import CameraIdentity

FrameValues: TypeAlias = npt.NDArray[Any]
"""Values of frames in the type of the file, in this computer's byte order; shape (frame, row, column)."""

TimeScale = Literal[
    "", "UTC", "local time", "time of day", "camera clock", "host clock", "trigger clock", "first frame"
]
"""Where times of frames count from: 1970 in UTC or in the camera's local time, the last midnight there, the start of a clock."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class FrameFacts:
    """What a file tells of its frames; None, or empty text, is what it does not tell.

    ``format`` is the kind of file in words. ``unit`` is "DN" for counts of the detector, "K" for temperatures. ``times_s`` are
    the moments that the file gives its frames, in the scale ``time_scale`` and steps of ``time_step_s``; ``trigger_times_s``
    those of the triggers that made them. Shapes: times_s, trigger_times_s and frame_id (n_frames,). ``more`` is what else it
    tells, by name, the unit as suffix of the name.
    """

    format: str
    frames: int
    rows: int
    columns: int
    dtype: str
    unit: Literal["DN", "K", ""] = "DN"
    bit_depth: int | None = None
    camera: CameraIdentity | None = None
    start_time: str = ""
    integration_time_s: float | None = None
    frame_period_s: float | None = None
    times_s: Array | None = None
    time_scale: TimeScale = ""
    time_step_s: float | None = None
    trigger_times_s: Array | None = None
    frame_id: Ticks | None = None
    more: Mapping[str, str | float] = field(default_factory=dict)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of frames, rows and columns."""
        return self.frames, self.rows, self.columns

    @property
    def frame_bytes(self) -> int:
        """Bytes of one frame in memory."""
        return self.rows * self.columns * np.dtype(self.dtype).itemsize


class FrameSource(Protocol):
    """Frames of one file, read block by block; with values in uint16 it is a `FrameStack` of a recording."""

    @property
    def facts(self) -> FrameFacts:
        """What the file tells of them."""
        ...

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of frames, rows and columns."""
        ...

    def blocks(self) -> Iterator[tuple[int, FrameValues]]:
        """Index of the first frame and values (frame, row, column), block after block, in order.

        A block is valid until the next one is asked for.
        """
        ...

    def pick(self, indices: list[int]) -> FrameValues:
        """The named frames in the order named, shape (len(indices), row, column)."""
        ...


@final
@dataclass(frozen=True, kw_only=True)
class FrameReader:
    """One format: an entry point of the group ``irtiming.frames``.

    ``title`` is the format in words. ``takes`` says from a path and the first bytes there whether a file is of this format; it
    never opens anything else. ``open`` gives the frames, and may raise whatever it likes about a file that is not sound. Both
    must be quick to import: a library that reads is loaded in ``open``. ``beside`` names the other files that ``open`` reads
    with a path, or would if they were there.
    """

    title: str
    takes: Callable[[Path, bytes], bool]
    open: Callable[[Path], FrameSource]
    beside: Callable[[Path], Iterable[Path]] = lambda _: ()


Read: TypeAlias = Callable[[int, int], FrameValues]
"""Frames by the index of the first and their number, from a file that is open; shape (frame, row, column)."""


@final
class Frames:
    """A `FrameSource` that opens its file anew for each pass; ``reading`` holds it open and gives the function that reads."""

    def __init__(self, path: Path, facts: FrameFacts, reading: Callable[[], AbstractContextManager[Read]]) -> None:
        self._path, self._facts, self._reading = path, facts, reading

    @property
    def facts(self) -> FrameFacts:
        """What the file tells of them."""
        return self._facts

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of frames, rows and columns."""
        return self._facts.shape

    def blocks(self) -> Iterator[tuple[int, FrameValues]]:
        """Index of the first frame and values (frame, row, column), block after block, in order.

        Raises
        ------
        ArchiveError
            If the file has gone, or a frame in it is damaged.
        """
        n_frames = self._facts.frames
        length = max(1, layout.BLOCK_BYTES // self._facts.frame_bytes)
        with refusing(self._path, self._facts.format), self._reading() as read:
            for first in range(0, n_frames, length):
                yield first, self._fitting(read(first, min(length, n_frames - first)))

    def pick(self, indices: list[int]) -> FrameValues:
        """The named frames in the order named, shape (len(indices), row, column).

        Raises
        ------
        ArchiveError
            If there is no such frame, or it is damaged.
        """
        n_frames = self._facts.frames
        for index in indices:
            if not 0 <= index < n_frames:
                raise ArchiveError(f"has no frame {index}; it must be from 0 to {n_frames - 1}", where=str(self._path))
        picked = np.empty((len(indices), *self.shape[1:]), dtype=self._facts.dtype)
        with refusing(self._path, self._facts.format), self._reading() as read:
            for place in np.argsort(np.asarray(indices, dtype=np.int64), kind="stable"):
                picked[place] = self._fitting(read(indices[place], 1))[0]
        return picked

    def _fitting(self, values: FrameValues) -> FrameValues:
        if values.shape[1:] != self.shape[1:]:
            raise ValueError(f"a frame of {values.shape[1:]} among frames of {self.shape[1:]}")
        return values if values.dtype == self._facts.dtype else values.astype(self._facts.dtype)
