"""What the register of results knows of a camera, and how it has drifted."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any, final

from irtiming.archive.checksum import sha256_of
from irtiming.archive.json_file import require_places, write_json
from irtiming.archive.register import entries, tables
from irtiming.archive.register.entries import Entry, KnownCamera
from irtiming.archive.result_file import read_result
from irtiming.errors import ArchiveError, EstimationError
from irtiming.estimate.series.drift import drifts
from irtiming.estimate.series.points import point
from irtiming.records.drift import Drift
from irtiming.records.setting_point import SettingPoint


@final
@dataclass(frozen=True, kw_only=True)
class HistoryOrder:
    """Which camera of which register; ``since`` is a day from which drift counts, in place of the last calibration."""

    serial_number: str
    register: str
    since: date | None = None
    history: Path | None = None


@final
@dataclass(frozen=True, kw_only=True)
class History:
    """All results of a camera, the oldest first, and its drifts."""

    points: tuple[SettingPoint, ...]
    drifts: tuple[Drift, ...]


def add(results: Sequence[Path], register: str) -> int:
    """Enter results of ``irtiming analyse --json``; gives how many were new.

    Raises
    ------
    IrTimingError
        If one cannot be read or names no serial number, or the register cannot be used.
    """
    found = []
    for path in results:
        result = read_result(path)
        made = point(result, label=str(path))
        if not made.camera.serial_number:
            raise EstimationError(
                "names no serial number, by which the register knows a camera; record it", where=str(path)
            )
        recordings = tuple(one.sha256 for one in result.inputs)
        found.append(
            Entry(point=made, sha256=sha256_of(path), recordings_sha256=recordings, rig_sha256=result.rig.sha256)
        )
    return entries.add(register, found)


def cameras(register: str) -> list[KnownCamera]:
    """Every camera in the register.

    Raises
    ------
    ArchiveError
        If there is no such register, or it cannot be used.
    """
    return entries.cameras(register)


def of_camera(order: HistoryOrder) -> History:
    """What is known of a camera.

    Raises
    ------
    IrTimingError
        If the register cannot be used or does not know the camera, or the history cannot be written.
    """
    require_places({"JSON": [order.history]}, inputs=[tables.file_of(order.register)])
    points = entries.of_camera(order.register, order.serial_number)
    if not points:
        known = [one.serial_number for one in entries.cameras(order.register)]
        some = f"it knows {', '.join(known[:8])}{', …' if len(known) > 8 else ''}" if known else "it is empty"
        raise ArchiveError(f"the register has no camera '{order.serial_number}'; {some}")
    found = History(points=points, drifts=drifts(points, since=order.since))
    if order.history is not None:
        write_json(as_json(found), order.history)
    return found


def as_json(history: History) -> dict[str, Any]:
    """The same as plain data, SI units."""
    key = history.points[0].camera
    return {
        "format": "irtiming-history",
        "version": "1.0",
        "serial_number": key.serial_number,
        "model": key.model or None,
        "results": [
            {
                "file": one.label, "measured": one.start_time or None, "readout_mode": one.camera.readout_mode,
                "frame_event": one.camera.event, "settings": dict(one.settings),
                "parameters": {
                    name: {"value": p.value, "standard_uncertainty": p.standard_uncertainty,
                           "expanded_uncertainty": p.expanded_uncertainty, "unit": p.unit, "reference_event": p.event}
                    for name, p in one.parameters.items()
                },
                "findings": list(one.findings), "simulated": one.simulated,
            }
            for one in history.points
        ],
        "drift": [
            {
                "parameter": one.parameter, "unit": one.unit, "readout_mode": one.newest[0].camera.readout_mode,
                "frame_event": one.newest[0].camera.event, "settings": dict(one.newest[0].settings),
                "from": one.earlier[0].start_time, "to": one.newest[0].start_time, "value": one.value,
                "standard_uncertainty": one.standard_uncertainty, "change": one.change,
                "change_standard_uncertainty": one.u_change, "has_moved": one.has_moved, "days": one.n_days,
                "rate_per_year": one.rate_per_year, "rate_standard_uncertainty": one.u_rate_per_year,
            }
            for one in history.drifts
        ],
    }  # fmt: skip
