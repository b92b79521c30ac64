"""What every logic analyser's capture comes to: lines that change their level at times on one clock."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import final

from irtiming.errors import ArchiveError
from irtiming.records.arrays import Ticks
from irtiming.units import readable_time

PICOSECONDS = Fraction(10**12)
"""Counts per second of captures whose times are decimal seconds."""

_RATE = re.compile(r"\s*(\d{1,15}(?:\.\d{1,15})?)\s*([kMG]?)Hz\s*", flags=re.IGNORECASE)
_PREFIXES = {"": 1, "k": 10**3, "m": 10**6, "g": 10**9}
_NUMBERED = re.compile(r"(?:D|CH|Channel)?[ _-]?(\d{1,9})", flags=re.IGNORECASE)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Line:
    """One line: its level at the beginning, and the counts at which it changed, shape (n_change,), never falling."""

    initial: int
    changes: Ticks


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Capture:
    """Lines by the name under which they were asked for; ``begin`` and ``end`` are counts.

    ``sample_rate_hz`` is None where the file does not tell it.
    """

    lines: dict[str, Line]
    counts_per_second: Fraction
    begin: int
    end: int
    sample_rate_hz: int | None = None


def hertz(text: str) -> int | None:
    """Whole number of hertz from text such as ``"24 MHz"`` or ``"49.152MHz"``; None where it is none."""
    match = _RATE.fullmatch(text)
    if match is None:
        return None
    rate = Fraction(match[1]) * _PREFIXES[match[2].lower()]
    return int(rate) if rate.denominator == 1 and rate > 0 else None


def find_lines(wanted: Sequence[str], there: Sequence[str], *, path: Path) -> dict[str, int]:
    """Place of each wanted line among those of a capture.

    A line is meant by its name, or by its number: D3, 3 and Channel 3 are the same where no name is equal.

    Parameters
    ----------
    wanted
        Names that the user gave.
    there
        Names in the capture.
    path
        Of the capture, for messages.

    Raises
    ------
    ArchiveError
        If a line is not there, or its name stands for several.
    """
    numbers = [_number(name) for name in there]
    found = {}
    for name in wanted:
        places = [place for place, other in enumerate(there) if other == name]
        if not places and _number(name) is not None:
            places = [place for place, number in enumerate(numbers) if number == _number(name)]
        if len(places) != 1:
            what = "stands for several lines" if places else "is no line"
            raise broken(path, f"'{name}' {what} of the capture; name one of {_listed(there)}")
        found[name] = places[0]
    return found


def broken(path: Path, what: str) -> ArchiveError:
    """Error about a capture in one line: file, what is and what to do."""
    return ArchiveError(" ".join(f"{path}: {what}".split()))


def cut_short(path: Path, what: str) -> ArchiveError:
    """Error for a file of which a part is missing."""
    return broken(path, f"{what}: the file is cut short; export or copy it again")


def lost(path: Path, name: str, *, time_s: Fraction | float) -> ArchiveError:
    """Error for a time at which a line was not recorded."""
    return broken(
        path,
        f"line '{name}' was not recorded at {readable_time(float(time_s))}: data were lost there; record again with fewer "
        "lines or a lower sample rate",
    )


def goes_back(path: Path, time_s: Fraction | float) -> ArchiveError:
    """Error for times that are not in order."""
    return broken(
        path, f"its times go back at {readable_time(float(time_s))}; export the capture again, in order of time"
    )


def _number(name: str) -> int | None:
    match = _NUMBERED.fullmatch(name.strip())
    return None if match is None else int(match[1])


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(f"'{name}'" for name in names[:20])
    return shown + (" and others" if len(names) > 20 else "") if names else "its lines: it has none"
