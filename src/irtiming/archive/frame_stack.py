"""Stacks of frames: in a file, read block by block, or in memory."""

from collections.abc import Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import NoReturn, final

import h5py
import numpy as np

from irtiming.archive import layout
from irtiming.archive.finding import Complaint, refuse
from irtiming.archive.hdf5_file import H5_ERRORS, opened, reason_of
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Pixels, Ticks


@final
class FileFrames:
    """Frames of one dataset of a file: a `FrameStack` that opens the file for each pass and holds one block.

    ``path`` is the file; ``where`` the dataset in it, uint16 (frame, row, column), of shape ``shape``. ``kept`` are the
    indices of the frames that are meant, rising; None: all. A file that ``is_growing`` may have more frames by now, or
    be finished.
    """

    def __init__(
        self,
        path: str | Path,
        where: str = layout.FRAMES.path,
        *,
        shape: tuple[int, int, int],
        kept: Ticks | None = None,
        is_growing: bool = False,
    ) -> None:
        self._path = Path(path)
        self._where = where
        self._stored = shape
        self._kept = kept
        self._is_growing = is_growing
        self._shape = shape if kept is None else (len(kept), *shape[1:])

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of frames, rows and columns."""
        return self._shape

    def blocks(self) -> Iterator[tuple[int, Pixels]]:
        """Index of the first frame and values (frame, row, column), DN; block after block, in order.

        A block is a view of one buffer that the next block overwrites.

        Raises
        ------
        ArchiveError
            If the file has gone or changed, or a frame in it is damaged; the message names the frame.
        """
        try:
            with self._opened() as file:
                dataset = self._dataset(file)
                length = min(_block_length(dataset), self._shape[0])
                buffer = np.empty((length, *self._shape[1:]), dtype=np.uint16)
                for first in range(0, self._shape[0], length):
                    count = min(length, self._shape[0] - first)
                    self._fill(dataset, first, into=buffer[:count])
                    yield first, buffer[:count]
        except Complaint as complaint:
            raise complaint.as_error(self._path) from complaint

    def pick(self, indices: list[int]) -> Pixels:
        """The named frames in the order named, shape (len(indices), row, column), DN.

        Raises
        ------
        ArchiveError
            If there is no such frame, or it is damaged.
        """
        _check_indices(indices, self._shape[0], where=f"{self._path}: {self._where}")
        picked = np.empty((len(indices), *self._shape[1:]), dtype=np.uint16)
        try:
            with self._opened() as file:
                dataset = self._dataset(file)
                for place in np.argsort(np.asarray(indices, dtype=np.int64), kind="stable"):
                    self._fill(dataset, indices[place], into=picked[place : place + 1])
        except Complaint as complaint:
            raise complaint.as_error(self._path) from complaint
        return picked

    def _opened(self) -> AbstractContextManager[h5py.File]:
        if self._is_growing and not self._path.exists():
            return opened(self._path.with_suffix(""))  # finished meanwhile
        return opened(self._path, is_growing=self._is_growing)

    def _dataset(self, file: h5py.File) -> h5py.Dataset:
        try:
            dataset = file[self._where]
        except H5_ERRORS as error:
            raise refuse(
                self._where,
                f"cannot be read ({reason_of(error)})",
                code="frames-unreadable",
                cure="copy or record it again",
            ) from error
        has_grown = self._is_growing and dataset.shape[0] > self._stored[0]
        if dataset.shape[1:] != self._stored[1:] or (dataset.shape[0] != self._stored[0] and not has_grown):
            raise refuse(
                self._where,
                f"has shape {dataset.shape}, it had {self._stored}",
                code="file-changed",
                cure="the file has changed; read it again",
            )
        return dataset

    def _fill(self, dataset: h5py.Dataset, first: int, *, into: Pixels) -> None:
        if self._kept is None:
            self._read(dataset, first, into=into)
            return
        stored = self._kept[first : first + len(into)]
        begin = 0
        for run in np.split(stored, np.flatnonzero(np.diff(stored) != 1) + 1):
            self._read(dataset, int(run[0]), into=into[begin : begin + len(run)])
            begin += len(run)

    def _read(self, dataset: h5py.Dataset, first: int, *, into: Pixels) -> None:
        try:
            dataset.read_direct(into, np.s_[first : first + len(into)])
        except H5_ERRORS as error:
            self._name_damaged_frame(dataset, first, count=len(into), error=error)

    def _name_damaged_frame(self, dataset: h5py.Dataset, first: int, *, count: int, error: Exception) -> NoReturn:
        frame = np.empty((1, *self._shape[1:]), dtype=np.uint16)
        damaged = first
        for index in range(first, first + count):
            try:
                dataset.read_direct(frame, np.s_[index : index + 1])
            except H5_ERRORS:
                damaged = index
                break
        raise refuse(
            self._where,
            f"cannot be read at frame {damaged} of {self._stored[0]} ({reason_of(error)})",
            code="frame-damaged",
            cure="the file is damaged; copy or record it again",
        ) from error


@final
class ArrayFrames:
    """Frames in memory as a `FrameStack`: for tests, simulations and short series.

    ``values`` are DN of shape (frame, row, column); ``block_frames`` is the length of a block.
    """

    def __init__(self, values: Pixels, *, block_frames: int = 64) -> None:
        self._values = values
        self._block_frames = block_frames

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of frames, rows and columns."""
        n_frames, rows, columns = self._values.shape
        return n_frames, rows, columns

    def blocks(self) -> Iterator[tuple[int, Pixels]]:
        """Index of the first frame and values (frame, row, column), DN; block after block, in order."""
        for first in range(0, len(self._values), self._block_frames):
            yield first, self._values[first : first + self._block_frames]

    def pick(self, indices: list[int]) -> Pixels:
        """The named frames in the order named, shape (len(indices), row, column), DN.

        Raises
        ------
        ArchiveError
            If there is no such frame.
        """
        _check_indices(indices, len(self._values), where="frames in memory")
        return self._values[indices]


def _check_indices(indices: list[int], n_frames: int, *, where: str) -> None:
    for index in indices:
        if not 0 <= index < n_frames:
            raise ArchiveError(f"{where} has no frame {index}; it must be from 0 to {n_frames - 1}")


def _block_length(dataset: h5py.Dataset) -> int:
    """Frames of a block: whole chunks, at most `layout.BLOCK_BYTES`, but at least one chunk or frame."""
    n_frames, rows, columns = dataset.shape
    within_budget = max(1, layout.BLOCK_BYTES // (rows * columns * 2))
    chunk = dataset.chunks[0] if dataset.chunks else 1
    if chunk <= within_budget:
        within_budget -= within_budget % chunk
    return int(min(within_budget, n_frames))
