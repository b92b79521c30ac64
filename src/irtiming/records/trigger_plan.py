"""What a person wishes of a measurement, and the trigger schemes and runs that serve it; exact numbers only.

Symbols (Schatz 2023, section 2.3), all in ticks of one clock of f Hz:

========= =============================== ==============================================================
symbol    name                            meaning
========= =============================== ==============================================================
T         ``turn_period_ticks``           one turn of the wheel
T'        ``control_slot_period_ticks``   period of the reference signal for the chopper, T / control slots
C         ``camera_period_ticks``         between two camera triggers
delta     ``sampling_interval_ticks``     gcd(T, C), between neighbouring samples of the turn
N         ``samples_per_turn``            T / delta
K         ``samples_per_frame``           C / delta, coprime to N
========= =============================== ==============================================================
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from math import gcd
from typing import NamedTuple, final

from irtiming.errors import PlanError

MOST_SAMPLES = 10_000_000
"""Samples per turn that a wish may allow: at 30 frames per second these take four days."""


@final
@dataclass(frozen=True, kw_only=True)
class Wish:
    """A number that is wanted, and the limits within which another will do (both belong to the range).

    ``lowest == highest`` makes the wish exact. Integers and fractions only: a float is refused with
    `PlanError`, and so is a wish that is not positive or lies outside its own limits.
    """

    wanted: Fraction
    lowest: Fraction
    highest: Fraction

    def __post_init__(self) -> None:
        for number in (self.wanted, self.lowest, self.highest):
            _check_exact(number, "a wish")
        if not 0 < self.lowest <= self.wanted <= self.highest:
            raise PlanError(
                f"a wish of {self.wanted} within {self.lowest} .. {self.highest} cannot be; all three must "
                "be positive, in the order lowest, wanted, highest"
            )


@final
@dataclass(frozen=True, kw_only=True)
class Wishes:
    """All that a measurement of one camera is asked to be.

    ``wheel_rates_hz`` holds one wish per wheel speed. ``longest_uninterrupted_s`` is the time between two
    non-uniformity corrections, None if there is no limit. ``trigger_delays_s`` are added to the camera's own
    delay, one series of ``repeats`` runs each.
    """

    clock_frequency_hz: int
    wheel_rates_hz: tuple[Wish, ...]
    frame_rate_hz: Wish
    samples_per_turn: Wish
    control_slots: int = 100
    longest_uninterrupted_s: Fraction | None = None
    trigger_delays_s: tuple[Fraction, ...] = (Fraction(0),)
    repeats: int = 1

    def __post_init__(self) -> None:
        counts = {
            "clock frequency in Hz": self.clock_frequency_hz,
            "number of control slots": self.control_slots,
            "number of repeats": self.repeats,
        }
        for name, count in counts.items():
            if not isinstance(count, int) or count < 1:
                raise PlanError(f"the {name} is {count}, but must be a whole number of at least 1")
        if self.samples_per_turn.wanted % 1:
            raise PlanError(
                f"{float(self.samples_per_turn.wanted):.10g} samples per turn are wanted, but only whole samples can be; "
                f"{max(1, round(self.samples_per_turn.wanted))} is the nearest number"
            )
        if self.samples_per_turn.highest > MOST_SAMPLES:
            raise PlanError(
                f"{float(self.samples_per_turn.highest):.10g} samples per turn are allowed, each of them a frame; "
                f"allow {MOST_SAMPLES} at most"
            )
        if not self.wheel_rates_hz:
            raise PlanError("there is no wheel rate to plan for; wish for at least one")
        if not self.trigger_delays_s:
            raise PlanError("there is no trigger delay to plan for; wish for at least one, 0 s is the usual")
        for delay in self.trigger_delays_s:
            _check_exact(delay, "a trigger delay")
            if delay < 0:
                raise PlanError(f"the trigger delay is {delay} s, but a trigger cannot be advanced; give 0 or more")
        if self.longest_uninterrupted_s is not None:
            _check_exact(self.longest_uninterrupted_s, "the time between two corrections")
            if self.longest_uninterrupted_s <= 0:
                raise PlanError(
                    f"the time between two non-uniformity corrections is {self.longest_uninterrupted_s} s, "
                    "but must be positive; leave it out if there is no limit"
                )


class Trigger(NamedTuple):
    """Camera trigger ``number``, ``ticks`` after the first one, at ``sample`` of the turn in 0 .. N - 1."""

    number: int
    ticks: int
    sample: int


@final
@dataclass(frozen=True, kw_only=True)
class TriggerScheme:
    """Camera triggers that sample one wheel turn finer than the camera period (Schatz 2023, 2.3).

    Iterating yields the N triggers of one run in the order of time. T and C determine all else, so that delta
    is their greatest common divisor and N and K are coprime by construction. `PlanError` if T is not a
    multiple of the number of control slots, or a period is not positive.
    """

    turn_period_ticks: int
    camera_period_ticks: int
    control_slots: int = 100

    def __post_init__(self) -> None:
        if min(self.turn_period_ticks, self.camera_period_ticks, self.control_slots) < 1:
            raise PlanError(
                f"T = {self.turn_period_ticks}, C = {self.camera_period_ticks} ticks and "
                f"{self.control_slots} control slots cannot be; each must be at least 1"
            )
        if self.turn_period_ticks % self.control_slots:
            below = self.turn_period_ticks // self.control_slots * self.control_slots
            raise PlanError(
                f"T = {self.turn_period_ticks} ticks is not a multiple of the {self.control_slots} control "
                f"slots; the nearest that are lie at {below or self.control_slots} and "
                f"{below + self.control_slots} ticks"
            )

    @property
    def control_slot_period_ticks(self) -> int:
        """T' = T / control slots: period of the reference signal for the chopper."""
        return self.turn_period_ticks // self.control_slots

    @property
    def sampling_interval_ticks(self) -> int:
        """Delta = gcd(T, C)."""
        return gcd(self.turn_period_ticks, self.camera_period_ticks)

    @property
    def samples_per_turn(self) -> int:
        """N = T / delta: also the number of frames in a run."""
        return self.turn_period_ticks // self.sampling_interval_ticks

    @property
    def samples_per_frame(self) -> int:
        """K = C / delta: also the number of turns in a run."""
        return self.camera_period_ticks // self.sampling_interval_ticks

    def __iter__(self) -> Iterator[Trigger]:
        for number in range(self.samples_per_turn):
            ticks = number * self.camera_period_ticks
            yield Trigger(number, ticks, ticks % self.turn_period_ticks // self.sampling_interval_ticks)


@final
@dataclass(frozen=True, kw_only=True)
class PlannedRun:
    """One unbroken train of camera triggers: ``repeats`` times a scheme, all with one extra trigger delay.

    ``is_after_correction`` says that the camera makes a non-uniformity correction just before it.
    """

    scheme: TriggerScheme
    trigger_delay_ticks: int
    repeats: int
    is_after_correction: bool


@final
@dataclass(frozen=True, kw_only=True)
class TriggerPlan:
    """One camera's measurement: a scheme per wheel speed and the runs in order; iterating yields the runs."""

    clock_frequency_hz: int
    schemes: tuple[TriggerScheme, ...]
    runs: tuple[PlannedRun, ...]

    def __iter__(self) -> Iterator[PlannedRun]:
        return iter(self.runs)

    @property
    def shortest_period_s(self) -> float:
        """Between triggers of the camera, of all runs, s."""
        return min(run.scheme.camera_period_ticks for run in self.runs) / self.clock_frequency_hz


def _check_exact(number: object, name: str) -> None:
    if isinstance(number, bool) or not isinstance(number, int | Fraction):
        raise PlanError(
            f"{name} is {number!r}, which is not exact; give an int or a Fraction, such as Fraction('30.303')"
        )
