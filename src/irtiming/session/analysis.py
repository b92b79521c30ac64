"""Recordings in files analysed, and what was found written as result and report."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, final

from irtiming.archive import reader
from irtiming.archive.json_file import require_places, write_atomically
from irtiming.archive.map_file import write_maps
from irtiming.archive.result_file import write_result
from irtiming.archive.rig_file import read_rig
from irtiming.archive.wheel_calibration_file import read_wheel_calibration
from irtiming.errors import ArchiveError, EstimationError
from irtiming.measurement import ALL_EXTRAS, Extra, Progress
from irtiming.measurement import analyse as analyse_recordings
from irtiming.records.analysis import Analysis
from irtiming.records.choices import Choices, Language
from irtiming.records.recording import Recording
from irtiming.report import certificate, map_figure
from irtiming.report import result as plain_result


@final
@dataclass(frozen=True, kw_only=True)
class AnalysisOrder:
    """What a person wants analysed: recordings of one camera on one rig, and the files to write; ``language`` is the report's."""

    recordings: tuple[Path, ...]
    rig: Path
    choices: Choices = field(default_factory=Choices)
    wheel_calibration: Path | None = None
    result: Path | None = None
    report: Path | None = None
    maps: Path | None = None
    language: Language = "en"

    @property
    def picture(self) -> Path | None:
        """Of the maps: beside them, with the same name."""
        return None if self.maps is None else self.maps.with_suffix(".png")


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
    is_reported = bool(order.result or order.report)
    extras: tuple[Extra, ...] = (*(ALL_EXTRAS if is_reported else ()), *(("maps",) if order.maps else ()))
    found = analyse_recordings(
        _read(order), rig, choices=order.choices, progress=progress, wheel_calibration=wheel, extras=extras
    )
    if is_reported:
        write(found, result=order.result, report=order.report, language=order.language)
    if order.maps is not None:
        write_maps_of(found, order.maps)
    return found


def write_maps_of(found: Analysis, path: Path) -> None:
    """Write the maps of an analysis as HDF5, and a picture of them beside it.

    Raises
    ------
    IrTimingError
        If the analysis made none, or a file cannot be written.
    """
    if found.maps is None:
        raise EstimationError("this analysis made no maps; ask for them when you analyse the recordings")
    write_maps(found.maps, path, recordings=[one.file for one in found.recordings])
    write_atomically(map_figure.png(found.maps), path.with_suffix(".png"))


def write(
    found: Analysis, *, result: Path | None = None, report: Path | None = None, language: Language = "en"
) -> Mapping[str, Any]:
    """Write what was found as JSON, as a page in a language, or both; gives the result as plain data.

    Raises
    ------
    ArchiveError
        If a file cannot be written.
    """
    if report is None:  # figures take half of the time, and are drawn for a report alone
        data = plain_result.result(found)
    else:
        written = certificate.report(found, written_in=language)
        data = written.result
        write_atomically(written.page, report)
    if result is not None:
        write_result(data, result)
    return data


def _require_places(order: AnalysisOrder) -> None:
    """No place where nothing may be written, before the long work."""
    if order.maps is not None and order.maps.suffix.lower() not in (".h5", ".hdf5", ".nxs"):
        raise ArchiveError(
            f"{order.maps}: maps are written as HDF5 with a picture, NAME.png, beside them; give a name that ends in .h5"
        )
    require_places(
        {"JSON": [order.result], "HTML": [order.report]},
        files=[order.maps, order.picture],
        inputs=[*order.recordings, order.rig, order.wheel_calibration],
    )


def _read(order: AnalysisOrder) -> Iterator[Recording]:
    """One recording after the other; a choice that means nothing for its kind of camera is refused."""
    for path in order.recordings:
        recording = reader.read(path)
        order.choices.check_for(recording)
        yield recording
