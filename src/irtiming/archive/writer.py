"""From a recording, block by block, to a file that is whole or not there."""

from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any, Literal, Self, final

import h5py
import numpy as np

from irtiming.archive import consistency, layout
from irtiming.archive.fields import read_field
from irtiming.archive.finding import Complaint, archive_error
from irtiming.archive.hdf5_file import H5_ERRORS, reason_of
from irtiming.archive.hdf5_output import Output, writing
from irtiming.archive.layout import Field
from irtiming.archive.nexus import (
    bring_to_disk,
    create_stack,
    describe_for_viewers,
    group,
    set_temperature,
    set_units,
)
from irtiming.archive.whole_file import part_of, place_of, unwritable
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Pixels
from irtiming.records.camera_frame import CameraIdentity
from irtiming.records.camera_settings import CameraSettings
from irtiming.records.recording import FrameStack, Recording

Stack = Literal["frames", "low", "high"]

_STACKS: dict[Stack, Field] = {
    "frames": layout.FRAMES,
    "low": layout.REFERENCE_LOW,
    "high": layout.REFERENCE_HIGH,
}
_TRUTH_UNITS = {
    "s": "s", "rad": "rad", "hz": "Hz", "k": "K", "m": "m", "px": "px", "dn": "DN", "rows": "rows",
    "ticks": "ticks",
}  # fmt: skip


def write(
    recording: Recording,
    path: str | Path,
    *,
    truth: Mapping[str, Any] | None = None,
    overwrite: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Write a recording, streaming its frames and those of its non-uniformity reference.

    Parameters
    ----------
    recording
        Its ``frames`` may be any `FrameStack`; a ``nonuniformity`` must carry its raw stacks.
    path
        The file to make; its suffix should be ``.nxs``.
    truth
        What a simulation knows: flat, name to number, text or array, the unit as suffix of the name. Readers
        ignore it, `reader.read_truth` gives it back.
    overwrite
        Replace a file of that name.
    progress
        Called with frames written and all frames after each block.

    Raises
    ------
    ArchiveError
        If the file exists, cannot be written, or would be one that the reader refuses.
    """
    with RecordingWriter(path, overwrite=overwrite) as writer:
        writer.describe(recording, truth=truth)
        for first, block in recording.frames.blocks():
            writer.append(block)
            if progress is not None:
                progress(first + len(block), recording.frames.shape[0])
        for stack, frames in _reference_stacks(recording, path):
            for _, block in frames.blocks():
                writer.append(block, stack=stack)


@final
class RecordingWriter:
    """Streams a recording into a new file; use it in a ``with`` statement.

    The file has the suffix ``.part`` until everything is in it and on the disk: a name without it is a whole
    file. If the ``with`` block raises, nothing is left behind.

    ``path`` is the file to make; ``overwrite`` allows to replace one of that name.
    """

    def __init__(self, path: str | Path, *, overwrite: bool = False) -> None:
        self._path = place_of(path)
        self._part = part_of(self._path)
        self._overwrite = overwrite
        self._described = False
        self._temperatures: dict[Field, float | None] = {}
        self._file: h5py.File | None = None
        self._output: Output | None = None
        self._held = ExitStack()

    def __enter__(self) -> Self:
        """Create the file under its temporary name.

        Raises
        ------
        ArchiveError
            If a file of this name exists, or none can be made.
        """
        self._refuse_existing()
        try:
            self._file, self._output = self._held.enter_context(writing(self._part))
        except BlockingIOError as error:
            raise ArchiveError(f"{self._part}: another program is writing it; wait, or use another name") from error
        except OSError as error:
            raise unwritable(self._path, error) from error
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Check the file, bring it to the disk and give it its name; after an error, remove it."""
        if self._file is None:
            return
        try:
            if kind is None:
                self._finish()
        finally:
            with suppress(*H5_ERRORS):  # what a full disk makes fail once more; the first error is the one to tell
                self._held.close()
            self._file = self._output = None
            self._part.unlink(missing_ok=True)

    def append(self, block: Pixels, *, stack: Stack = "frames") -> None:
        """Add frames, uint16 of shape (frame, row, column), to the recording or one of its reference stacks.

        Raises
        ------
        ArchiveError
            If the block is not uint16, its frames have another size than those before, or the disk is full.
        """
        field = _STACKS[stack]
        if block.dtype != np.uint16 or block.ndim != 3:
            raise self._error(field, f"got a block of {block.dtype} {block.shape}; give uint16 (frame, row, column)")
        file = self._opened()
        if field.path not in file:
            create_stack(file, field, size=(block.shape[1], block.shape[2]))
        dataset = file[field.path]
        if dataset.shape[1:] != block.shape[1:]:
            before, now = dataset.shape[1:], block.shape[1:]
            raise self._error(field, f"got frames of {now} after frames of {before}; all must have one size")
        n_before = dataset.shape[0]
        try:
            dataset.resize(n_before + len(block), axis=0)
            dataset[n_before:] = block
            self._require_written()
        except H5_ERRORS as error:
            raise self._error(field, f"could not be written ({reason_of(error)}); is the disk full?") from error

    def describe(self, recording: Recording, *, truth: Mapping[str, Any] | None = None) -> None:
        """Write everything of a recording except its frames; once, before the ``with`` block ends.

        Raises
        ------
        ArchiveError
            If a value cannot be stored.
        """
        file = self._opened()
        self._described = True
        for field, value in values_of(recording).items():
            if value is not None:
                dataset = group(file, field.group).create_dataset(field.name, data=value)
                set_units(dataset, field.unit)
        mode = "triggered" if recording.frame_event == "trigger" else "free-running"
        file.create_dataset(layout.ACQUISITION_MODE, data=mode)
        if recording.nonuniformity is not None:
            self._temperatures = {
                layout.REFERENCE_LOW: recording.nonuniformity.low_temperature_k,
                layout.REFERENCE_HIGH: recording.nonuniformity.high_temperature_k,
            }
        for name, value in (truth or {}).items():
            self._write_truth(group(file, layout.TRUTH), name, value=value)

    def _finish(self) -> None:
        file = self._opened()
        if not self._described:
            raise ArchiveError(f"{self._path}: describe(recording) was never called; call it before closing")
        for field, temperature in self._temperatures.items():
            set_temperature(file, field, temperature_k=temperature)
        self._check(file)
        describe_for_viewers(file)
        try:
            self._held.close()
            bring_to_disk(self._part)
            self._refuse_existing()
            self._part.replace(self._path)
        except OSError as error:
            raise unwritable(self._path, error) from error

    def _check(self, file: h5py.File) -> None:
        try:
            file.flush()
            self._require_written()
            contents = {field: read_field(file, field) for field in layout.FIELDS}
        except Complaint as complaint:
            raise complaint.as_error(self._path) from complaint
        except OSError as error:
            raise unwritable(self._path, error) from error
        findings = [*consistency.check(contents), *consistency.check_temperatures(self._temperatures)]
        for finding in findings:
            if finding.severity == "error":
                raise archive_error(self._path, finding)

    def _write_truth(self, group: h5py.Group, name: str, *, value: Any) -> None:
        try:
            dataset = group.create_dataset(name, data=value)
        except H5_ERRORS as error:
            what = f"truth '{name}' is {type(value).__name__}; give a number, text or array of numbers"
            raise ArchiveError(f"{self._path}: {what}") from error
        set_units(dataset, _TRUTH_UNITS.get(name.rsplit("_", 1)[-1], ""))

    def _require_written(self) -> None:
        if self._output is not None:
            self._output.require_written()

    def _opened(self) -> h5py.File:
        if self._file is None:
            raise ArchiveError(f"{self._path}: the writer is closed; use it inside its 'with' block")
        return self._file

    def _refuse_existing(self) -> None:
        place_of(self._path)
        if self._path.exists() and not self._overwrite:
            raise ArchiveError(f"{self._path}: exists already; choose another name, or allow it to be overwritten")

    def _error(self, field: Field, what: str) -> ArchiveError:
        return ArchiveError(f"{self._path}: {field.path} {what}")


def values_of(recording: Recording) -> dict[Field, Any]:
    """What a recording says, by field of the file, None where it says nothing; frames and reference stacks are written apart."""
    values = {field: getattr(recording, field.attribute) for field in layout.FIELDS if field.attribute}
    values |= {} if recording.camera is None else identity_values(recording.camera)
    values |= settings_values(recording.settings)
    unsaid = layout.FRAME_EVENT if recording.frame_event == "trigger" else layout.CAMERA_TRIGGER
    values |= {unsaid: None} | ({layout.TIMESTAMP_CLOCK: None} if recording.timestamp_clock == "camera" else {})
    return {field: None if isinstance(value, str) and not value else value for field, value in values.items()}


def identity_values(camera: CameraIdentity) -> dict[Field, str | None]:
    """What a camera says of itself, by field of the file; None where it does not say."""
    return {field: getattr(camera, field.name) or None for field in layout.IDENTITY}


def settings_values(settings: CameraSettings) -> dict[Field, Any]:
    """What a camera was set to, by field of the file; None where not stated."""
    return {field: getattr(settings, name) for name, field in layout.SETTINGS.items()}


def _reference_stacks(recording: Recording, path: str | Path) -> list[tuple[Stack, FrameStack]]:
    reference = recording.nonuniformity
    if reference is None:
        return []
    if reference.low_frames is None or reference.high_frames is None:
        raise ArchiveError(
            f"{path}: {layout.REFERENCE} cannot be written from its mean alone; "
            "give the raw stacks low_frames and high_frames"
        )
    return [("low", reference.low_frames), ("high", reference.high_frames)]
