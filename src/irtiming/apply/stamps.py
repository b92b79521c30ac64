"""Stamps of frames: what was written beside each frame, and how sure it is of the event that the frame's delay counts from."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.inference import stamp_line
from irtiming.records.arrays import Array, Ticks
from irtiming.units import readable_time

UNKNOWN_CLOCK = 50e-6 / 3**0.5
"""Relative standard uncertainty of an unmeasured crystal's rate: rectangular."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class EventTimes:
    """When each frame's event was, its trigger edge or what else a result counts from, in the scale of the stamps.

    Parameters
    ----------
    time_s
        Shape (n_frame,), rising; since ``origin_s`` of the scale.
    origin_s
        Whole seconds that were taken off, so that nanoseconds of a date still count.
    u_own_s
        Standard uncertainty of each frame's by itself, not shared with others; s.
    u_common_s
        Standard uncertainty that all frames share; s.
    u_cancelled_s
        Standard uncertainty that the stamps share with the delay of the result, with the opposite sign: that of the latency of
        the trigger path, or of the strobe's, where the same trigger generator stamped both.
    relative_rate, u_rate
        By how much faster than SI seconds the scale counts, and its standard uncertainty.
    scale
        In words, what the times are seconds of.
    remarks
        What the uncertainties do not include.
    """

    time_s: Array
    origin_s: int = 0
    u_own_s: float = 0.0
    u_common_s: float = 0.0
    u_cancelled_s: float = 0.0
    relative_rate: float = 0.0
    u_rate: float = 0.0
    scale: str
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.time_s.size < 1 or not np.all(np.isfinite(self.time_s)):
            raise EstimationError("there are no stamps, or one is no finite number; give one for each frame")
        if self.time_s.size > 1 and not np.all(np.diff(self.time_s) > 0):
            at = int(np.argmax(np.diff(self.time_s) <= 0)) + 1
            raise EstimationError(f"stamp {at} is not later than the one before; stamps must rise: check their order")

    @property
    def frame_period_s(self) -> float | None:
        """Median time between frames; None for a single one."""
        return float(np.median(np.diff(self.time_s))) if self.time_s.size > 1 else None


@final
@dataclass(frozen=True, kw_only=True)
class Scatter:
    """How single stamps lie about the event, which is their median: mean and standard deviation, quantiles by share; s."""

    mean_s: float
    standard_deviation_s: float
    quantiles_s: Mapping[float, float]

    @property
    def words(self) -> str:
        """The quantiles in one line."""
        return ", ".join(
            f"{100 * share:g} %: {1e3 * round(at_s, 9):+.4g} ms" for share, at_s in self.quantiles_s.items()
        )


@final
@dataclass(frozen=True, kw_only=True)
class Latency:
    """By how much later than the event a stamp is, and the standard uncertainty of that; s."""

    value_s: float
    u_s: float


@final
@dataclass(frozen=True, kw_only=True)
class Generator:
    """What is known of a trigger generator: relative error of its clock, and latency of its triggers, None where not stated.

    An event, from which delays count, is ``way`` later than its stamp: a trigger is at the camera's connector later than that, a
    strobe left the camera earlier (negative).
    """

    relative_error: float = 0.0
    u_relative_error: float = UNKNOWN_CLOCK
    way: Latency | None = None


def from_ticks(
    event_ticks: Ticks, *, clock_frequency_hz: float, set_delay_s: float = 0.0, generator: Generator | None = None
) -> EventTimes:
    """Trigger or strobe edges that a trigger generator stamped.

    Parameters
    ----------
    event_ticks
        Shape (n_frame,): the edge of each frame, of triggers before the delay that was set.
    clock_frequency_hz
        Nominal frequency of the counter.
    set_delay_s
        Delay set in the trigger generator: what the camera got came so much later; s.
    generator
        What is known of it; None: an unmeasured crystal, and delays that count from the stamps.
    """
    known = generator or Generator()
    late = known.way or Latency(value_s=0.0, u_s=0.0)
    return EventTimes(
        time_s=event_ticks / clock_frequency_hz + set_delay_s + late.value_s,
        u_own_s=12**-0.5 / clock_frequency_hz,
        u_cancelled_s=late.u_s,
        relative_rate=known.relative_error,
        u_rate=known.u_relative_error,
        scale="s of the trigger generator's counter, since it was 0",
    )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Raw:
    """Stamps as a file has them, shape (n_frame,), since ``origin_s``, in steps; the number of each frame where it says so."""

    time_s: Array
    origin_s: int = 0
    step_s: float = 0.0
    numbers: Ticks | None = None

    @property
    def u_step_s(self) -> float:
        """Standard uncertainty by the step in which stamps go."""
        return self.step_s / 12**0.5


def each_exact(raw: Raw, *, scale: str, latency: Latency) -> EventTimes:
    """Stamps of edges: each is an event, its latency taken off."""
    return EventTimes(
        time_s=raw.time_s - latency.value_s, origin_s=raw.origin_s, u_own_s=raw.u_step_s, u_common_s=latency.u_s,
        u_rate=UNKNOWN_CLOCK, scale=scale,
    )  # fmt: skip


def on_grid(raw: Raw, *, scale: str, latency: Latency) -> EventTimes:
    """Stamps that scatter about a regular clock: events are the places on their median line.

    Parameters
    ----------
    raw
        The stamps; without numbers of frames these follow from the stamps.
    scale
        In words.
    latency
        By how much later than the event the line is.

    Raises
    ------
    EstimationError
        If there are fewer than eight, or they are no grid.
    """
    numbers = stamp_line.numbered(raw.time_s) if raw.numbers is None else raw.numbers - raw.numbers[0]
    line = stamp_line.grid(numbers, raw.time_s)
    at = numbers.astype(np.float64)
    u_line_s = float(np.sqrt(np.mean(line.u_s(at) ** 2)))
    remark = (
        f"stamps scatter by {_short(line.jitter_s)} about a regular frame clock, {100 * line.late_share:.1f} % are later "
        f"by five times as much; frames every {readable_time(line.rate)}; it is taken that frames were made regularly"
    )
    return EventTimes(
        time_s=line.stamp_s(at) - latency.value_s, origin_s=raw.origin_s, u_own_s=raw.u_step_s,
        u_common_s=float(np.hypot(latency.u_s, u_line_s)), u_rate=UNKNOWN_CLOCK, scale=scale, remarks=(remark,),
    )  # fmt: skip


def each_alone(raw: Raw, *, scale: str, scatter: Scatter) -> EventTimes:
    """Stamps that scatter, each taken by itself: the event is the stamp less the mean of the scatter, within the scatter.

    Raises
    ------
    EstimationError
        If stamps less that do not rise.
    """
    remark = (
        f"each stamp was taken by itself: it scatters about its event, as the result measured it, by "
        f"{_short(scatter.standard_deviation_s)} (in u); its distribution: {scatter.words}"
    )
    return EventTimes(
        time_s=raw.time_s - scatter.mean_s, origin_s=raw.origin_s,
        u_own_s=float(np.hypot(raw.u_step_s, scatter.standard_deviation_s)), u_rate=UNKNOWN_CLOCK, scale=scale,
        remarks=(remark,),
    )  # fmt: skip


def _short(time_s: float) -> str:
    return readable_time(float(f"{time_s:.3g}"))
