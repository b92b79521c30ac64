"""Stamps of frames, from whatever file holds them, as trigger times that a result can be applied to."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

import numpy as np

from irtiming.apply import conditions, stamps
from irtiming.apply.camera_timing import CameraTiming, Conditions
from irtiming.apply.stamps import UNKNOWN_CLOCK, Generator, Latency, TriggerTimes
from irtiming.archive import layout, reader
from irtiming.archive.frames.opening import open_frames
from irtiming.archive.frames.source import FrameFacts
from irtiming.archive.stamps_file import read_stamps
from irtiming.errors import ConditionError
from irtiming.inference import stamp_line
from irtiming.records.application import StampKind
from irtiming.records.arrays import Array, Ticks
from irtiming.records.recording import Recording
from irtiming.units import readable_time

_CSV = (".csv", ".txt", ".tsv")
_SCALES: Mapping[StampKind, str] = {
    "trigger": "s of the clock that stamped the triggers",
    "camera": "s of the clock that stamped the frames",
    "arrival": "s of the clock that stamped the arrivals",
}


@final
@dataclass(frozen=True, kw_only=True)
class StampsWanted:
    """Which stamps of a file count, and how late they are.

    ``column`` and ``unit`` are for CSV. ``latency`` is by how much later than the trigger edge a stamp is; None: nobody said.
    ``calibrated_by`` is a recording in which the same camera, not switched off since, got triggers that were stamped.
    """

    source: Path
    kind: StampKind | None = None
    column: str | None = None
    unit: str | None = None
    latency: Latency | None = None
    calibrated_by: Path | None = None


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Stamped:
    """Trigger times of the frames of a file; ``frames`` their indices in it, shape (n_frame,), and what is said of the camera."""

    triggers: TriggerTimes
    frames: Ticks
    found: Conditions | None
    recording: Recording | None = None


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Raw:
    """Stamps as a file has them, shape (n_frame,), and the number of each frame where it says so."""

    kind: StampKind
    time_s: Array
    origin_s: int = 0
    step_s: float = 0.0
    numbers: Ticks | None = None


def read(wanted: StampsWanted, camera: CameraTiming, *, generator: Generator | None = None) -> Stamped:
    """Stamps of a recording, of any file of frames that has times, or of a CSV; a result that does not hold for them is refused.

    Parameters
    ----------
    wanted
        The file and what of it counts.
    camera
        Of the result.
    generator
        What rig.toml stated of the trigger generator that stamped recordings; None: nothing.

    Raises
    ------
    IrTimingError
        If the file cannot be read, has no such stamps, or is of another camera.
    """
    path = wanted.source
    if path.suffix.lower() in _CSV:
        column = read_stamps(path, column=wanted.column, unit=wanted.unit)
        raw = _Raw(
            kind=wanted.kind or "trigger",
            time_s=column.time_s,
            origin_s=column.origin_s,
            step_s=1e-9,
            numbers=column.numbers,
        )
        return Stamped(triggers=_triggers(raw, wanted), frames=np.arange(raw.time_s.size), found=None)
    if path.suffix.lower() == layout.SUFFIX:
        recording = reader.read(path)
        found = conditions.of_recording(recording)
        remarks = conditions.require(camera.conditions, found, where=str(path))
        if wanted.kind in (None, "trigger"):
            return _with(_of_triggers(recording, generator), remarks, found, recording)
        raw = _of_recording(recording, wanted)
        kept = np.arange(raw.time_s.size)
        return _with(Stamped(triggers=_triggers(raw, wanted), frames=kept, found=found), remarks, found, recording)
    facts = open_frames(path).facts
    found = _conditions(facts, camera)
    remarks = conditions.require(camera.conditions, found, where=str(path))
    raw = _of_facts(facts, wanted)
    stamped = Stamped(triggers=_triggers(raw, wanted), frames=np.arange(raw.time_s.size), found=found)
    return _with(
        stamped, (*remarks, "detector and readout mode were not compared: the file does not tell them"), found, None
    )


def _with(stamped: Stamped, remarks: tuple[str, ...], found: Conditions, recording: Recording | None) -> Stamped:
    triggers = replace(stamped.triggers, remarks=(*stamped.triggers.remarks, *remarks))
    return Stamped(triggers=triggers, frames=stamped.frames, found=found, recording=recording)


def _of_triggers(recording: Recording, generator: Generator | None) -> Stamped:
    number = recording.frame_number
    known = np.flatnonzero((number >= 0) & (number < recording.camera_trigger_ticks.size))
    if known.size == 0:
        raise ConditionError("no frame has a stamped trigger; give other stamps of it", where=recording.source)
    found = stamps.from_ticks(
        recording.camera_trigger_ticks[number[known]],
        clock_frequency_hz=recording.clock_frequency_hz,
        set_delay_s=recording.trigger_delay_time_set_s,
        generator=generator,
    )
    return Stamped(triggers=found, frames=known, found=None)


def _of_recording(recording: Recording, wanted: StampsWanted) -> _Raw:
    """Stamps of the camera or of the computer in a recording."""
    numbers = recording.frame_id
    if wanted.kind == "arrival":
        if recording.frame_host_time_s is None:
            raise ConditionError("has no times of arrival (frame_host_time); use other stamps", where=recording.source)
        return _Raw(kind="arrival", time_s=recording.frame_host_time_s, numbers=numbers)
    ticks, frequency = recording.frame_timestamp_ticks, recording.timestamp_frequency_hz
    if ticks is None or frequency is None or not np.all(ticks):
        raise ConditionError(
            "its frames do not all carry a stamp of the camera (frame_timestamp); use other stamps",
            where=recording.source,
        )
    return _Raw(kind="camera", time_s=ticks / frequency, step_s=1 / frequency, numbers=numbers)


def _of_facts(facts: FrameFacts, wanted: StampsWanted) -> _Raw:
    kind = wanted.kind or ("trigger" if facts.trigger_times_s is not None else "camera")
    times = facts.trigger_times_s if kind == "trigger" else facts.times_s
    if times is None:
        raise ConditionError(
            f"the file tells no {'triggers' if kind == 'trigger' else 'times'} of its frames; give its stamps as CSV",
            where=str(wanted.source),
        )
    origin_s = int(times[0])
    return _Raw(
        kind=kind, time_s=times - origin_s, origin_s=origin_s, step_s=facts.time_step_s or 0.0, numbers=facts.frame_id
    )


def _conditions(facts: FrameFacts, camera: CameraTiming) -> Conditions:
    return Conditions(
        camera_type=camera.conditions.camera_type,
        readout_mode=camera.conditions.readout_mode,
        serial_number="" if facts.camera is None else facts.camera.serial_number,
        model="" if facts.camera is None else facts.camera.model,
        integration_time_s=facts.integration_time_s,
        rows=facts.rows,
        columns=facts.columns,
    )


def _triggers(raw: _Raw, wanted: StampsWanted) -> TriggerTimes:
    """Trigger times that follow from stamps: their latency taken off, or by a clock that another recording tells."""
    late, remarks = wanted.latency, []
    if late is None:
        late = Latency(value_s=0.0, u_s=0.0)
        if raw.kind != "trigger":
            remarks.append("by how much later than the trigger edge a stamp is: nobody said, none was taken off")
    u_step_s = raw.step_s / 12**0.5
    if wanted.calibrated_by is not None:
        return _by_calibration(raw, wanted, late)
    if raw.kind == "trigger":
        return TriggerTimes(
            time_s=raw.time_s - late.value_s, origin_s=raw.origin_s, u_own_s=u_step_s, u_common_s=late.u_s,
            u_rate=UNKNOWN_CLOCK, scale=_SCALES["trigger"], remarks=tuple(remarks),
        )  # fmt: skip
    numbers = stamp_line.numbered(raw.time_s) if raw.numbers is None else raw.numbers - raw.numbers[0]
    line = stamp_line.grid(numbers, raw.time_s)
    on_line = line.stamp_s(numbers.astype(np.float64))
    u_line_s = float(np.sqrt(np.mean(line.u_s(numbers.astype(np.float64)) ** 2)))
    remarks.append(
        f"stamps scatter by {readable_time(line.jitter_s)} about a regular frame clock, {100 * line.late_share:.1f} % are later "
        f"by five times as much; frames every {readable_time(line.rate)}; it is taken that triggers were regular"
    )
    return TriggerTimes(
        time_s=on_line - late.value_s, origin_s=raw.origin_s, u_own_s=u_step_s, u_common_s=float(np.hypot(late.u_s, u_line_s)),
        u_rate=UNKNOWN_CLOCK, scale=_SCALES[raw.kind], remarks=tuple(remarks),
    )  # fmt: skip


def _by_calibration(raw: _Raw, wanted: StampsWanted, late: Latency) -> TriggerTimes:
    """Onto the trigger generator's clock, by a recording that has its triggers and the same stamps."""
    assert wanted.calibrated_by is not None
    recording = reader.read(wanted.calibrated_by)
    stamped = _of_triggers(recording, None)
    theirs = _of_recording(recording, replace(wanted, kind=raw.kind))
    line = stamp_line.median_line(stamped.triggers.time_s, theirs.time_s[stamped.frames])
    time_s = line.x_of(raw.time_s + raw.origin_s - late.value_s)
    beyond = float(np.max(np.abs(time_s - line.middle)))
    return TriggerTimes(
        time_s=time_s,
        u_own_s=float(np.hypot(line.jitter_s, raw.step_s / 12**0.5)),
        u_common_s=float(np.hypot(late.u_s, line.u_s(np.array([line.middle + beyond]))[0])),
        u_rate=UNKNOWN_CLOCK,
        scale=f"s of the trigger generator's counter in {wanted.calibrated_by.name}",
        remarks=(
            f"stamps follow that counter at a rate of 1 {line.rate - 1:+.3e}, jitter {readable_time(line.jitter_s)}: it is taken "
            "that neither clock was switched off since",
        ),
    )
