"""Tables of a campaign: the list of recordings that a person writes, and the lines that come out, as CSV and Parquet."""

import csv
import io
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from irtiming.archive import layout
from irtiming.archive.json_file import write_atomically
from irtiming.archive.parquet import require_parquet
from irtiming.archive.typed_file import bytes_of
from irtiming.archive.whole_file import whole_file
from irtiming.errors import ArchiveError
from irtiming.records.campaign import CampaignLine, Listed
from irtiming.records.setting_point import SETTINGS

COLUMNS = ("file", "serial_number", "operator", "run")
"""Of a list of recordings; only the first must be there."""

_MOST_LINES = 100_000


def read_list(path: str | Path) -> tuple[Listed, ...]:
    """Recordings in a CSV, each beside what a person knows of it; files are named from the folder of the list.

    Raises
    ------
    ArchiveError
        If it cannot be read, has a column that is not known, lacks ``file``, or names a file twice or none.
    """
    table = Path(path)
    cure = f"give a CSV with the columns {', '.join(COLUMNS)}"
    try:
        text = bytes_of(table, "list of recordings").decode("utf-8-sig")
        rows = csv.DictReader([line for line in text.splitlines() if not line.startswith("#")][: _MOST_LINES + 1])
        names = [name.strip() for name in rows.fieldnames or ()]
        found = _rows(rows, names, table)
    except UnicodeDecodeError as error:
        raise ArchiveError(f"cannot be read (it is not UTF-8 text); {cure}", where=str(path)) from error
    except csv.Error as error:
        raise ArchiveError(f"is no CSV ({error}); {cure}", where=str(path)) from error
    return _each_once(found, where=str(path))


def _rows(rows: "csv.DictReader[str]", names: list[str], table: Path) -> list[Listed]:
    strangers = [name for name in names if name not in COLUMNS]
    if strangers or "file" not in names:
        what = f"has the column '{strangers[0]}'" if strangers else "has no column 'file'"
        raise ArchiveError(f"{what}; its columns must be among {', '.join(COLUMNS)}, with file", where=str(table))
    rows.fieldnames = names
    found = []
    for number, row in enumerate(rows, 2):
        if None in row or not (row["file"] or "").strip() or "\0" in row["file"]:
            raise ArchiveError(f"line {number} has no file, or more cells than columns; correct it", where=str(table))
        serial, operator, run = ((row.get(name) or "").strip() for name in COLUMNS[1:])
        path_of_row = table.parent / row["file"].strip()
        found.append(Listed(path=path_of_row, serial_number=serial, operator=operator, run=run))
    return found


def in_folder(folder: str | Path) -> tuple[Listed, ...]:
    """Every recording below a folder, by name; those in one folder are of one run.

    What is in folders below it that are `layout.NOT_MEASURED` is left out.

    Raises
    ------
    ArchiveError
        If there is none.
    """
    top = Path(folder)
    found = [
        Listed(path=path, run="" if path.parent == top else str(path.parent.relative_to(top)))
        for path in sorted(top.rglob(f"*{layout.SUFFIX}"))
        if not set(path.relative_to(top).parts[:-1]) & set(layout.NOT_MEASURED)
    ]
    return _each_once(found, where=str(folder))


def _each_once(found: list[Listed], *, where: str) -> tuple[Listed, ...]:
    if not found:
        raise ArchiveError(
            f"holds no recording (*{layout.SUFFIX}); name a folder that does, or a CSV of them", where=where
        )
    seen: set[str] = set()
    for path in (os.path.realpath(one.path) for one in found):
        if path in seen:
            raise ArchiveError(f"names {path} twice; name each recording once", where=where)
        seen.add(path)
    return tuple(found)


def rows_of(lines: Sequence[CampaignLine]) -> list[dict[str, Any]]:
    """Lines as flat rows with one set of columns; None where a camera has no such thing. Floats are in SI units."""
    names = list(dict.fromkeys(name for one in lines for name in one.values))
    units = {name: next(one.values[name].unit for one in lines if name in one.values) for name in names}
    return [_row(one, units) for one in lines]


def _row(one: CampaignLine, units: Mapping[str, str]) -> dict[str, Any]:
    key = one.camera
    row: dict[str, Any] = {
        "manufacturer": key.manufacturer or None, "model": key.model or None, "serial_number": key.serial_number,
        "camera": key.camera_type, "readout_mode": key.readout_mode, "reference_event": key.event,
    }  # fmt: skip
    for setting, (_, unit) in SETTINGS.items():
        row[f"{setting}_{unit.lower()}" if unit in ("s", "K") else setting] = one.settings.get(setting)
    row |= {
        "verdict": one.judgement, "first_measured": one.first_measured or None, "results": one.n_results,
        "recordings": one.n_recordings,
    }  # fmt: skip
    for name, unit in units.items():
        found, end = one.values.get(name), "_s" if unit == "s" else ""
        row |= {
            f"{name}{end}": None if found is None else found.value,
            f"u_{name}{end}": None if found is None else found.standard_uncertainty,
            f"U_{name}{end}": None if found is None else found.expanded_uncertainty,
            f"lower_{name}{end}": None if found is None else found.lower,
            f"upper_{name}{end}": None if found is None else found.upper,
            f"verdict_{name}": None if found is None else found.judgement,
            f"conformity_probability_{name}": None if found is None else found.probability,
        }
    return row | {"findings": " ".join(dict.fromkeys(one.findings)) or None, "simulated": one.simulated}


def write_csv(rows: Sequence[Mapping[str, Any]], path: str | Path, *, head: Sequence[str] = ()) -> None:
    """Write rows with their columns; numbers with all their digits, lines of ``head`` first, each after a ``#``.

    Raises
    ------
    ArchiveError
        If the file cannot be written.
    """
    text = io.StringIO()
    text.writelines(f"# {line}\n" for line in head)
    writer = csv.DictWriter(text, fieldnames=list(rows[0]) if rows else [], lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: "" if value is None else value for name, value in row.items()} for row in rows)
    write_atomically(text.getvalue(), path)


def write_parquet(rows: Sequence[Mapping[str, Any]], path: str | Path, *, head: Sequence[str] = ()) -> None:
    """The same as Parquet, whole or not at all; ``head`` stands in the metadata as ``irtiming``.

    Raises
    ------
    ArchiveError
        If the file cannot be written, or pyarrow is not installed.
    """
    arrow, parquet = require_parquet()
    types = {name: _type(arrow, name, [row[name] for row in rows]) for name in (rows[0] if rows else {})}
    schema = arrow.schema(list(types.items()), metadata={"irtiming": "\n".join(head)})
    with whole_file(path) as part:
        parquet.write_table(arrow.Table.from_pylist([dict(row) for row in rows], schema=schema), part)


def _type(arrow: Any, name: str, values: Sequence[Any]) -> Any:
    """A column's type; one without any value is of numbers where its name says so."""
    known = [value for value in values if value is not None]
    if not known:
        is_number = name.endswith(("_s", "_k", "_row", "rows")) or "probability" in name
        return arrow.float64() if is_number else arrow.string()
    if all(isinstance(value, bool) for value in known):
        return arrow.bool_()
    if all(isinstance(value, int) for value in known):
        return arrow.int64()
    return arrow.float64() if all(isinstance(value, int | float) for value in known) else arrow.string()
