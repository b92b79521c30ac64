"""Recordings in files analysed, and what was found written as result and report."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, final

from irtiming.archive import reader
from irtiming.archive.json_file import require_place, write_atomically
from irtiming.archive.result_file import write_result
from irtiming.archive.rig_file import read_rig
from irtiming.archive.wheel_calibration_file import read_wheel_calibration
from irtiming.measurement import ALL_EXTRAS, Progress
from irtiming.measurement import analyse as analyse_recordings
from irtiming.records.analysis import Analysis
from irtiming.records.choices import Choices
from irtiming.records.recording import Recording
from irtiming.report import certificate


@final
@dataclass(frozen=True, kw_only=True)
class AnalysisOrder:
    """What a person wants analysed: recordings of one camera on one rig, and the files to write."""

    recordings: tuple[Path, ...]
    rig: Path
    choices: Choices = field(default_factory=Choices)
    wheel_calibration: Path | None = None
    result: Path | None = None
    report: Path | None = None


def analyse(order: AnalysisOrder, *, progress: Progress | None = None) -> Analysis:
    """Timing of a camera from its recordings.

    Raises
    ------
    IrTimingError
        If a file cannot be read or written, or the data do not determine the timing.
    """
    _require_places(order)
    rig = read_rig(order.rig)
    wheel = None if order.wheel_calibration is None else read_wheel_calibration(order.wheel_calibration)
    extras = ALL_EXTRAS if order.result or order.report else ()
    found = analyse_recordings(
        _read(order), rig, choices=order.choices, progress=progress, wheel_calibration=wheel, extras=extras
    )
    if extras:
        write(found, result=order.result, report=order.report)
    return found


def write(found: Analysis, *, result: Path | None = None, report: Path | None = None) -> Mapping[str, Any]:
    """Write what was found as JSON, as a page, or both; gives the result as plain data.

    Raises
    ------
    ArchiveError
        If a file cannot be written.
    """
    told = certificate.report(found)
    if result is not None:
        write_result(told.result, result)
    if report is not None:
        write_atomically(told.page, report)
    return told.result


def _require_places(order: AnalysisOrder) -> None:
    """No place where nothing may be written, before the long work."""
    taken = [*order.recordings, order.rig, *([order.wheel_calibration] if order.wheel_calibration else [])]
    for place in (order.result, order.report):
        if place is not None:
            require_place(place, besides=taken)
            taken.append(place)


def _read(order: AnalysisOrder) -> Iterator[Recording]:
    """One recording after the other; a choice that means nothing for its kind of camera is refused."""
    for path in order.recordings:
        recording = reader.read(path)
        order.choices.check_for(recording)
        yield recording
