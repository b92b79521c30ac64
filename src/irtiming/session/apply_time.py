"""Times of frames and rows: a result put onto the stamps of a recording, of any file of frames or of a CSV."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

import numpy as np

from irtiming.apply import camera_timing, conditions, frame_times, settings
from irtiming.apply.camera_timing import MEANINGS, CameraTiming, Conditions
from irtiming.apply.frame_times import FrameTimes
from irtiming.apply.stamps import UNKNOWN_CLOCK, Generator, Latency
from irtiming.archive import layout
from irtiming.archive.frame_times_file import TimesToWrite, write_csv, write_into_copy, write_parquet
from irtiming.archive.frames.opening import files_read
from irtiming.archive.json_file import require_place
from irtiming.archive.nexus import program_version
from irtiming.archive.result_file import read_result
from irtiming.archive.result_model import Result
from irtiming.errors import ArchiveError, about
from irtiming.records.frame_events import NOUNS
from irtiming.session import frame_stamps
from irtiming.session.frame_stamps import Stamped, StampsWanted


@final
@dataclass(frozen=True, kw_only=True)
class TimeOrder:
    """What a person wants: a result, the stamps it is applied to, the rows that count (None: all) and the file to write.

    ``series`` are results of the same camera at other settings, between which the frames' may lie.
    """

    result: Path
    stamps: StampsWanted
    out: Path
    rows: tuple[int, ...] | None = None
    series: tuple[Path, ...] = ()


def generator_of(result: Result) -> Generator:
    """What rig.toml stated of the trigger generator with which the result was measured."""
    by_name = {one.name: one for one in result.rig.values if isinstance(one.value, float | int)}
    is_strobe = result.frame_event == "strobe"
    clock, late = (
        by_name.get("clock.relative_error"),
        by_name.get(f"latency.{'camera_input' if is_strobe else 'trigger'}"),
    )
    sign = -1.0 if is_strobe else 1.0
    return Generator(
        relative_error=0.0 if clock is None else float(clock.value),
        u_relative_error=UNKNOWN_CLOCK if clock is None else clock.standard_uncertainty or 0.0,
        way=None if late is None else Latency(value_s=sign * float(late.value), u_s=late.standard_uncertainty or 0.0),
    )


def camera_of(path: Path) -> CameraTiming:
    """The camera of a result file.

    Raises
    ------
    IrTimingError
        If it cannot be read or applied.
    """
    result = read_result(path)
    with about(path):
        return camera_timing.of_result(result)


def camera_at_setting(
    result: Result, series: tuple[Path, ...], *, source: Path
) -> tuple[CameraTiming, tuple[str, ...]]:
    """The camera of a result, or between several results at the setting of a file's frames; and what is to be said of that.

    Raises
    ------
    IrTimingError
        If a file cannot be read, or the results do not tell of that setting.
    """
    camera = camera_timing.of_result(result)
    if not series:
        return camera, ()
    others = [camera_of(path) for path in series]
    return settings.between([camera, *others], frame_stamps.conditions_of(source), where=str(source))


def apply_time(order: TimeOrder) -> FrameTimes:
    """When each row of each frame was exposed or read; written as CSV or Parquet, or into a copy of the recording.

    Raises
    ------
    IrTimingError
        If a file cannot be read or written, or the result does not hold for these frames.
    """
    taken = [order.result, *files_read(order.stamps.source), *order.series]
    taken += [order.stamps.calibrated_by] if order.stamps.calibrated_by else []
    is_copy, is_parquet = (order.out.suffix.lower() == suffix for suffix in (layout.SUFFIX, ".parquet"))
    require_place(
        order.out, "CSV", "Parquet", "recording", besides=taken, is_text=not is_copy and not is_parquet, is_new=is_copy
    )
    if is_copy and order.stamps.source.suffix.lower() != layout.SUFFIX:
        raise ArchiveError(
            "holds frames with their times, so the stamps must be those of a recording; write a .csv",
            where=str(order.out),
        )
    result = read_result(order.result)
    with about(order.result):
        camera, remarks = camera_at_setting(result, order.series, source=order.stamps.source)
    with about(order.stamps.source):
        stamped = frame_stamps.read(order.stamps, camera, generator=generator_of(result))
    if stamped.found is None:
        remarks += conditions.require(camera.conditions, Conditions(), where=str(order.stamps.source))
    remarks += conditions.doubted_unit(camera.conditions, stamped.events.frame_period_s)
    stamped = replace(stamped, events=replace(stamped.events, remarks=(*remarks, *stamped.events.remarks)))
    rows = None if order.rows is None else np.array(order.rows, dtype=np.float64)
    with about(order.result):
        times = frame_times.apply(camera, stamped.events, rows_px=rows)
    written = _to_write(times, stamped, order)
    if is_copy:
        write_into_copy(written, order.stamps.source, path=order.out)
    elif is_parquet:
        write_parquet(written, order.out)
    else:
        write_csv(written, order.out)
    return times


def _to_write(times: FrameTimes, stamped: Stamped, order: TimeOrder) -> TimesToWrite:
    names = [one.name for one in times.moments]
    return TimesToWrite(
        frames=stamped.numbers,
        trigger_s=stamped.events.time_s,
        origin_s=stamped.events.origin_s,
        rows=times.rows_px.astype(np.int64),
        offset_s={name: times.offset_s(name) for name in names},
        u_s={name: times.u_s(name) for name in names},
        correlation={name: times.correlation(name) for name in names},
        correlation_of_rows={name: times.correlation_of_rows(name) for name in names},
        head=tuple(head(times, order)),
    )


def head(times: FrameTimes, order: TimeOrder) -> Iterator[str]:
    """Lines that say what the numbers are: events, signs, uncertainties, and what they do not include."""
    camera = times.camera
    setting = camera.conditions
    yield f"{program_version()}: times of the frames of {order.stamps.source.name} by {order.result.name}"
    which = f"{setting.model or 'model not stated'}, serial number {setting.serial_number or 'not stated'}"
    yield f"camera: {setting.camera_type}, {setting.readout_mode}, {which}"
    yield f"scale: {times.events.scale}"
    yield f"reference event: {NOUNS[camera.event]}; a time is that event plus a delay, positive after it"
    yield "frame: number of the frame as its file has it; its index from 0 where the file has none"
    for one in times.moments:
        yield f"{one.name}: {MEANINGS[one.name]}"
    if setting.readout_mode == "snapshot":
        yield "row: all rows are read at once; row 0 stands for all"
    yield "u: standard uncertainty (k = 1) of a time; r: correlation coefficient of the times of one row in two frames"
    for remark in times.events.remarks:
        yield f"not in the uncertainties: {remark}" if "not stated" in remark else f"note: {remark}"
    for words in camera.not_in_uncertainty:
        yield f"not in the uncertainties: {words}"
    if camera.simulated:
        yield "SIMULATED: the result is not of a real camera"
