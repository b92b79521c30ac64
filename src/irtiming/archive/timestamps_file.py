"""Timestamps of one run in a file of their own, until the camera's frames join them: a recording that has no frames yet."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import h5py
import numpy as np

from irtiming.archive import layout
from irtiming.archive.fields import read_field
from irtiming.archive.finding import Complaint, refuse
from irtiming.archive.hdf5_file import opened
from irtiming.archive.hdf5_output import whole_hdf5
from irtiming.archive.layout import Field
from irtiming.archive.nexus import group, set_units
from irtiming.archive.reader import check_version
from irtiming.records.arrays import Ticks
from irtiming.records.timestamps import Timestamps
from irtiming.records.trigger_plan import PlannedRun

STREAMS: tuple[Field, ...] = (
    layout.CAMERA_TRIGGER, layout.CONTROL_SLOT, layout.APPLICATION_SLOT, layout.APPLICATION_EDGES, layout.SPARE,
    layout.LOST_AFTER, layout.CAMERA_TRIGGER_DELAYED, layout.CAMERA_INPUT,
)  # fmt: skip
"""Tick streams that a recording takes over; others stand beside them for whoever wants to look."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TimedRun:
    """What such a file says: tick streams by their field, and the run's nominal wheel rate and delay that was set.

    Where it holds frames, ``camera_stamps`` has, for each frame, the camera's own timestamp and the tick of its trigger, in two
    arrays of shape (n_frame,), and ``timestamp_frequency_hz`` the frequency of the camera's clock.
    """

    name: str
    clock_frequency_hz: int
    streams: dict[Field, Ticks]
    rotation_speed_hz: float
    trigger_delay_time_set_s: float
    camera_stamps: tuple[Ticks, Ticks] | None = None
    timestamp_frequency_hz: float | None = None


def write_timestamps(timestamps: Timestamps, path: str | Path, *, run: PlannedRun) -> None:
    """Write the timestamps of a run where a recording has them; a file of that name is replaced when the new one is whole.

    Parameters
    ----------
    timestamps
        From a trigger generator; they may have holes.
    path
        Its suffix should be ``.nxs``.
    run
        That was loaded.

    Raises
    ------
    ArchiveError
        If the file cannot be written.
    """
    clock = timestamps.clock_frequency_hz
    values: dict[Field, Any] = {
        layout.CLOCK_FREQUENCY: float(clock),
        layout.ROTATION_SPEED: clock / run.scheme.turn_period_ticks,
        layout.TRIGGER_DELAY_TIME_SET: run.trigger_delay_ticks / clock,
        layout.CAMERA_PERIOD: run.scheme.camera_period_ticks,
        layout.WHEEL_PERIOD: run.scheme.turn_period_ticks,
        layout.CAMERA_TRIGGER: timestamps.camera_trigger_ticks,
        layout.CONTROL_SLOT: timestamps.control_slot_ticks,
        layout.APPLICATION_SLOT: timestamps.application_slot_ticks,
        layout.APPLICATION_EDGES: timestamps.application_edge_ticks,
        layout.LOST_AFTER: timestamps.lost_after_ticks,
    }
    beside = {
        "camera_trigger_delayed": timestamps.camera_trigger_delayed_ticks,
        "camera_input": timestamps.camera_input_ticks,
        layout.SPARE.name: timestamps.spare_ticks,
    }
    with whole_hdf5(path) as file:
        for field, value in values.items():
            set_units(group(file, field.group).create_dataset(field.name, data=value), field.unit)
        for name, ticks in beside.items():
            if ticks.size:
                set_units(group(file, layout.TRIGGER_GENERATOR).create_dataset(name, data=ticks), "ticks")
        file[layout.ENTRY].attrs[layout.VERSION_ATTRIBUTE] = layout.VERSION


def read_timestamps(path: str | Path) -> TimedRun:
    """Timestamps that `write_timestamps` wrote, or those in any recording.

    Raises
    ------
    ArchiveError
        If the file cannot be read, or a stream is missing or too short.
    """
    try:
        with opened(path) as file:
            check_version(file)
            streams = {field: read_field(file, field) for field in STREAMS}
            clock_hz = read_field(file, layout.CLOCK_FREQUENCY)
            if clock_hz % 1:
                raise refuse(
                    layout.CLOCK_FREQUENCY.path,
                    f"= {clock_hz} Hz",
                    code="clock-not-whole-hertz",
                    cure="it must be whole hertz",
                )
            return TimedRun(
                name=Path(path).stem,
                clock_frequency_hz=int(clock_hz),
                streams={field: ticks for field, ticks in streams.items() if isinstance(ticks, np.ndarray)},
                rotation_speed_hz=read_field(file, layout.ROTATION_SPEED),
                trigger_delay_time_set_s=read_field(file, layout.TRIGGER_DELAY_TIME_SET) or 0.0,
                camera_stamps=_camera_stamps(file, streams[layout.CAMERA_TRIGGER]),
                timestamp_frequency_hz=read_field(file, layout.TIMESTAMP_FREQUENCY),
            )
    except Complaint as complaint:
        raise complaint.as_error(path) from complaint


def _camera_stamps(file: h5py.File, triggers: Ticks | None) -> tuple[Ticks, Ticks] | None:
    """The camera's timestamp of each frame beside the tick of its trigger; None where the file has none."""
    stamps, numbers = read_field(file, layout.FRAME_TIMESTAMP), read_field(file, layout.FRAME_NUMBER)
    if stamps is None or triggers is None:
        return None
    numbers = np.arange(stamps.size) if numbers is None else numbers
    if numbers.size != stamps.size:
        return None
    known = (numbers >= 0) & (numbers < triggers.size)
    return stamps[known], triggers[numbers[known]]
