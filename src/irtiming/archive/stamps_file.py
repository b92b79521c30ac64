"""Stamps of frames in a CSV file, one line per frame, as cameras' software and ROS write them."""

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import IO, final

import numpy as np

from irtiming.errors import ArchiveError
from irtiming.records.arrays import Array, Ticks

UNITS = {"s": Decimal(1), "ms": Decimal("1e-3"), "us": Decimal("1e-6"), "ns": Decimal("1e-9")}
"""Units of a column of stamps, by the end of its name: ``stamp_ns``."""

_NUMBERS = ("frame", "frame_id", "frame_number", "seq")
_NO_COMMAS = {";": "semicolons", "\t": "tabs", "|": "bars"}
_MOST_BYTES = 2**29
_MOST_LINE = 2**16
_MOST_STAMPS = 2**22
_LARGEST_S = 9 * 10**9  # so that nanoseconds fit 64 bits
_LARGEST_NUMBER = 2**62


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class StampColumn:
    """One column: seconds since ``origin_s``, shape (n_frame,), and the number of each frame where the file has one."""

    column: str
    time_s: Array
    origin_s: int
    numbers: Ticks | None


def read_stamps(path: str | Path, *, column: str | None = None, unit: str | None = None) -> StampColumn:
    """Stamps of frames, to the nanosecond however large they are.

    Parameters
    ----------
    path
        CSV with a line of names first; lines that begin with ``#`` are left out.
    column
        Its name; None: the only one whose name ends in a unit.
    unit
        One of `UNITS`, which the name must not contradict; None: as the name says.

    Raises
    ------
    ArchiveError
        If the file cannot be read, its unit is in doubt, or a stamp is no number.
    """
    target = Path(path)
    try:
        if target.stat().st_size > _MOST_BYTES:
            raise ArchiveError(
                f"{path}: has more than {_MOST_BYTES} bytes, which no stamps of frames have; name the file of stamps"
            )
        with target.open(encoding="utf-8", newline="") as file:
            return _read(target, csv.reader(_lines(target, file), strict=True), column=column, unit=unit)
    except FileNotFoundError as error:
        raise ArchiveError(f"{path}: does not exist; name the file of stamps") from error
    except OSError as error:
        raise ArchiveError(f"{path}: cannot be read ({error.strerror}); name the file of stamps") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise ArchiveError(
            f"{path}: is no CSV ({error}); give a recording, or a CSV with one line per frame"
        ) from error


def _lines(path: Path, file: IO[str]) -> Iterator[str]:
    while line := file.readline(_MOST_LINE + 1):
        if len(line) > _MOST_LINE or "\0" in line:
            raise ArchiveError(f"{path}: is no CSV; give a recording, or a CSV with one line per frame")
        if line.strip() and not line.startswith("#"):
            yield line


def _read(path: Path, lines: Iterator[list[str]], *, column: str | None, unit: str | None) -> StampColumn:
    names = [name.strip() for name in next(lines, [])]
    if len(names) == 1 and (other := next((sign for sign in _NO_COMMAS if sign in names[0]), None)) is not None:
        raise ArchiveError(
            f"{path}: has {_NO_COMMAS[other]} in its line of names and no comma; columns must be separated by commas"
        )
    chosen = _column(path, names, column)
    scale = _scale(path, chosen, unit)
    counted = next((name for name in names if name.lower() in _NUMBERS and name != chosen), None)
    times, numbers = [], []
    for n, values in enumerate(lines):
        if len(values) != len(names):
            raise ArchiveError(
                f"{path}: data line {n + 1} has {len(values)} values, there are {len(names)} columns; mend it"
            )
        if n == _MOST_STAMPS:
            raise ArchiveError(f"{path}: has more than {_MOST_STAMPS} stamps; cut it into pieces")
        times.append(_number(path, values[names.index(chosen)], n, largest=_LARGEST_S / scale) * scale)
        if counted is not None:
            numbers.append(_whole(path, values[names.index(counted)], n))
        if len(numbers) > 1 and numbers[-1] <= numbers[-2]:
            raise ArchiveError(
                f"{path}: column '{counted}' numbers frames and must rise, data line {n + 1} has {numbers[-1]} after "
                f"{numbers[-2]}; mend it, or give the column another name"
            )
    if not times:
        raise ArchiveError(f"{path}: has no stamps; give one line per frame")
    origin = int(times[0])
    return StampColumn(
        column=chosen,
        time_s=np.array([float(one - origin) for one in times]),
        origin_s=origin,
        numbers=np.array(numbers, dtype=np.int64) if counted is not None else None,
    )


def _column(path: Path, names: list[str], column: str | None) -> str:
    if column is not None:
        if column not in names:
            raise ArchiveError(f"{path}: has no column '{column}'; it has {', '.join(names) or 'none'}")
        return column
    fitting = [name for name in names if "_" in name and name.rsplit("_", 1)[-1] in UNITS]
    if len(fitting) != 1:
        raise ArchiveError(
            f"{path}: {len(fitting)} columns end in a unit (_s, _ms, _us, _ns) among {', '.join(names) or 'none'}; name the "
            "column of the stamps"
        )
    return fitting[0]


def _scale(path: Path, column: str, unit: str | None) -> Decimal:
    """Seconds that 1 in a column is: its name and a unit that was given must not contradict each other."""
    named = column.rsplit("_", 1)[-1]
    if unit is not None and unit not in UNITS:
        raise ArchiveError(f"{path}: '{unit}' is no unit of stamps; give {', '.join(UNITS)}")
    if unit is not None and named in UNITS and named != unit:
        raise ArchiveError(
            f"{path}: column '{column}' says that its unit is {named}, {unit} was given; leave the unit out, or mend the name"
        )
    scale = UNITS.get(unit or named)
    if scale is None:
        raise ArchiveError(
            f"{path}: column '{column}' does not say its unit; let its name end in _s, _ms, _us or _ns, or give the unit"
        )
    return scale


def _number(path: Path, text: str, line: int, *, largest: Decimal) -> Decimal:
    try:
        value = Decimal(text.strip())
    except InvalidOperation as error:
        raise ArchiveError(f"{path}: data line {line + 1} has '{text[:40]}', must be a number; mend it") from error
    if not value.is_finite() or not -largest <= value <= largest:
        raise ArchiveError(f"{path}: data line {line + 1} has {text[:40]}, which is no stamp; mend it")
    return value


def _whole(path: Path, text: str, line: int) -> int:
    value = _number(path, text, line, largest=Decimal(_LARGEST_NUMBER))
    if value % 1:
        raise ArchiveError(f"{path}: data line {line + 1} has {text[:40]}, which numbers no frame; mend it")
    return int(value)
