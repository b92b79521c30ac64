"""Latencies of gates and trigger, in tables."""

import math
from collections.abc import Sequence

from irtiming.records.latency_check import LatencyDifference, LoopBack
from irtiming.report.blocks import US, Table, micro
from irtiming.report.rounding import significant

_NS = 1e9
_MOST_COUNTS = 12


def registers(differences: Sequence[LatencyDifference]) -> Table:
    """Where the edges of each line lie between the slots, recording by recording."""
    rows = tuple(
        (
            one.name,
            difference.line,
            f"{one.wheel_rad_per_s / (2 * math.pi):.2f}",
            str(one.n_edges),
            f"{1e3 * one.phase_rad.value:.5f}",
            significant(1e6 * one.phase_rad.standard_uncertainty),
        )
        for difference in differences
        for one in difference.registers
    )
    return Table(
        title="From the control slot before an edge to the edge",
        columns=("recording", "line", "wheel/Hz", "edges", "angle/mrad", "u/µrad"),
        align="llrrrr",
        rows=rows,
    )


def differences(found: Sequence[LatencyDifference]) -> Table:
    """By how much later one line is stamped than another."""
    rows = tuple(
        (
            f"{one.line} after {one.later_than}",
            f"{one.difference_s.value / US:+.4f}",
            micro(one.difference_s.standard_uncertainty),
            "–" if not one.degrees_of_freedom else f"{one.chi_squared:.1f} / {one.degrees_of_freedom}",
        )
        for one in found
    )
    return Table(
        title="Latency of one line less that of another",
        columns=("lines", "difference/µs", "u/µs", "χ² / freedom"),
        align="lrrr",
        rows=rows,
        note="Speeds determine differences only: a latency that both gates have in common remains unknown.",
    )


def loops(found: Sequence[LoopBack]) -> Table:
    """A trigger that is led back."""
    rows = tuple(
        (
            one.name,
            f"{one.n_triggers} ({one.n_missing} missing)",
            f"{one.mean_s * one.clock_frequency_hz:.3f}",
            f"{_NS * one.mean_s:.2f}",
            f"{_NS * one.spread_s:.2f}",
            f"{_NS * one.lowest_s:.2f} … {_NS * one.highest_s:.2f}",
        )
        for one in found
    )
    return Table(
        title="Trigger that is led back: stamped later than made",
        columns=("recording", "triggers", "mean/ticks", "mean/ns", "spread/ns", "all/ns"),
        align="lrrrrr",
        rows=rows,
        note="Out through driver and cable, in through the input's buffer: the way out, after which the camera's delay counts, "
        "is a part of it between nothing and all.",
    )


def distribution(one: LoopBack) -> Table:
    """How often each difference came, in ticks."""
    most = sorted(one.counts, key=lambda pair: -pair[1])[:_MOST_COUNTS]
    rows = tuple(
        (str(ticks), f"{_NS * ticks / one.clock_frequency_hz:.2f}", str(count)) for ticks, count in sorted(most)
    )
    return Table(title=f"Differences of {one.name}", columns=("ticks", "ns", "times"), align="rrr", rows=rows)
