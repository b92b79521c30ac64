"""Recordings and results of cameras at several settings, and what the settings do to the timing."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import final

from irtiming.archive import layout, reader
from irtiming.archive.json_file import require_places, write_atomically, write_json
from irtiming.archive.result_file import checked_result, read_result
from irtiming.archive.rig_file import read_rig
from irtiming.archive.wheel_calibration_file import read_wheel_calibration
from irtiming.distribute.campaign import together
from irtiming.distribute.pieces import look
from irtiming.errors import ArchiveError
from irtiming.estimate.series import over_settings, points
from irtiming.measurement import Progress, analyse
from irtiming.records.campaign import Listed
from irtiming.records.choices import Choices, Language
from irtiming.records.setting_point import SettingPoint
from irtiming.records.setting_series import CameraSeries
from irtiming.report import result as report_result
from irtiming.report import series_page
from irtiming.report.language import writing_in


@final
@dataclass(frozen=True, kw_only=True)
class SeriesOrder:
    """What a person wants: recordings (``.nxs``) and results (``.json``) of any cameras, and the files to write.

    ``language`` is that of the report. Recordings need a ``rig``. Those of one camera at one setting are analysed together.
    """

    sources: tuple[Path, ...]
    rig: Path | None = None
    wheel_calibration: Path | None = None
    choices: Choices = field(default_factory=Choices)
    series: Path | None = None
    report: Path | None = None
    language: Language = "en"


def compare(order: SeriesOrder, *, progress: Progress | None = None) -> tuple[CameraSeries, ...]:
    """What each parameter does over each setting, camera by camera.

    Raises
    ------
    IrTimingError
        If a file cannot be read or written, a recording cannot be analysed, or results cannot be distinguished by camera.
    """
    require_places(
        {"JSON": [order.series], "HTML": [order.report]}, inputs=[*order.sources, order.rig, order.wheel_calibration]
    )
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
        with writing_in(order.language):
            page = series_page.page(series)
        write_atomically(page, order.report)
    return series


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
        found.append(points.point(checked_result(report_result.result(analysis)), label=", ".join(map(str, group))))
    return found


def alike(files: Sequence[Path]) -> list[tuple[Path, ...]]:
    """Recordings of one camera at one setting together, in order of appearance; their frames are not read.

    Raises
    ------
    ArchiveError
        If one cannot be read.
    """
    read = [look(Listed(path=path, is_one_of_many=False)) for path in files]
    return [tuple(one.listed.path for one in group) for group in together(read)]
