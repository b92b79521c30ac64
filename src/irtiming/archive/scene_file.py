"""Frames of a scene at one instant each, streamed into a file that any NeXus viewer opens, and that is whole or not there."""

from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Self, final

import h5py
import hdf5plugin
import numpy as np

from irtiming.archive import layout
from irtiming.archive.finding import Complaint
from irtiming.archive.frames.source import FrameValues
from irtiming.archive.hdf5_file import H5_ERRORS, opened, reason_of
from irtiming.archive.hdf5_output import Output, writing
from irtiming.archive.nexus import bring_to_disk, group, program_version
from irtiming.archive.whole_file import part_of, place_of, unwritable
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Ticks, read_only

SCENE = f"{layout.ENTRY}/scene"
"""Group of what is stated of each frame beside its pixels."""

_GAIN, _NOISE_GAIN = f"{SCENE}/gain", f"{SCENE}/noise_gain"
_COLUMNS = ("frame_number", "time")
_TOGETHER = 16  # frames that are written at once


@final
@dataclass(frozen=True, kw_only=True)
class SceneHead:
    """What is known of a scene before its frames: rows and columns, type and unit of the values, tiles of the gains, and words.

    ``time_errors_s`` is the standard uncertainty of the instants; ``description`` has lines of what was done.
    """

    size: tuple[int, int]
    dtype: str
    unit: str
    tiles: tuple[int, int]
    tile_px: int
    time_errors_s: float
    description: tuple[str, ...]


@final
class SceneWriter:
    """Streams a scene into a new file; use it in a ``with`` statement.

    The file has the suffix ``.part`` until everything is in it; if the ``with`` block raises, nothing is left behind. What is
    no file, such as a device, is refused.
    """

    def __init__(self, path: str | Path, head: SceneHead) -> None:
        self._path, self._head = place_of(path), head
        self._part = part_of(self._path)
        self._held = ExitStack()
        self._file: h5py.File | None = None
        self._output: Output | None = None
        self._told: dict[str, list[float]] = {name: [] for name in _COLUMNS}
        self._kept: dict[str, FrameValues] = {}
        self._length = self._written = 0

    def __enter__(self) -> Self:
        """Create the file under its temporary name.

        Raises
        ------
        ArchiveError
            If none can be made.
        """
        try:
            self._file, self._output = self._held.enter_context(writing(self._part))
            self._create(self._file)
            self._output.require_written()
        except H5_ERRORS as error:
            failure = error if self._output is None else self._output.failure or error
            self._drop()
            raise self._unwritten(failure) from error
        except BaseException:
            self._drop()
            raise
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Bring the file to the disk and give it its name; after an error, remove it."""
        try:
            if kind is None:
                self._finish()
        finally:
            self._drop()

    def _drop(self) -> None:
        """Close the file, and remove what has not got its name."""
        try:
            with suppress(*H5_ERRORS):
                self._held.close()
        finally:
            self._file = self._output = None
            self._part.unlink(missing_ok=True)

    def _unwritten(self, error: BaseException) -> ArchiveError:
        if isinstance(error, OSError) and error.strerror:
            return unwritable(self._path, error)
        return ArchiveError(f"{self._path}: cannot be written ({reason_of(error)}); is the disk full?")

    def append(
        self, pixels: FrameValues, *, number: int, time_s: float, gain: FrameValues, noise_gain: FrameValues
    ) -> None:
        """Add one frame.

        Parameters
        ----------
        pixels
            Shape (row, column).
        number
            Index of the frame that it was made from.
        time_s
            The instant.
        gain, noise_gain
            Shape (tile row, tile column).

        Raises
        ------
        ArchiveError
            If the disk is full.
        """
        at = self._length - self._written
        for kept, values in zip(self._kept.values(), (pixels, gain, noise_gain), strict=True):
            kept[at] = values
        self._told["frame_number"].append(number)
        self._told["time"].append(time_s)
        self._length += 1
        if at + 1 == _TOGETHER:
            self._write()

    def _write(self) -> None:
        """Bring what is kept into the file."""
        assert self._file is not None
        count = self._length - self._written
        try:
            for path, kept in self._kept.items():
                dataset = self._file[path]
                dataset.resize(self._length, axis=0)
                dataset[self._written :] = kept[:count]
            if self._output is not None:
                self._output.require_written()
        except H5_ERRORS as error:
            raise self._unwritten(error) from error
        self._written = self._length

    def _create(self, file: h5py.File) -> None:
        head = self._head
        group(file, layout.CAMERA)
        for path, shape, dtype in (
            (layout.FRAMES.path, head.size, head.dtype), (_GAIN, head.tiles, "f4"), (_NOISE_GAIN, head.tiles, "f4"),
        ):  # fmt: skip
            file.create_dataset(
                path, shape=(0, *shape), maxshape=(None, *shape), chunks=(1, *shape), dtype=dtype,
                **hdf5plugin.Bitshuffle(cname="lz4"),
            )  # fmt: skip
            self._kept[path] = np.zeros((_TOGETHER, *shape), dtype)
        file[layout.FRAMES.path].attrs["units"] = head.unit
        scene = file[SCENE]
        scene.attrs["NX_class"] = "NXprocess"
        scene.attrs["tile_px"] = head.tile_px
        scene["program"] = program_version()
        scene["description"] = "\n".join(head.description)

    def _finish(self) -> None:
        assert self._file is not None
        if self._length > self._written:
            self._write()
        scene = self._file[SCENE]
        scene["frame_number"] = np.array(self._told["frame_number"], dtype=np.int64)
        scene["time"] = np.array(self._told["time"], dtype=np.float64)
        scene["time"].attrs["units"] = "s"
        scene["time_errors"] = self._head.time_errors_s
        scene["time_errors"].attrs["units"] = "s"
        plot = group(self._file, layout.PLOT)
        plot["data"], plot["time"] = self._file[layout.FRAMES.path], scene["time"]
        plot.attrs["signal"], plot.attrs["axes"] = "data", ["time", ".", "."]
        self._file.attrs["default"] = "entry"
        self._file[layout.ENTRY].attrs["default"] = "data"
        try:
            self._held.close()
            bring_to_disk(self._part)
            self._part.replace(self._path)
        except OSError as error:
            raise unwritable(self._path, error) from error


def made_from(path: str | Path) -> Ticks:
    """Index of the frame that each frame of a scene was made from, shape (n_scene,).

    Raises
    ------
    ArchiveError
        If the file is no scene.
    """
    try:
        with opened(path) as file:
            return read_only(np.asarray(file[SCENE]["frame_number"][()], np.int64))
    except Complaint as complaint:
        raise complaint.as_error(path) from complaint
    except H5_ERRORS as error:
        raise ArchiveError(
            f"is no scene that irtiming apply frames wrote ({reason_of(error)})", where=str(path)
        ) from error
