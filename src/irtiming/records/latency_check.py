"""What edges at several wheel speeds tell of latencies: where they lie among the control slots, and how that moves."""

from dataclasses import dataclass
from typing import final

from irtiming.records.finding import Finding
from irtiming.records.rig import Latency, Measured


@final
@dataclass(frozen=True, kw_only=True)
class GateRegister:
    """Where the edges of a line lie between the control slots, of one recording.

    ``phase_rad`` is the wheel angle from the slot that passed before to the edge, mean over ``n_edges``; only its change with the
    speed means something. ``wheel_rad_per_s`` is the speed of the wheel at those edges, as if the
    slots there were regular like all.
    """

    name: str
    wheel_rad_per_s: float
    phase_rad: Measured
    n_edges: int


@final
@dataclass(frozen=True, kw_only=True)
class LatencyDifference:
    """By how much later edges of one line are stamped than those of another: the slope of the phase over the wheel's speed.

    ``later_than`` names the other line. ``chi_squared`` with ``degrees_of_freedom`` says how straight the line is.
    """

    line: str
    later_than: str
    difference_s: Measured
    registers: tuple[GateRegister, ...]
    chi_squared: float
    degrees_of_freedom: int
    findings: tuple[Finding, ...] = ()


@final
@dataclass(frozen=True, kw_only=True)
class LoopBack:
    """A trigger that is led back into a timestamp input: how much later than the trigger it was stamped, s.

    ``mean_s`` and ``spread_s`` (standard deviation) over ``n_triggers``; ``lowest_s`` and ``highest_s`` of them. ``counts``
    has each difference in ticks and how often it came. ``n_missing`` triggers did not come back.
    """

    name: str
    line: str
    clock_frequency_hz: float
    mean_s: float
    spread_s: float
    lowest_s: float
    highest_s: float
    counts: tuple[tuple[int, int], ...]
    n_triggers: int
    n_missing: int

    @property
    def latency(self) -> Latency:
        """Latency of the trigger: the way out has a part of the time of both ways, an unknown one."""
        half_s = self.mean_s / 2
        return Latency(trigger_s=Measured(half_s, abs(half_s) / 3**0.5))
