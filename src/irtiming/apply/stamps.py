"""Stamps of frames: what was written beside each frame, and how sure it is of the trigger edge that made the frame."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.records.arrays import Array, Ticks

UNKNOWN_CLOCK = 50e-6 / 3**0.5
"""Relative standard uncertainty of a crystal's rate that nobody measured: rectangular."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TriggerTimes:
    """When each frame's trigger edge was, in the scale of the stamps.

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
        the trigger path, where the same trigger generator stamped both.
    relative_rate, u_rate
        By how much faster than SI seconds the scale counts, and its standard uncertainty.
    scale
        In words, what the times are seconds of.
    remarks
        What the uncertainties do not hold.
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
class Latency:
    """By how much later than the trigger edge a stamp is, on average, and the standard uncertainty of that; s."""

    value_s: float
    u_s: float


@final
@dataclass(frozen=True, kw_only=True)
class Generator:
    """What is known of a trigger generator: relative error of its clock, and latency of its triggers, None where not stated.

    A trigger is at the camera's connector, from where delays count, that much later than its stamp.
    """

    relative_error: float = 0.0
    u_relative_error: float = UNKNOWN_CLOCK
    trigger_latency: Latency | None = None


def from_ticks(
    trigger_ticks: Ticks, *, clock_frequency_hz: float, set_delay_s: float = 0.0, generator: Generator | None = None
) -> TriggerTimes:
    """Trigger edges that a trigger generator stamped.

    Parameters
    ----------
    trigger_ticks
        Shape (n_frame,): the trigger of each frame, before the delay that was set.
    clock_frequency_hz
        Nominal frequency of the counter.
    set_delay_s
        Delay set in the trigger generator: what the camera got came so much later; s.
    generator
        What is known of it; None: a crystal that nobody measured, and delays that count from the stamps.
    """
    known = generator or Generator()
    late = known.trigger_latency or Latency(value_s=0.0, u_s=0.0)
    return TriggerTimes(
        time_s=trigger_ticks / clock_frequency_hz + set_delay_s + late.value_s,
        u_own_s=12**-0.5 / clock_frequency_hz,
        u_cancelled_s=late.u_s,
        relative_rate=known.relative_error,
        u_rate=known.u_relative_error,
        scale="s of the trigger generator's counter, since it was 0",
    )
