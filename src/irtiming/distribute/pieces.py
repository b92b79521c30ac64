"""The pieces of a campaign as a worker does them: to look at a recording, and to analyse those of one camera at one setting."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

from irtiming.archive import reader
from irtiming.archive.json_file import plain
from irtiming.archive.rig_file import read_rig
from irtiming.archive.wheel_calibration_file import read_wheel_calibration
from irtiming.errors import ArchiveError
from irtiming.measurement import analyse
from irtiming.records.camera_settings import CameraSettings
from irtiming.records.campaign import Listed
from irtiming.records.setting_point import CameraKey
from irtiming.report import result

_SAME_PERIOD = 5e-3
"""Relative; plans for several wheel speeds have frame periods that differ by less."""


@final
@dataclass(frozen=True, kw_only=True)
class Seen:
    """What a recording says of itself, without its frames."""

    listed: Listed
    sha256: str
    camera: CameraKey
    settings: CameraSettings
    integration_time_s: float | None
    frame_period_s: float | None
    size: tuple[int, int]
    wheel_hz: float

    def goes_with(self, other: "Seen") -> bool:
        """Whether both are at one setting; they are of one camera."""
        one, two = self.settings, other.settings
        periods = (self.frame_period_s or 0.0, other.frame_period_s or 0.0)
        return (
            (self.integration_time_s, self.size) == (other.integration_time_s, other.size)
            and (one.gain_setting, one.internal_delay_set_s, one.region_first_row, one.region_first_column)
            == (two.gain_setting, two.internal_delay_set_s, two.region_first_row, two.region_first_column)
            and abs(periods[0] - periods[1]) <= _SAME_PERIOD * max(periods)
        )


@final
@dataclass(frozen=True, kw_only=True)
class Unit:
    """What is analysed together, with the rig and, where there is one, the wheel calibration."""

    recordings: tuple[Path, ...]
    rig: Path
    wheel: Path | None


def look(listed: Listed) -> Seen:
    """What a recording says of itself, with the checksum of its file.

    Raises
    ------
    ArchiveError
        If it cannot be read, says that it is of another camera than it was listed for, or which is not stated.
    """
    recording = reader.read(listed.path)
    camera = recording.camera
    said = "" if camera is None else camera.serial_number
    if listed.serial_number and said and listed.serial_number != said:
        raise ArchiveError(
            f"is listed for serial number '{listed.serial_number}', but the recording says '{said}'; correct the table",
            where=str(listed.path),
        )
    serial = listed.serial_number or said
    if not serial and listed.is_one_of_many:
        raise ArchiveError(
            "names no serial number, and the recordings of two cameras must never be taken together; list it in a table.csv with "
            "its serial_number",
            where=str(listed.path),
        )
    return Seen(
        listed=listed, sha256=recording.sha256,
        camera=CameraKey(
            manufacturer="" if camera is None else camera.vendor, model="" if camera is None else camera.model,
            serial_number=serial, camera_type=recording.camera_type, readout_mode=recording.readout_mode,
            event=recording.frame_event,
        ),
        settings=recording.settings, integration_time_s=recording.integration_time_s,
        frame_period_s=recording.frame_period_s, size=recording.frames.shape[1:], wheel_hz=recording.rotation_speed_hz,
    )  # fmt: skip


def analysed(unit: Unit) -> dict[str, Any]:
    """The result of a unit as plain data.

    Raises
    ------
    IrTimingError
        If a file cannot be read, or the data do not determine the timing.
    """
    wheel = None if unit.wheel is None else read_wheel_calibration(unit.wheel)
    recordings = (reader.read(path) for path in unit.recordings)
    return dict(plain(result.result(analyse(recordings, read_rig(unit.rig), wheel_calibration=wheel))))
