"""Results written into the register, each recording once, and points read back.

A result that shares a recording with an earlier one takes its place: analysed again, by a later program or beside others, it is
the same measurement, and counted twice it would make the uncertainty too small.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from math import inf, isfinite
from typing import Any, final

from irtiming.archive.nexus import program_version
from irtiming.archive.register.tables import library, metadata, opened, unusable
from irtiming.records.setting_point import CameraKey, PointParameter, SettingPoint, in_time

_OF_RESULT = ("setting", "value", "common_input", "finding")
"""Tables of what a point says."""

_NOT_OURS = (UnicodeDecodeError, TypeError, ValueError, OverflowError)
"""Raised by cells that no irtiming wrote."""


@final
@dataclass(frozen=True, kw_only=True)
class Entry:
    """A result for the register: its point, who measured, which time; and checksums of its file, recordings and rig.toml."""

    point: SettingPoint
    sha256: str
    recordings_sha256: tuple[str, ...] = ()
    rig_sha256: str = ""
    operator: str = ""
    run: str = ""


@final
@dataclass(frozen=True, kw_only=True)
class KnownCamera:
    """A camera in the register, and how many results it has of it."""

    serial_number: str
    model: str
    n_results: int


def add(register: str, entries: Sequence[Entry], *, registered_at: str | None = None) -> int:
    """Write entries that are not there yet, all or none, in place of those of the same recordings; gives how many were new.

    Parameters
    ----------
    register
        As for `opened`.
    entries
        Results.
    registered_at
        ISO 8601; now, where none is given.

    Raises
    ------
    ArchiveError
        If the register cannot be used.
    """
    sql = library()
    tables, engine = metadata().tables, opened(register)
    when = registered_at or datetime.now(UTC).isoformat(timespec="seconds")
    new = 0
    try:
        with engine.begin() as line:
            for one in entries:
                known = sql.select(tables["result"].c.id).where(tables["result"].c.sha256 == one.sha256)
                if line.execute(known).first() is None:
                    _remove_earlier(line, tables, one)
                    _insert(line, tables, one, when)
                    new += 1
    except sql.exc.SQLAlchemyError as error:
        raise unusable(register, error) from error
    finally:
        engine.dispose()
    return new


def _remove_earlier(line: Any, tables: Mapping[str, Any], one: Entry) -> None:
    """Remove results that have a recording of this one."""
    sql, recording = library(), tables["recording"].c
    shared = sql.select(recording.result_id).where(recording.sha256.in_(one.recordings_sha256)).distinct()
    earlier = line.execute(shared).scalars().all()
    for name in ("recording", *_OF_RESULT):
        line.execute(tables[name].delete().where(tables[name].c.result_id.in_(earlier)))
    line.execute(tables["result"].delete().where(tables["result"].c.id.in_(earlier)))


def _insert(line: Any, tables: Mapping[str, Any], one: Entry, when: str) -> None:
    point, camera = one.point, one.point.camera
    made = line.execute(
        tables["result"].insert().values(
            sha256=one.sha256, serial_number=camera.serial_number, model=camera.model, manufacturer=camera.manufacturer,
            camera=camera.camera_type, readout_mode=camera.readout_mode, reference_event=camera.event,
            measured_at=point.start_time, registered_at=when, operator=one.operator, run=one.run,
            program_version=program_version(), rig_sha256=one.rig_sha256, recordings=point.n_recordings,
            simulated=point.simulated, file=point.label,
        )
    )  # fmt: skip
    here = {"result_id": made.inserted_primary_key[0]}
    rows: dict[str, list[dict[str, Any]]] = {
        "setting": [
            here | {"name": name, "number": None if isinstance(value, str) else float(value),
                    "words": value if isinstance(value, str) else None}
            for name, value in point.settings.items()
        ],
        "value": [
            here | {"parameter": name, "value": p.value, "standard_uncertainty": p.standard_uncertainty,
                    "expanded_uncertainty": p.expanded_uncertainty,
                    "degrees_of_freedom": p.degrees_of_freedom if isfinite(p.degrees_of_freedom) else None, "unit": p.unit,
                    "reference_event": p.event}
            for name, p in point.parameters.items()
        ],
        "common_input": [
            here | {"parameter": name, "source": source, "contribution": adds}
            for name, p in point.parameters.items() for source, adds in p.common.items()
        ],
        "finding": [here | {"code": code} for code in point.findings],
        "recording": [here | {"sha256": sha256} for sha256 in dict.fromkeys(one.recordings_sha256)],
    }  # fmt: skip
    for name, values in rows.items():
        if values:
            line.execute(tables[name].insert(), values)


def cameras(register: str) -> list[KnownCamera]:
    """Every camera, by serial number.

    Raises
    ------
    ArchiveError
        If there is no such register, or it cannot be used.
    """
    sql = library()
    table, engine = metadata().tables["result"], opened(register, must_exist=True)
    asked = sql.select(table.c.serial_number, table.c.model, sql.func.count()).group_by(
        table.c.serial_number, table.c.model
    )
    try:
        with engine.connect() as line:
            return [
                KnownCamera(serial_number=serial, model=model, n_results=n)
                for serial, model, n in sorted(map(tuple, line.execute(asked).all()))
            ]
    except (sql.exc.SQLAlchemyError, *_NOT_OURS) as error:
        raise unusable(register, error) from error
    finally:
        engine.dispose()


def of_camera(register: str, serial_number: str) -> tuple[SettingPoint, ...]:
    """All results of a camera, the oldest first.

    Raises
    ------
    ArchiveError
        If there is no such register, or it cannot be used.
    """
    sql = library()
    tables, engine = metadata().tables, opened(register, must_exist=True)
    asked = sql.select(tables["result"]).where(tables["result"].c.serial_number == serial_number)
    try:
        with engine.connect() as line:
            found = line.execute(asked).mappings().all()
            rows = {
                name: line.execute(
                    sql.select(tables[name]).join(tables["result"]).where(tables["result"].c.serial_number == serial_number)
                ).mappings().all()
                for name in _OF_RESULT
            }  # fmt: skip
        points = [
            _point(one, {name: [row for row in each if row["result_id"] == one["id"]] for name, each in rows.items()})
            for one in found
        ]
    except (sql.exc.SQLAlchemyError, *_NOT_OURS) as error:
        raise unusable(register, error) from error
    finally:
        engine.dispose()
    return tuple(sorted(points, key=lambda one: (in_time(one.start_time), one.label)))


def _point(one: Any, rows: Mapping[str, Sequence[Any]]) -> SettingPoint:
    common: dict[str, dict[str, float]] = {}
    for row in rows["common_input"]:
        common.setdefault(_text(row, "parameter"), {})[_text(row, "source")] = _real(row, "contribution")
    return SettingPoint(
        label=_text(one, "file"),
        camera=CameraKey(
            manufacturer=_text(one, "manufacturer"), model=_text(one, "model"), serial_number=_text(one, "serial_number"),
            camera_type=one["camera"], readout_mode=one["readout_mode"], event=one["reference_event"],
        ),
        settings={
            one["name"]: _real(one, "number") if one["words"] is None else _text(one, "words") for one in rows["setting"]
        },
        parameters={
            _text(row, "parameter"): PointParameter(
                value=_real(row, "value"), standard_uncertainty=_real(row, "standard_uncertainty"), unit=_text(row, "unit"),
                expanded_uncertainty=_real(row, "expanded_uncertainty"),
                degrees_of_freedom=inf if row["degrees_of_freedom"] is None else _real(row, "degrees_of_freedom"),
                event=_text(row, "reference_event"), common=common.get(row["parameter"], {}),
            )
            for row in rows["value"]
        },
        start_time=_text(one, "measured_at"), n_recordings=int(_real(one, "recordings")),
        findings=tuple(_text(row, "code") for row in rows["finding"]), simulated=bool(one["simulated"]),
    )  # fmt: skip


def _text(row: Any, name: str) -> str:
    """Words of a cell: a database that somebody else wrote may hold anything in any column."""
    if not isinstance(row[name], str):
        raise TypeError(f"{name} is {row[name]!r:.40}, must be text")
    return str(row[name])


def _real(row: Any, name: str) -> float:
    """Number of a cell."""
    if not isinstance(row[name], int | float):
        raise TypeError(f"{name} is {row[name]!r:.40}, must be a number")
    return float(row[name])
