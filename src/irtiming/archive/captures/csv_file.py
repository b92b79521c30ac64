"""Tables of times and levels: what Saleae's Logic 2 and most other programs export as CSV."""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TextIO, final

import numpy as np

from irtiming.archive.captures.bounds import MOST_CHANGES, bounded_lines, too_many_changes
from irtiming.archive.captures.capture import (
    PICOSECONDS,
    Capture,
    Line,
    broken,
    cut_short,
    find_lines,
    goes_back,
    lost,
)
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Array, Ticks

_BLOCK_CHARACTERS = 2**23
_UNITS = {"s": 12, "sec": 12, "seconds": 12, "ms": 9, "us": 6, "µs": 6, "ns": 3, "nanoseconds": 3, "ps": 0}
_UNIT_IN_NAME = re.compile(r"time.*?[\s\[(_]+([a-zµ]+)[\])]?", flags=re.IGNORECASE)
_LONGEST_S = 1e6
_EVERY_SAMPLE = 0.9  # of the rows change nothing, and of the steps are equal, in a table of samples
_UNEVEN = 0.5  # of a step, beyond which samples are missing


@final
@dataclass(frozen=True, kw_only=True)
class _Table:
    """How the file is written: separator, names of its columns after the time, and picoseconds in its unit of time."""

    path: Path
    separator: str
    names: list[str]
    ps_per_unit: int


def read_csv(path: Path, names: Sequence[str]) -> Capture:
    """Lines of a table whose first column is time; it may hold every sample, or only rows in which something changes.

    Raises
    ------
    ArchiveError
        If the file is no such table or cut short, a line is not in it, or was not recorded (X, a gap between samples).
    """
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        rows = _without_comments(path, file)
        table, rows = _described(path, rows)
        places = find_lines(names, table.names, path=path)
        columns = [1 + places[name] for name in names]
        pieces = _Pieces(table, names)
        while block := _block(rows):
            pieces.add(_numbers(table, block, columns))
    return pieces.capture()


def _block(rows: Iterator[str]) -> list[str]:
    """The next rows, as many as fit into a block."""
    block, n_characters = [], 0
    for row in rows:
        block.append(row)
        n_characters += len(row)
        if n_characters > _BLOCK_CHARACTERS:
            break
    return block


@final
class _Pieces:
    """Changes of the lines, block after block of rows."""

    def __init__(self, table: _Table, names: Sequence[str]) -> None:
        self._table = table
        self._names = names
        self._changes: list[list[Ticks]] = [[] for _ in names]
        self._first: Array | None = None
        self._last: Array | None = None
        self._step_ps: float | None = None

    def add(self, block: Array) -> None:
        """Take a block of rows: time in picoseconds, then the levels."""
        if self._first is None or self._last is None:
            self._first = block[0]
            self._step_ps = _sampling_step(block)
        else:
            block = np.vstack([self._last, block])
        steps = np.diff(block[:, 0])
        if np.any(steps < 0):
            raise goes_back(self._table.path, block[np.argmax(steps < 0), 0] / PICOSECONDS)
        if self._step_ps is not None and np.any(gap := np.abs(steps - self._step_ps) > _UNEVEN * self._step_ps):
            missing_ps = block[np.argmax(gap), 0] + self._step_ps
            raise lost(self._table.path, self._names[0], time_s=missing_ps / PICOSECONDS)
        for name, changes, level in zip(self._names, self._changes, block.T[1:], strict=True):
            changes.append(block[1:, 0][np.diff(level) != 0].astype(np.int64))
            if sum(map(len, changes)) > MOST_CHANGES:
                raise too_many_changes(self._table.path, name)
        self._last = block[-1]

    def capture(self) -> Capture:
        """Everything that was added."""
        if self._first is None or self._last is None:
            raise cut_short(self._table.path, "has no rows")
        lines = {
            name: Line(initial=int(initial), changes=np.concatenate(changes))
            for name, initial, changes in zip(self._names, self._first[1:], self._changes, strict=True)
        }
        return Capture(lines=lines, counts_per_second=PICOSECONDS, begin=int(self._first[0]), end=int(self._last[0]))


def _without_comments(path: Path, file: TextIO) -> Iterator[str]:
    for row in bounded_lines(path, file):
        if "libsigrok" in row and row.startswith((";", "#")):
            raise broken(
                path,
                "is sigrok's CSV, whose times are cut to whole nanoseconds sample by sample and run wrong; give the .sr file",
            )
        if row.strip() and not row.startswith((";", "#")):
            yield row.rstrip("\n")


def _described(path: Path, rows: Iterator[str]) -> tuple[_Table, Iterator[str]]:
    """What the first row says, and the rows that hold values."""
    first = next(rows, None)
    if first is None:
        raise broken(path, "is empty; export or copy it again")
    separator = max(",;\t", key=first.count)
    cells = [cell.strip().strip('"') for cell in first.split(separator)]
    if len(cells) < 2:
        raise broken(
            path, f"begins with '{first[:40]}', which is no table of a time and lines; export it as CSV, VCD or .sr"
        )
    if _is_number(cells[0]):
        names = [str(column) for column in range(len(cells) - 1)]
        return _Table(path=path, separator=separator, names=names, ps_per_unit=10**12), chain([first], rows)
    match = _UNIT_IN_NAME.fullmatch(cells[0])
    unit = match[1].lower() if match else "s"
    if not cells[0].lower().startswith("time") or unit not in _UNITS:
        raise broken(path, f"has '{cells[0][:40]}' as first column; it must be the time, such as 'Time [s]'")
    return _Table(path=path, separator=separator, names=cells[1:], ps_per_unit=10 ** _UNITS[unit]), rows


def _numbers(table: _Table, rows: list[str], columns: list[int]) -> Array:
    """Time in picoseconds and the levels of some columns, shape (row, 1 + column)."""
    try:
        values = np.loadtxt(rows, delimiter=table.separator, usecols=[0, *columns], ndmin=2, comments=None)
    except ValueError as error:
        raise _why_not(table, rows, columns) from error
    values[:, 0] *= table.ps_per_unit
    np.rint(values[:, 0], out=values[:, 0])
    levels = values[:, 1:]
    if not np.all(np.abs(values[:, 0]) < _LONGEST_S * 1e12) or not np.all((levels == 0) | (levels == 1)):
        raise _why_not(table, rows, columns)
    return values


def _why_not(table: _Table, rows: list[str], columns: list[int]) -> ArchiveError:
    """What is wrong with the first row that cannot be used."""
    for row in rows:
        cells = [cell.strip() for cell in row.split(table.separator)]
        if len(cells) <= max(columns):
            return cut_short(table.path, f"has {len(cells)} of {len(table.names) + 1} columns in the row '{row[:40]}'")
        if not _is_number(cells[0]) or abs(float(cells[0])) * table.ps_per_unit >= _LONGEST_S * 1e12:
            return broken(table.path, f"has '{cells[0][:40]}' as a time; export times as seconds from the beginning")
        for column in columns:
            name, level = table.names[column - 1], cells[column]
            if level.lower() in ("x", ""):
                return lost(table.path, name, time_s=float(cells[0]) * table.ps_per_unit * 1e-12)
            if not _is_number(level) or float(level) not in (0.0, 1.0):
                return broken(table.path, f"line '{name}' is '{level[:20]}' in a row; a level must be 0 or 1")
    return broken(table.path, "holds a row that cannot be read; export the capture again")


def _sampling_step(block: Array) -> float | None:
    """Picoseconds between samples in a table that holds every sample; None in one of changes."""
    steps = np.diff(block[:, 0])
    if steps.size < 3 or np.mean(np.any(np.diff(block[:, 1:], axis=0) != 0, axis=1)) > 1 - _EVERY_SAMPLE:
        return None
    regular = np.abs(steps - np.median(steps)) <= 0.1 * np.median(steps)
    return float(steps[regular].mean()) if np.median(steps) > 0 and regular.mean() > _EVERY_SAMPLE else None


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text)) and "_" not in text
    except ValueError:
        return False
