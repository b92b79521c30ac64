"""The timestamps of a recording as a value change dump, for any waveform viewer."""

import io
from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np
from vcd.writer import VCDWriter

from irtiming.archive import layout
from irtiming.archive.captures.streams import STREAMS
from irtiming.archive.json_file import write_atomically
from irtiming.archive.timestamps_file import TimedRun
from irtiming.archive.writer import values_of
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Ticks
from irtiming.records.recording import Recording

_LONGEST = 2**63 - 1


def write_vcd(recording: Recording | TimedRun, path: str | Path) -> None:
    """Write every tick stream as a line that rises at its ticks.

    A line falls half way to its next tick; ``application_edges`` changes at each of its ticks. Times are in nanoseconds,
    `round(tick / clock)`; of a clock above 1 GHz in picoseconds. So each tick comes back exactly. A comment tells the clock.

    Parameters
    ----------
    recording
        Or the timestamps of a run that waits for its frames; ticks must not be negative.
    path
        A file of that name is replaced.

    Raises
    ------
    ArchiveError
        If the file cannot be written, a tick is negative, too late for 63 bits, or the clock above 1 THz.
    """
    text = io.StringIO()
    unit = "ns" if recording.clock_frequency_hz <= 1e9 else "ps"
    clock = Fraction(recording.clock_frequency_hz)
    units_per_tick = (10**9 if unit == "ns" else 10**12) / clock
    if units_per_tick < 1:
        raise ArchiveError(
            f"{recording.name}: its clock of {float(clock):g} Hz is above 1 THz; a dump has no finer times"
        )
    streams = recording.streams if isinstance(recording, TimedRun) else values_of(recording)
    changes: list[tuple[int, int, str, int]] = []
    initial: dict[str, int] = {}
    for field in STREAMS:
        ticks = streams.get(field)
        if ticks is None:
            continue
        times = _times(ticks, units_per_tick, name=f"{recording.name}: {field.name}")
        initial[field.name] = 0
        if field is layout.APPLICATION_EDGES:
            initial[field.name] = _level_before(ticks, streams[layout.APPLICATION_SLOT])
            pulses = _toggles(times, initial[field.name])
        else:
            pulses = _pulses(times)
        changes += [(time, order, field.name, level) for order, (time, level) in enumerate(pulses)]
    comment = f"irtiming: ticks at {float(clock):.15g} Hz"
    with VCDWriter(text, timescale=f"1 {unit}", date="", comment=comment, version="") as writer:
        lines = {name: writer.register_var("irtiming", name, "wire", size=1, init=at) for name, at in initial.items()}
        for time, _, name, level in sorted(changes):
            writer.change(lines[name], time, level)
    write_atomically(text.getvalue(), path)


def _times(ticks: Ticks, units_per_tick: Fraction, *, name: str) -> list[int]:
    """Ticks in units of the dump, rounded; with Python's integers, since those of 64 bits would overflow."""
    above, below = units_per_tick.numerator, units_per_tick.denominator
    times = [(2 * above * tick + below) // (2 * below) for tick in ticks.tolist()]
    if any(later < time for time, later in pairwise(times)):
        raise ArchiveError(f"{name} has ticks that go back; see what irtiming verify says of the file")
    if times and times[0] < 0:
        raise ArchiveError(
            f"{name} begins at tick {ticks[0]}; a value change dump has no time before 0, so add a constant to all ticks"
        )
    if times and times[-1] > _LONGEST:
        raise ArchiveError(
            f"{name} ends at tick {ticks[-1]}, beyond 63 bits of the dump's unit; take a constant off all ticks"
        )
    return times


def _pulses(times: list[int]) -> Iterator[tuple[int, int]]:
    """Level 1 at each time, and 0 half way to the next."""
    last = (times[-1] - times[-2]) // 2 if len(times) > 1 else 1
    for time, following in zip(times, [*times[1:], times[-1] + 2 * last], strict=True):
        yield time, 1
        yield (time + following) // 2, 0


def _toggles(times: list[int], level: int) -> Iterator[tuple[int, int]]:
    """The other level at each time."""
    for time in times:
        level = 1 - level
        yield time, level


def _level_before(edges: Ticks, slots: Ticks) -> int:
    """Level before the first of all four edges, so that edges 0 and 2 rise."""
    rising = np.flatnonzero(np.isin(edges, slots))
    return int(rising[0] % 2) if rising.size else 0
