"""Recordings and results of cameras at several settings, and what the settings do to the timing."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import final

from irtiming.archive import layout, reader
from irtiming.archive.json_file import require_place, write_atomically, write_json
from irtiming.archive.result_file import checked_result, read_result
from irtiming.archive.result_model import Result
from irtiming.archive.rig_file import read_rig
from irtiming.archive.wheel_calibration_file import read_wheel_calibration
from irtiming.errors import ArchiveError
from irtiming.estimate.series import over_settings, points
from irtiming.measurement import Progress, analyse
from irtiming.records.choices import Choices
from irtiming.records.recording import Recording
from irtiming.records.setting_point import SettingPoint
from irtiming.records.setting_series import CameraSeries
from irtiming.report import result as report_result
from irtiming.report import series_page

_SAME_WINDOW_S = 1e-9
_SAME_PERIOD = 5e-3  # relative; plans for several wheel speeds have frame rates that differ by less


@final
@dataclass(frozen=True, kw_only=True)
class SeriesOrder:
    """What a person wants: recordings (``.nxs``) and results (``.json``) of any cameras, and the files to write.

    Recordings need a ``rig``. Those of one camera at one setting are analysed together.
    """

    sources: tuple[Path, ...]
    rig: Path | None = None
    wheel_calibration: Path | None = None
    choices: Choices = field(default_factory=Choices)
    series: Path | None = None
    report: Path | None = None


def compare(order: SeriesOrder, *, progress: Progress | None = None) -> tuple[CameraSeries, ...]:
    """What each parameter does over each setting, camera by camera.

    Raises
    ------
    IrTimingError
        If a file cannot be read or written, a recording cannot be analysed, or results cannot be told apart by camera.
    """
    _require_places(order)
    files = [path for path in order.sources if path.suffix.lower() == layout.SUFFIX]
    results = [path for path in order.sources if path not in files]
    if files and order.rig is None:
        raise ArchiveError(
            "is a recording, which needs the rig's numbers; give {rig} rig.toml, or results", "rig", where=str(files[0])
        )
    found = [points.point(read_result(path), label=str(path)) for path in results]
    found += _analysed(files, order, progress=progress)
    series = over_settings.by_camera(found)
    if order.series is not None:
        write_json(series_page.as_json(series), order.series)
    if order.report is not None:
        write_atomically(series_page.page(series), order.report)
    return series


def _require_places(order: SeriesOrder) -> None:
    taken = [*order.sources, *(path for path in (order.rig, order.wheel_calibration) if path is not None)]
    for place in (order.series, order.report):
        if place is not None:
            require_place(place, besides=taken)
            taken.append(place)


def _analysed(files: Sequence[Path], order: SeriesOrder, *, progress: Progress | None) -> list[SettingPoint]:
    if not files or order.rig is None:
        return []
    rig = read_rig(order.rig)
    wheel = None if order.wheel_calibration is None else read_wheel_calibration(order.wheel_calibration)
    found = []
    for group in alike(files):
        analysis = analyse(
            (reader.read(path) for path in group),
            rig,
            choices=order.choices,
            progress=progress,
            wheel_calibration=wheel,
        )
        found.append(points.point(result_of(report_result.result(analysis)), label=", ".join(map(str, group))))
    return found


def result_of(told: dict[str, object]) -> Result:
    """A result in memory as its file would give it back."""
    return checked_result(told)


def alike(files: Sequence[Path]) -> list[tuple[Path, ...]]:
    """Recordings of one camera at one setting together, in order of appearance; their frames are not read.

    Raises
    ------
    ArchiveError
        If one cannot be read.
    """
    groups: list[tuple[Recording, list[Path]]] = []
    for path in files:
        recording = reader.read(path)
        mine = next((paths for first, paths in groups if is_alike(first, recording)), None)
        if mine is None:
            groups.append((recording, [path]))
        else:
            mine.append(path)
    return [tuple(paths) for _, paths in groups]


def is_alike(one: Recording, other: Recording) -> bool:
    """Whether two recordings are of one camera at one setting; the FPA temperature may sway."""
    mine, theirs = one.settings, other.settings
    told = [
        (each.camera_type, each.readout_mode, each.frame_event, each.frames.shape[1:], each.camera and (
            each.camera.vendor, each.camera.model, each.camera.serial_number))
        for each in (one, other)
    ]  # fmt: skip
    return (
        told[0] == told[1]
        and (mine.gain_setting, mine.internal_delay_set_s, mine.region_first_row, mine.region_first_column)
        == (theirs.gain_setting, theirs.internal_delay_set_s, theirs.region_first_row, theirs.region_first_column)
        and _near(one.integration_time_s, other.integration_time_s, within=_SAME_WINDOW_S)
        and _near(one.frame_period_s, other.frame_period_s, within=_SAME_PERIOD * (one.frame_period_s or 0.0))
    )


def _near(one: float | None, other: float | None, *, within: float) -> bool:
    return one == other if one is None or other is None else abs(one - other) <= within
