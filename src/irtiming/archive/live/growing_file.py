"""The file of a recording that is being written: made, opened for writing beside readers, extended, and given its name.

HDF5 calls it SWMR: one writer, many readers. Nothing may be added to such a file but entries of what is there, so all groups,
datasets and attributes are made first. Then the metadata on the disk are consistent at any moment, and a file whose
writer was killed is as readable as one whose writer is at work.
"""

import os
from contextlib import suppress
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from irtiming.archive import layout
from irtiming.archive.hdf5_output import writing
from irtiming.archive.layout import Field
from irtiming.archive.live.head import ExchangedClock, RecordingHead
from irtiming.archive.live.unfinished import NOT_FINISHED
from irtiming.archive.nexus import (
    create_stack,
    describe_for_viewers,
    group,
    program_version,
    set_temperature,
    set_units,
)
from irtiming.archive.writer import identity_values, settings_values
from irtiming.errors import ArchiveError

STREAMS = (
    layout.CAMERA_TRIGGER, layout.CAMERA_TRIGGER_DELAYED, layout.CONTROL_SLOT, layout.APPLICATION_SLOT,
    layout.APPLICATION_EDGES, layout.CAMERA_INPUT, layout.SPARE, layout.LOST_AFTER,
)  # fmt: skip
"""Tick streams that grow."""

EXCHANGES: dict[ExchangedClock, tuple[Field, Field, Field]] = {
    "camera": (layout.CAMERA_EXCHANGE_BEFORE, layout.CAMERA_EXCHANGE, layout.CAMERA_EXCHANGE_AFTER),
    "counter": (layout.COUNTER_EXCHANGE_BEFORE, layout.COUNTER_EXCHANGE, layout.COUNTER_EXCHANGE_AFTER),
}
"""Columns of looks at a clock, which grow where the camera runs free."""

_PAGE_BYTES = 4096
"""A kill stops a write between two pages of the system's memory, and a disk that loses its power between two sectors."""

_ENDING_BYTES = 400
_COLUMN_CHUNK = 1024
_COLUMN_TYPES = {layout.FRAME_STATUS: np.uint8, layout.FRAME_HOST_TIME: np.float64} | {
    field: np.float64 for before, _, after in EXCHANGES.values() for field in (before, after)
}


def create(part: Path, head: RecordingHead) -> None:
    """Make the file with all that is known beforehand and nothing else in it; it is there as a whole or not at all."""
    beginning = part.with_suffix(".beginning")
    try:
        with writing(beginning, page_bytes=_PAGE_BYTES) as (file, _):
            _fill(file, head)
        beginning.replace(part)
    finally:
        beginning.unlink(missing_ok=True)


def open_for_writing(part: Path) -> h5py.File:
    """The file, open for one writer beside many readers; it is marked as such in one step."""
    access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
    access.set_libver_bounds(h5py.h5f.LIBVER_V110, h5py.h5f.LIBVER_V110)
    flags = h5py.h5f.ACC_RDWR | h5py.h5f.ACC_SWMR_WRITE
    return h5py.File(h5py.h5f.open(os.fsencode(part), flags, fapl=access))


def extend(dataset: h5py.Dataset, values: Any) -> None:
    """Add entries at the end of a dataset; when this returns the system has them.

    After an error the dataset is as long as it was, as far as this process can bring that about.
    """
    n_before = dataset.shape[0]
    try:
        dataset.resize(n_before + len(values), axis=0)
        dataset[n_before:] = values
        dataset.flush()
    except (OSError, RuntimeError, ValueError):
        with suppress(OSError, RuntimeError, ValueError):
            dataset.resize(n_before, axis=0)
        raise


def set_ending(file: h5py.File, text: str) -> None:
    """Say how the recording ended; what is too long for its place in the file is cut."""
    line = " ".join(text.split()).encode()[:_ENDING_BYTES].decode(errors="ignore")
    dataset = file[layout.ENDING.path]
    dataset[()] = line.encode()
    dataset.flush()


def _fill(file: h5py.File, head: RecordingHead) -> None:
    for field, value in _values(head).items():
        if value is not None:
            set_units(group(file, field.group).create_dataset(field.name, data=value), field.unit)
    is_free = head.frame_event != "trigger"
    file.create_dataset(layout.ACQUISITION_MODE, data="free running" if is_free else "triggered")
    create_stack(file, layout.FRAMES, size=(head.setup.rows, head.setup.columns))
    exchanged = (field for fields in EXCHANGES.values() for field in fields) if is_free else ()
    for field in (*layout.PER_FRAME, layout.FRAME_STATUS, *STREAMS, *exchanged):
        column = group(file, field.group).create_dataset(
            field.name, shape=(0,), maxshape=(None,), chunks=(_COLUMN_CHUNK,), dtype=_COLUMN_TYPES.get(field, np.int64)
        )
        set_units(column, field.unit)
    ending = group(file, layout.ENTRY).create_dataset(
        layout.ENDING.name, shape=(), dtype=h5py.string_dtype("utf-8", _ENDING_BYTES)
    )
    ending[()] = NOT_FINISHED.encode()
    for name, value in _told_by_instruments(head).items():
        group(file, layout.ACQUISITION).create_dataset(name, data=value)
    if head.nonuniformity is not None:
        _write_references(file, head)
    describe_for_viewers(file)


def _values(head: RecordingHead) -> dict[Field, Any]:
    run, setup, clock_hz = head.run, head.setup, head.clock_frequency_hz
    is_photon, is_free = head.camera_type == "photon", head.frame_event != "trigger"
    return {
        layout.TITLE: head.name,
        layout.START_TIME: head.start_time or datetime.now(UTC).isoformat(timespec="milliseconds"),
        layout.PROGRAM_VERSION: program_version(),
        layout.CAMERA_TYPE: head.camera_type,
        layout.READOUT_MODE: head.readout_mode,
        layout.INTEGRATION_TIME: (setup.integration_time_s or head.integration_time_s) if is_photon else None,
        layout.TRIGGER_DELAY_TIME_SET: run.trigger_delay_ticks / clock_hz,
        layout.FRAME_EVENT: head.frame_event if is_free else None,
        layout.TIMESTAMP_CLOCK: "camera" if is_free and setup.timestamp_frequency_hz else None,
        layout.BIT_DEPTH: setup.bit_depth,
        layout.TIMESTAMP_FREQUENCY: setup.timestamp_frequency_hz or None,
        layout.ROTATION_SPEED: clock_hz / run.scheme.turn_period_ticks,
        layout.CLOCK_FREQUENCY: float(clock_hz),
        layout.CAMERA_PERIOD: None if is_free else run.scheme.camera_period_ticks,
        layout.WHEEL_PERIOD: run.scheme.turn_period_ticks,
        layout.BLACKBODY_TEMPERATURE: None if head.blackbody is None else head.blackbody.temperature_k,
        **identity_values(head.camera),
        **{field: None if value == "" else value for field, value in settings_values(setup.settings).items()},
    }


def _told_by_instruments(head: RecordingHead) -> dict[str, Any]:
    """What the instruments said of themselves and has no place of its own, flat, with the instrument before the name."""
    states = {"camera": head.setup, "chopper": head.chopper, "blackbody": head.blackbody}
    fields = {
        f"{instrument}_{name}": value
        for instrument, state in states.items()
        if state is not None
        for name, value in asdict(state).items()
        if value is not None and name != "settings"
    }
    return fields | {
        "run_control_slots": head.run.scheme.control_slots,
        "run_repeats": head.run.repeats,
        "run_triggers": head.run.scheme.samples_per_turn * head.run.repeats,
        "run_is_after_correction": head.run.is_after_correction,
    }


def _write_references(file: h5py.File, head: RecordingHead) -> None:
    reference = head.nonuniformity
    if reference is None or reference.low_frames is None or reference.high_frames is None:
        raise ArchiveError(f"{head.name}: {layout.REFERENCE} needs the raw stacks low_frames and high_frames")
    both = (
        (layout.REFERENCE_LOW, reference.low_frames, reference.low_temperature_k),
        (layout.REFERENCE_HIGH, reference.high_frames, reference.high_temperature_k),
    )
    for field, frames, temperature_k in both:
        stack = create_stack(file, field, size=(frames.shape[1], frames.shape[2]))
        for _, block in frames.blocks():
            extend(stack, block)
        set_temperature(file, field, temperature_k=temperature_k)
