"""Stamps of frames, from whatever file holds them, as times of the events that a result counts from."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

import numpy as np

from irtiming.apply import conditions, stamps
from irtiming.apply.camera_timing import CameraTiming, Conditions
from irtiming.apply.stamps import EventTimes, Generator, Latency, Raw
from irtiming.archive import layout, reader
from irtiming.archive.frames.opening import open_frames
from irtiming.archive.frames.source import FrameFacts
from irtiming.archive.stamps_file import read_stamps
from irtiming.errors import ConditionError
from irtiming.inference import stamp_line
from irtiming.records.application import KIND_OF, StampKind
from irtiming.records.arrays import Ticks
from irtiming.records.frame_events import NOUNS
from irtiming.records.recording import Recording
from irtiming.reduce.events import numbering, placing
from irtiming.units import readable_time, require_uncertainty

_CSV = (".csv", ".txt", ".tsv")
_SCALES: Mapping[StampKind, str] = {
    "trigger": "s of the clock that stamped the triggers",
    "strobe": "s of the clock that stamped the strobe",
    "camera": "s of the clock that stamped the frames",
    "arrival": "s of the clock that stamped the arrivals",
}
_WORDS: Mapping[StampKind, str] = {
    "trigger": "trigger edges", "strobe": "edges of the strobe", "camera": "stamps of the camera",
    "arrival": "arrivals at the computer",
}  # fmt: skip


@final
@dataclass(frozen=True, kw_only=True)
class StampsWanted:
    """Which stamps of a file count, and how late they are.

    ``column`` and ``unit`` are for CSV. ``latency_s`` is by how much later than the event a stamp is, None: not stated, and
    ``latency_u_s`` its standard uncertainty. ``alone`` takes each stamp by itself in place of the regular grid of all.
    ``calibrated_by`` is a recording in which the same camera, not switched off since, got triggers that were stamped.
    """

    source: Path
    kind: StampKind | None = None
    column: str | None = None
    unit: str | None = None
    latency_s: float | None = None
    latency_u_s: float = 0.0
    alone: bool = False
    calibrated_by: Path | None = None

    def __post_init__(self) -> None:
        require_uncertainty(self.latency_u_s, of=self.latency_s, fields=("latency_s", "latency_u_s"))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Stamped:
    """Events of the frames of a file, and what is said of the camera.

    ``frames`` are their indices in the file, ``numbers`` what the file numbers them by, or the indices where it does not
    (``is_numbered``); shape (n_frame,) both. ``found`` is None for stamps alone, which say nothing of it.
    """

    events: EventTimes
    frames: Ticks
    numbers: Ticks
    found: Conditions | None
    recording: Recording | None = None
    is_numbered: bool = True


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
        raw = Raw(time_s=column.time_s, origin_s=column.origin_s, step_s=1e-9, numbers=column.numbers)
        events = _events(raw, wanted, camera=camera, generator=generator, kind=wanted.kind or KIND_OF[camera.event])
        return _all_of(raw, events, numbers=column.numbers, found=None)
    if path.suffix.lower() == layout.SUFFIX:
        return of_recording(reader.read(path), wanted, camera=camera, generator=generator)
    facts = open_frames(path).facts
    found = conditions.of_facts(facts)
    remarks = conditions.require(camera.conditions, found, where=str(path))
    kind = wanted.kind or KIND_OF[camera.event]
    if wanted.kind is None and camera.event == "trigger" and facts.trigger_times_s is None:
        kind = "camera"
    raw = _of_facts(facts, wanted, kind=kind)
    events = _events(raw, wanted, camera=camera, generator=generator, kind=kind)
    stamped = _all_of(raw, events, numbers=facts.frame_id, found=found)
    return _with(stamped, remarks, found, None)


def conditions_of(path: Path) -> Conditions:
    """What a file says of its camera and setting, without its stamps.

    Raises
    ------
    IrTimingError
        If it cannot be read, or is a CSV, which says nothing.
    """
    if path.suffix.lower() in _CSV:
        raise ConditionError(
            "a CSV does not state how the camera was set; give the result of its setting alone", where=str(path)
        )
    if path.suffix.lower() == layout.SUFFIX:
        return conditions.of_recording(reader.read(path))
    return conditions.of_facts(open_frames(path).facts)


def of_recording(
    recording: Recording, wanted: StampsWanted, *, camera: CameraTiming, generator: Generator | None = None
) -> Stamped:
    """Events of the frames of a recording that is at hand; parameters and errors as for `read`."""
    found = conditions.of_recording(recording)
    remarks = conditions.require(camera.conditions, found, where=recording.source)
    kind = wanted.kind or KIND_OF[camera.event]
    if kind in ("trigger", "strobe") and kind == KIND_OF[camera.event]:
        of_edges = _of_triggers if kind == "trigger" else _of_strobe
        return _with(of_edges(recording, generator), remarks, found, recording)
    if camera.event != "trigger" and recording.frame_event == "trigger":
        remarks = (*remarks, "the recording's camera was triggered, the result measured it running free")
    raw = _of_recording(recording, kind)
    events = _events(raw, wanted, camera=camera, generator=generator, kind=kind)
    return _with(_all_of(raw, events, numbers=recording.frame_number, found=found), remarks, found, recording)


def _all_of(raw: Raw, events: EventTimes, *, numbers: Ticks | None, found: Conditions | None) -> Stamped:
    """All frames of a file that numbers them, or does not."""
    frames = np.arange(raw.time_s.size)
    return Stamped(
        events=events, frames=frames, numbers=frames if numbers is None else numbers, found=found,
        is_numbered=numbers is not None,
    )  # fmt: skip


def _with(stamped: Stamped, remarks: tuple[str, ...], found: Conditions, recording: Recording | None) -> Stamped:
    events = replace(stamped.events, remarks=(*stamped.events.remarks, *remarks))
    return replace(stamped, events=events, found=found, recording=recording)


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
    return Stamped(events=found, frames=known, numbers=number[known], found=None)


def _of_strobe(recording: Recording, generator: Generator | None) -> Stamped:
    """The strobe edge of each frame; what was found of their pairing goes along."""
    if recording.camera_input_ticks is None:
        raise ConditionError(
            "has no edges of the camera's strobe (camera_input), from which the result counts; record them, or give them as CSV",
            where=recording.source,
        )
    placed = placing.placed(replace(recording, frame_event="strobe"))
    found = stamps.from_ticks(
        placed.camera_trigger_ticks[placed.frame_number],
        clock_frequency_hz=recording.clock_frequency_hz,
        generator=generator,
    )
    remarks = tuple(one.what for one in placed.findings[len(recording.findings) :])
    kept = np.arange(placed.frame_number.size)
    stamped = Stamped(events=found, frames=kept, numbers=recording.frame_number, found=None)
    return _with(stamped, remarks, conditions.of_recording(recording), recording)


def _of_recording(recording: Recording, kind: StampKind) -> Raw:
    """Stamps of the camera or of the computer in a recording."""
    numbers = numbering.counts(recording).number
    if kind == "arrival":
        if recording.frame_host_time_s is None:
            raise ConditionError("has no times of arrival (frame_host_time); use other stamps", where=recording.source)
        origin_s = int(recording.frame_host_time_s[0])
        return Raw(time_s=recording.frame_host_time_s - origin_s, origin_s=origin_s, numbers=numbers)
    if kind != "camera":
        raise ConditionError(
            f"its {_WORDS[kind]} are asked for, but the result counts from other events; leave --kind out",
            where=recording.source,
        )
    ticks, frequency = recording.frame_timestamp_ticks, recording.timestamp_frequency_hz
    if ticks is None or frequency is None or not np.all(ticks):
        raise ConditionError(
            "its frames do not all carry a stamp of the camera (frame_timestamp); use other stamps",
            where=recording.source,
        )
    origin_s = 0 if frequency % 1 else int(ticks[0] // round(frequency))
    time_s = (ticks - origin_s * round(frequency)) / frequency
    return Raw(time_s=time_s, origin_s=origin_s, step_s=1 / frequency, numbers=numbers)


def _of_facts(facts: FrameFacts, wanted: StampsWanted, *, kind: StampKind) -> Raw:
    if kind == "strobe":
        raise ConditionError("the file has no strobe edges; give them as CSV", where=str(wanted.source))
    times = facts.trigger_times_s if kind == "trigger" else facts.times_s
    if times is None:
        raise ConditionError(
            f"the file has no {'triggers' if kind == 'trigger' else 'times'} of its frames; give its stamps as CSV",
            where=str(wanted.source),
        )
    origin_s = int(times[0])
    return Raw(time_s=times - origin_s, origin_s=origin_s, step_s=facts.time_step_s or 0.0, numbers=facts.frame_id)


def _events(
    raw: Raw, wanted: StampsWanted, *, camera: CameraTiming, generator: Generator | None, kind: StampKind
) -> EventTimes:
    """Events that follow from stamps: latency taken off, on a grid where they scatter, or by a clock of another recording."""
    is_own = kind == KIND_OF[camera.event]
    late, scale = Latency(value_s=wanted.latency_s or 0.0, u_s=wanted.latency_u_s), _SCALES[kind]
    remarks: tuple[str, ...] = ()
    if wanted.latency_s is None and not is_own:
        if camera.event != "trigger":
            raise ConditionError(
                f"the result counts from {NOUNS[camera.event]}, these are {_WORDS[kind]}; give {_WORDS[KIND_OF[camera.event]]}, "
                "or say by --latency how much later than those they are",
                where=str(wanted.source),
            )
        remarks = ("by how much later than the trigger edge a stamp is: not stated, none was taken off",)
    if wanted.calibrated_by is not None:
        recording = reader.read(wanted.calibrated_by)
        edges = (_of_strobe if camera.event == "strobe" else _of_triggers)(recording, generator)
        found = _by_calibration(raw, edges, theirs=_of_recording(recording, kind), late=late)
        return replace(found, scale=f"s of the trigger generator's counter in {wanted.calibrated_by.name}")
    if kind in ("trigger", "strobe"):
        return replace(stamps.each_exact(raw, scale=scale, latency=late), remarks=remarks)
    is_few = is_own and camera.scatter is not None and raw.time_s.size < stamp_line.FEWEST
    if wanted.alone or is_few:
        if not is_own or camera.scatter is None or wanted.latency_s is not None:
            raise ConditionError(
                f"the result does not know how {_WORDS[kind]} scatter, which it must where each counts by itself; leave out "
                "--alone, or measure the camera by such stamps",
                where=str(wanted.source),
            )
        return stamps.each_alone(raw, scale=scale, scatter=camera.scatter)
    found = stamps.on_grid(raw, scale=scale, latency=late)
    if is_own and kind == "arrival":
        remarks = ("it is taken that arrivals are as late, by their median, as they were when the result was measured",)
    return replace(found, remarks=(*remarks, *found.remarks))


def _by_calibration(raw: Raw, edges: Stamped, *, theirs: Raw, late: Latency) -> EventTimes:
    """Onto the trigger generator's clock, by its ``edges`` in a recording whose frames have such stamps too, ``theirs``."""
    line = stamp_line.median_line(edges.events.time_s, theirs.time_s[edges.frames])
    time_s = line.x_of(raw.time_s + (raw.origin_s - theirs.origin_s) - late.value_s)
    beyond = float(np.max(np.abs(time_s - line.middle)))
    return replace(
        edges.events,
        time_s=time_s,
        u_own_s=float(np.hypot(line.jitter_s, raw.u_step_s)),
        u_common_s=float(np.hypot(late.u_s, line.u_s(np.array([line.middle + beyond]))[0])),
        remarks=(
            *edges.events.remarks,
            f"stamps follow that counter at a rate of 1 {line.rate - 1:+.3e}, jitter {readable_time(line.jitter_s)}: it is taken "
            "that neither clock was switched off since",
        ),
    )
