"""From the lines of a capture to the tick streams of a recording."""

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from fractions import Fraction
from pathlib import Path
from typing import final

import numpy as np

from irtiming.archive import layout
from irtiming.archive.captures.capture import Capture, Line, broken
from irtiming.archive.captures.reading import read_capture
from irtiming.archive.layout import Field
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Ticks
from irtiming.units import readable_time

STREAMS: tuple[Field, ...] = (
    layout.CAMERA_TRIGGER,
    layout.CONTROL_SLOT,
    layout.APPLICATION_SLOT,
    layout.APPLICATION_EDGES,
    layout.CAMERA_INPUT,
    layout.SPARE,
)
"""What a capture can give to a recording; the first three are needed, of a camera that runs free its strobe, not its trigger."""

FALLING = "!"
"""Before the name of a line of which the falling edge counts."""

_FINEST_DEFAULT_HZ = 10**9


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CapturedTicks:
    """Tick streams by their field, values of one clock, each shape (n_edge,)."""

    clock_frequency_hz: int
    streams: dict[Field, Ticks]


def line_map(text: str) -> dict[Field, str]:
    """Which line belongs to which stream, from text such as ``"camera_trigger=D0,control_slot=!D1,application_slot=D2"``.

    Raises
    ------
    ArchiveError
        If it names no stream, one twice, or leaves out one that is needed.
    """
    known = {field.name: field for field in STREAMS}
    lines: dict[Field, str] = {}
    for part in text.split(","):
        name, equals, line = (piece.strip() for piece in part.partition("="))
        if not equals or not line.removeprefix(FALLING):
            raise ArchiveError(f"--map: '{part}' is no STREAM=LINE; write such as camera_trigger=D0")
        if name not in known:
            near = get_close_matches(name, known, n=1)
            hint = f"did you mean '{near[0]}'?" if near else f"name one of {', '.join(known)}"
            raise ArchiveError(f"--map: '{name}' is no stream; {hint}")
        if known[name] in lines:
            raise ArchiveError(f"--map: {name} is given twice; a stream has one line")
        lines[known[name]] = line
    needed = [field for field in STREAMS if field.required and field is not layout.CAMERA_TRIGGER]
    missing = [field.name for field in needed if field not in lines]
    if layout.CAMERA_TRIGGER not in lines and layout.CAMERA_INPUT not in lines:
        missing.insert(0, layout.CAMERA_TRIGGER.name)
    if missing:
        raise ArchiveError(
            f"--map: {' and '.join(missing)} is missing; the capture must hold triggers, or the strobe of a camera that runs "
            f"free as {layout.CAMERA_INPUT.name}, and both light gates"
        )
    if lines.get(layout.APPLICATION_EDGES, "").startswith(FALLING):
        raise ArchiveError("--map: application_edges takes both edges of its line; leave out the '!'")
    return lines


def captured_ticks(
    path: str | Path, lines: Mapping[Field, str], *, clock_hz: int | None = None, shortest_s: float = 0.0
) -> CapturedTicks:
    """Tick streams from a capture.

    Parameters
    ----------
    path
        Of the capture.
    lines
        As from `line_map`.
    clock_hz
        Of the ticks; None: the sample rate, and where the capture does not tell it, its unit of time, at finest 1 ns.
    shortest_s
        Levels that last less than that, s, are glitches and left out.

    Raises
    ------
    ArchiveError
        If the capture cannot be read, a line never shows its edge, or a trigger was under way when the capture began.
    """
    names = {field: line.removeprefix(FALLING) for field, line in lines.items()}
    capture = read_capture(path, sorted(set(names.values())))
    clock = clock_hz or capture.sample_rate_hz or min(max(1, int(capture.counts_per_second)), _FINEST_DEFAULT_HZ)
    ratio = clock / capture.counts_per_second
    shortest = shortest_s * float(capture.counts_per_second)
    streams = {}
    for field, line in lines.items():
        steady = without_glitches(capture.lines[names[field]], shortest)
        rising = None if field is layout.APPLICATION_EDGES else not line.startswith(FALLING)
        if field is layout.CAMERA_TRIGGER and steady.initial == rising:
            raise broken(
                Path(path),
                f"line '{names[field]}' of camera_trigger is active already when the capture begins; start it before the "
                f"triggers, or choose the line's other edge: camera_trigger={_other_edge(line)}",
            )
        edges = _edges(steady, rising=rising)
        if edges.size == 0:
            raise _no_edges(Path(path), field, line, capture)
        try:
            streams[field] = to_ticks(edges, ratio)
        except OverflowError as error:
            raise broken(
                Path(path), f"lasts for more ticks of {clock} Hz than 63 bits can count; give another --clock"
            ) from error
    return CapturedTicks(clock_frequency_hz=clock, streams=streams)


def to_ticks(counts: Ticks, ticks_per_count: Fraction) -> Ticks:
    """Counts of a capture in ticks of another clock, rounded to the nearest; any shape (n,).

    The products are made of Python's integers: those of 64 bits would overflow.
    """
    if ticks_per_count == 1:
        return counts
    above, below = ticks_per_count.numerator, ticks_per_count.denominator
    return np.array([(2 * above * count + below) // (2 * below) for count in counts.tolist()], dtype=np.int64)


def without_glitches(line: Line, shortest: float) -> Line:
    """The same line without levels that last less than ``shortest`` counts."""
    length = np.append(np.diff(line.changes), np.inf)[: line.changes.size]
    level = (line.initial + 1 + np.arange(line.changes.size)) % 2
    steady = length >= shortest
    changes, level = line.changes[steady], level[steady]
    differs = np.diff(level, prepend=line.initial) != 0
    return Line(initial=line.initial, changes=changes[differs])


def _edges(line: Line, *, rising: bool | None) -> Ticks:
    """Changes to high, to low, or both."""
    if rising is None:
        return line.changes
    return line.changes[int(line.initial == rising) :: 2]


def _other_edge(line: str) -> str:
    return line.removeprefix(FALLING) if line.startswith(FALLING) else FALLING + line


def _no_edges(path: Path, field: Field, line: str, capture: Capture) -> ArchiveError:
    lasts = readable_time(float((capture.end - capture.begin) / capture.counts_per_second))
    edge = "falling" if line.startswith(FALLING) else "rising"
    return broken(
        path,
        f"line '{line.removeprefix(FALLING)}' of {field.name} has no {edge} edge in {lasts}; check cable and threshold of the "
        "analyser, and which line it is",
    )
