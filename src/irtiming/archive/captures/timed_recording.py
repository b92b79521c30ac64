"""Frames and the tick streams of a capture together: a recording that is ready for the analysis."""

import shutil
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from irtiming.archive import consistency, layout
from irtiming.archive.captures.camera_frames import CameraFacts as CameraFacts
from irtiming.archive.captures.camera_frames import camera_frames
from irtiming.archive.captures.streams import STREAMS, CapturedTicks
from irtiming.archive.fields import read_field
from irtiming.archive.finding import Complaint, archive_error
from irtiming.archive.frames.opening import reader_of, readers
from irtiming.archive.hdf5_file import H5_ERRORS, opened, reason_of
from irtiming.archive.hdf5_output import writing
from irtiming.archive.layout import Field
from irtiming.archive.reader import check_version
from irtiming.archive.recording_checks import check_stamps
from irtiming.archive.whole_file import unwritable, whole_file
from irtiming.archive.writer import values_of, write
from irtiming.errors import ArchiveError
from irtiming.records.finding import Finding
from irtiming.records.frame_events import FrameEvent
from irtiming.records.recording import USUAL_READOUT, Recording

if TYPE_CHECKING:
    from irtiming.archive.consistency import Contents

_REPLACED = (
    layout.CLOCK_FREQUENCY, layout.CAMERA_PERIOD, layout.WHEEL_PERIOD, layout.LOST_AFTER, layout.CAMERA_TRIGGER_DELAYED,
    layout.COUNTER_EXCHANGE_BEFORE, layout.COUNTER_EXCHANGE, layout.COUNTER_EXCHANGE_AFTER, *STREAMS,
)  # fmt: skip
"""What is in ticks: of the old clock it means nothing beside the new one."""


def write_timed(
    frames: str | Path,
    out: str | Path,
    *,
    ticks: CapturedTicks,
    facts: CameraFacts | None = None,
    is_delayed: bool = False,
) -> list[Finding]:
    """Write a recording that has its frames from one file and its timestamps from a capture.

    Parameters
    ----------
    frames
        A recording, with timestamps or without: everything else in it is kept. Or frames of any other format: see
        `camera_frames`.
    out
        The recording to make; the file of the frames is left as it is.
    ticks
        From the capture.
    facts
        Needed with other frames, refused with a recording.
    is_delayed
        The captured trigger is the delayed one, which the camera gets: the recording's trigger_delay_time_set is taken off.

    Returns
    -------
    Oddities that do not stop an analysis.

    Raises
    ------
    ArchiveError
        If a file cannot be read or written, or frames and timestamps contradict each other.
    """
    source, target = Path(frames), Path(out)
    if is_delayed and layout.CAMERA_TRIGGER not in ticks.streams:
        raise ArchiveError("--map has no camera_trigger; leave out --delayed-trigger, or name the line of the trigger")
    if target.exists():
        raise ArchiveError(f"{target}: exists already; choose another name")
    is_recording = source.suffix.lower() != ".npz" and _is_recording(source, facts)
    if not is_recording and facts is None:
        raise ArchiveError(f"{source}: these frames do not state their camera; give --camera and --wheel-hz")
    if is_recording and facts is not None:
        raise ArchiveError(f"{source}: a recording states its camera itself; leave out --camera and what goes with it")
    if facts is not None:
        recording = _from_frames(source, _nominal(ticks, facts.trigger_delay_time_set_s, is_delayed), facts)
        findings = _oddities(_contents(recording), called=target)
        write(recording, target)
        return findings
    with whole_file(target) as part:
        _replace_ticks(source, part, ticks, is_delayed=is_delayed)
        return _oddities(_read_back(part, called=target), called=target)


def _replace_ticks(source: Path, part: Path, ticks: CapturedTicks, *, is_delayed: bool) -> None:
    """Copy a recording and put the captured timestamps in the place of its own."""
    try:
        with opened(source) as file:
            check_version(file)
            kept = {field: read_field(file, field) for field in layout.FIELDS if field not in _REPLACED}
            periods = _periods(file, ticks)
    except Complaint as complaint:
        raise complaint.as_error(source) from complaint
    nominal = _nominal(ticks, kept[layout.TRIGGER_DELAY_TIME_SET] or 0.0, is_delayed)
    try:
        shutil.copyfile(source, part)
    except OSError as error:
        raise unwritable(part, error) from error
    values: dict[Field, Any] = {**nominal.streams, **periods, layout.CLOCK_FREQUENCY: float(ticks.clock_frequency_hz)}
    try:
        with writing(part, "r+") as (file, _):
            group = file.require_group(layout.TRIGGER_GENERATOR)
            for field in _REPLACED:
                if field.name in group:
                    del group[field.name]
                if field in values:
                    dataset = group.create_dataset(field.name, data=values[field])
                    dataset.attrs["units"] = field.unit
            if layout.FRAME_EVENT.path in file:
                del file[layout.FRAME_EVENT.path]
            if (event := _event(ticks)) != "trigger":
                file[layout.FRAME_EVENT.path] = event
            group.attrs["NX_class"] = layout.GROUPS[layout.TRIGGER_GENERATOR]
    except H5_ERRORS as error:
        raise ArchiveError(f"{part}: cannot be written ({reason_of(error)}); is the disk full?") from error


def _event(ticks: CapturedTicks) -> FrameEvent:
    """What frames count from: a capture without triggers has the strobe of a camera that runs free."""
    return "trigger" if layout.CAMERA_TRIGGER in ticks.streams else "strobe"


def _periods(file: h5py.File, ticks: CapturedTicks) -> dict[Field, int]:
    """C and T of the trigger scheme in ticks of the capture's clock; nothing where they are no whole numbers of them."""
    fields = (layout.CAMERA_PERIOD, layout.WHEEL_PERIOD)
    try:
        old_hz, *old = (read_field(file, field) for field in (layout.CLOCK_FREQUENCY, *fields))
    except Complaint:
        return {}
    if old_hz is None or None in old:
        return {}
    new = [Fraction(one) * ticks.clock_frequency_hz / Fraction(old_hz) for one in old]
    return dict(zip(fields, map(int, new), strict=True)) if all(one.denominator == 1 for one in new) else {}


def _nominal(ticks: CapturedTicks, delay_s: float, is_delayed: bool) -> CapturedTicks:
    """The same streams with the nominal trigger, before the delay that is set."""
    if not is_delayed:
        return ticks
    late = round(Fraction(delay_s) * ticks.clock_frequency_hz)
    triggers = ticks.streams[layout.CAMERA_TRIGGER] - late
    return CapturedTicks(
        clock_frequency_hz=ticks.clock_frequency_hz, streams={**ticks.streams, layout.CAMERA_TRIGGER: triggers}
    )


def _from_frames(source: Path, ticks: CapturedTicks, facts: CameraFacts) -> Recording:
    """Recording of frames that come without one."""
    triggers = ticks.streams.get(layout.CAMERA_TRIGGER)
    taken = camera_frames(
        source, facts, triggers_s=None if triggers is None else triggers / float(ticks.clock_frequency_hz)
    )
    return Recording(
        name=source.stem,
        camera_type=facts.camera_type,
        readout_mode=facts.readout_mode or USUAL_READOUT[facts.camera_type],
        clock_frequency_hz=float(ticks.clock_frequency_hz),
        frame_event=_event(ticks),
        camera_trigger_ticks=ticks.streams.get(layout.CAMERA_TRIGGER, np.zeros(0, np.int64)),
        control_slot_ticks=ticks.streams[layout.CONTROL_SLOT],
        application_slot_ticks=ticks.streams[layout.APPLICATION_SLOT],
        application_edge_ticks=ticks.streams.get(layout.APPLICATION_EDGES),
        camera_trigger_delayed_ticks=ticks.streams.get(layout.CAMERA_TRIGGER_DELAYED),
        camera_input_ticks=ticks.streams.get(layout.CAMERA_INPUT),
        spare_ticks=ticks.streams.get(layout.SPARE),
        lost_after_ticks=ticks.streams.get(layout.LOST_AFTER),
        rotation_speed_hz=facts.rotation_speed_hz,
        trigger_delay_time_set_s=facts.trigger_delay_time_set_s,
        **vars(taken),
    )


def _is_recording(source: Path, facts: CameraFacts | None) -> bool:
    """Whether a file tells its camera itself; an HDF5 file of which nothing else is stated is taken for one."""
    reader = reader_of(source)
    if facts is None and (reader is None or reader is readers()["hdf5_stack"]):
        return True
    if reader is not readers()["hdf5_stack"]:
        return False
    try:
        with opened(source) as file:
            return layout.CAMERA_TYPE.path in file
    except Complaint as complaint:
        raise complaint.as_error(source) from complaint


def _contents(recording: Recording) -> "Contents":
    """What the checks look at, of a recording that is not yet written."""
    reference = recording.nonuniformity
    low, high = (None, None) if reference is None else (reference.low_frames, reference.high_frames)
    return values_of(recording) | {
        layout.FRAMES: recording.frames.shape,
        layout.REFERENCE_LOW: None if low is None else low.shape,
        layout.REFERENCE_HIGH: None if high is None else high.shape,
    }


def _read_back(part: Path, *, called: Path) -> "Contents":
    try:
        with opened(part) as file:
            return {field: read_field(file, field) for field in layout.FIELDS}
    except Complaint as complaint:
        raise complaint.as_error(called) from complaint


def _oddities(contents: "Contents", *, called: Path) -> list[Finding]:
    """What is odd about a recording; what makes it unusable is raised."""
    findings = [*consistency.check(contents), *check_stamps(contents)]
    for finding in findings:
        if (
            finding.severity == "error" and finding.where != layout.LOST_AFTER.path
        ):  # written, so that it is not overlooked
            raise archive_error(called, finding)
    return findings
