"""A wheel calibrated from the timestamps of recordings."""

from dataclasses import dataclass
from pathlib import Path
from typing import final

from irtiming.archive import reader
from irtiming.archive.json_file import require_places, write_atomically
from irtiming.archive.rig_file import read_rig
from irtiming.archive.wheel_calibration_file import write_wheel_calibration
from irtiming.records.choices import ReferenceEdge
from irtiming.records.wheel_calibration import WheelCalibration
from irtiming.reduce.wheel import wheel_calibration
from irtiming.report import sheet
from irtiming.report.sections import wheel as wheel_section


@final
@dataclass(frozen=True, kw_only=True)
class CalibrationOrder:
    """What a person wants: recordings of one wheel on one rig, the calibration to write, and a drawing of it."""

    recordings: tuple[Path, ...]
    rig: Path
    calibration: Path
    picture: Path | None = None
    reference_edge: ReferenceEdge = "automatic"


def calibrate(order: CalibrationOrder) -> WheelCalibration:
    """Angles of the control slots and application edges from the timestamps alone; frames are not looked at.

    Raises
    ------
    IrTimingError
        If a file cannot be read or written, or the timestamps do not determine the wheel.
    """
    require_places({"JSON": [order.calibration], "SVG": [order.picture]}, inputs=[*order.recordings, order.rig])
    rig, recordings = read_rig(order.rig), (reader.read(path) for path in order.recordings)
    wheel = wheel_calibration.from_recordings(recordings, rig, reference_edge=order.reference_edge)
    write_wheel_calibration(wheel, order.calibration)
    if order.picture is not None:
        drawing = sheet.svg(wheel_section.calibration(wheel), title="Deviation of the control slots, and its orders")
        write_atomically(drawing, order.picture)
    return wheel
