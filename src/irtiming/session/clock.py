"""The trigger generator's clock, and the camera's, from recordings of a pulse per second."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, final

from irtiming.archive import layout, rig_update
from irtiming.archive.json_file import require_places, write_atomically, write_json
from irtiming.archive.timestamps_file import TimedRun, read_timestamps
from irtiming.errors import EstimationError
from irtiming.estimate import clock
from irtiming.physics.clock_rate import camera_clock
from irtiming.records.clock_check import CameraClock, ClockCheck
from irtiming.records.rig import Clock
from irtiming.report import sheet
from irtiming.report.sections import clock as clock_section


@final
@dataclass(frozen=True, kw_only=True)
class ClockOrder:
    """What a person wants: recordings or timestamps with pulses at the spare input, and where the result goes.

    ``rig`` gets the lines of its section ``clock``. ``pulse_u`` is the relative standard uncertainty of the pulses' own rate.
    """

    recordings: tuple[Path, ...]
    pulse_period_s: float = 1.0
    pulse_u: float = 0.0
    rig: Path | None = None
    json: Path | None = None
    picture: Path | None = None


@final
@dataclass(frozen=True, kw_only=True)
class ClockFound:
    """What the recordings tell: of the trigger generator's clock, None where no pulses came, and of the camera's."""

    checks: tuple[ClockCheck, ...]
    cameras: tuple[CameraClock, ...]
    clock: Clock | None

    @property
    def lines(self) -> str:
        """For rig.toml; empty where no pulses came."""
        return "" if self.clock is None else rig_update.section_text("clock", rig_update.clock_lines(self.clock))


def evaluate(order: ClockOrder) -> ClockFound:
    """Error, drift and scatter of the trigger generator's clock; the camera's clock against it where frames have timestamps.

    Raises
    ------
    IrTimingError
        If a file cannot be read or written, or no recording has pulses or timestamps of the camera.
    """
    require_places({"JSON": [order.json], "SVG": [order.picture]}, inputs=[*order.recordings, order.rig])
    runs = [read_timestamps(path) for path in order.recordings]
    cameras = tuple(one for run in runs if (one := _camera(run)) is not None)
    pulsed = [run for run in runs if layout.SPARE in run.streams and run.streams[layout.SPARE].size]
    if not pulsed and (not cameras or order.rig is not None):
        _of(runs[0], order)
    checks = tuple(_of(run, order) for run in pulsed)
    found = ClockFound(
        checks=checks, cameras=cameras, clock=clock.combined(checks, pulse_u=order.pulse_u) if checks else None
    )
    _write(found, order)
    return found


def _of(run: TimedRun, order: ClockOrder) -> ClockCheck:
    return clock.estimate(
        run.streams.get(layout.SPARE),
        name=run.name,
        clock_frequency_hz=run.clock_frequency_hz,
        pulse_period_s=order.pulse_period_s,
    )


def _camera(run: TimedRun) -> CameraClock | None:
    if run.camera_stamps is None or run.timestamp_frequency_hz is None:
        return None
    stamps, triggers = run.camera_stamps
    return camera_clock(
        run.name,
        stamp_ticks=stamps,
        stamp_frequency_hz=run.timestamp_frequency_hz,
        trigger_ticks=triggers,
        clock_frequency_hz=run.clock_frequency_hz,
    )


def _write(found: ClockFound, order: ClockOrder) -> None:
    if order.json is not None:
        write_json(_content(found), order.json)
    if order.picture is not None:
        if not found.checks:
            raise EstimationError(f"{order.picture}: there are no pulses to draw; leave the picture out")
        drawing = sheet.svg(clock_section.picture(found.checks), title="Clock against its pulses")
        write_atomically(drawing, order.picture)
    if order.rig is not None and found.clock is not None:
        rig_update.update(order.rig, "clock", numbers=rig_update.clock_lines(found.clock))


def _content(found: ClockFound) -> dict[str, Any]:
    return {
        "clock": None if found.clock is None else asdict(found.clock),
        "recordings": [asdict(check) for check in found.checks],
        "camera_clocks": [asdict(camera) for camera in found.cameras],
    }
