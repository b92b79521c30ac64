"""The trigger generator's clock against pulses of a known period."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from irtiming.errors import EstimationError, ReductionError
from irtiming.physics import clock_rate
from irtiming.records.arrays import Ticks
from irtiming.records.clock_check import ClockCheck
from irtiming.records.finding import Finding
from irtiming.records.rig import Clock, Measured
from irtiming.units import first_of, readable_time

_FAR_OFF = 100e-6
_SIGNIFICANT = 4.0
_NAMED = 5


def estimate(ticks: Ticks | None, *, name: str, clock_frequency_hz: float, pulse_period_s: float = 1.0) -> ClockCheck:
    """Error of a clock from pulses that it stamped.

    Parameters
    ----------
    ticks
        Of the pulses, shape (n_pulse,), in order; None or empty: there are none.
    name
        Of the recording, for messages.
    clock_frequency_hz
        Nominal.
    pulse_period_s
        In SI seconds, taken as exact.

    Raises
    ------
    EstimationError
        If there are too few pulses of this period.
    """
    if ticks is None or not ticks.size:
        raise EstimationError(
            f"{name}: no pulses were recorded; connect a pulse per second to the spare input of the trigger generator and "
            "record it (spare = true in plan.toml, --spare with irtiming gateware record)"
        )
    try:
        train = clock_rate.pulse_train(ticks, period_ticks=pulse_period_s * clock_frequency_hz)
    except ReductionError as error:
        raise EstimationError(f"{name}: {error}") from error
    true_s = np.asarray(train.number * pulse_period_s, dtype=np.float64)
    seen_s = (train.ticks - train.ticks[0]) / clock_frequency_hz
    found = clock_rate.line(true_s, seen_s, tick_s=1 / clock_frequency_hz)
    relative = Measured(found.slope.value - 1, found.slope.standard_uncertainty)
    late_s = seen_s - true_s
    extra = [float(ticks[index] - train.ticks[0]) / clock_frequency_hz for index in train.extra]
    check = ClockCheck(
        name=name,
        clock_frequency_hz=clock_frequency_hz,
        pulse_period_s=pulse_period_s,
        relative_error=relative,
        drift_per_s=found.bend_per_s,
        scatter_s=found.scatter_s,
        time_s=true_s,
        residual_s=found.residual_s,
        stability=clock_rate.allan_deviation(train.number, late_s, period_s=pulse_period_s),
        missing_s=tuple(number * pulse_period_s for number in train.missing),
        extra_s=tuple(extra),
        findings=_odd_pulses(name, [number * pulse_period_s for number in train.missing], extra),
    )
    return _with_findings(check)


def combined(checks: Sequence[ClockCheck], *, pulse_u: float = 0.0) -> Clock:
    """The clock as all recordings show it: their weighted mean.

    Where they lie further apart than their uncertainties allow the clock has moved: then it is as uncertain in each of them as
    they scatter, not as their mean.

    Parameters
    ----------
    checks
        One or more.
    pulse_u
        Relative standard uncertainty of the rate of the pulses, common to all.
    """
    value = np.array([one.relative_error.value for one in checks])
    weight = np.array([one.relative_error.standard_uncertainty for one in checks]) ** -2.0
    mean = float(weight @ value / weight.sum())
    parts = [float(weight.sum()) ** -0.5, pulse_u]
    free = len(checks) - 1
    if float(weight @ (value - mean) ** 2) > free + 2 * math.sqrt(2 * free):
        parts.append(float(value.std(ddof=1)))
    return Clock(relative_error=Measured(mean, math.hypot(*parts)))


def _odd_pulses(name: str, missing_s: Sequence[float], extra_s: Sequence[float]) -> tuple[Finding, ...]:
    found = []
    if missing_s:
        what = f"{_pulses(missing_s)} missing, at {_named(missing_s)} after the first"
        found.append(
            Finding(code="pulses-missing", severity="warning", recording=name, what=what, cure="check cable and source")
        )
    if extra_s:
        what = f"{_pulses(extra_s)} not of the train, at {_named(extra_s)} after the first"
        cure = "check the cable for echoes, and set a glitch filter"
        found.append(Finding(code="pulses-extra", severity="warning", recording=name, what=what, cure=cure))
    return tuple(found)


def _pulses(times_s: Sequence[float]) -> str:
    return "1 pulse is" if len(times_s) == 1 else f"{len(times_s)} pulses are"


def _named(times_s: Sequence[float]) -> str:
    return first_of([f"{time:.6g} s" for time in times_s], most=_NAMED)


def _with_findings(check: ClockCheck) -> ClockCheck:
    """The same, with what the numbers are worth saying."""
    found, error, drift = list(check.findings), check.relative_error, check.drift_per_s
    if abs(error.value) > _FAR_OFF:
        what = f"the clock is {1e6 * error.value:+.1f} ppm off, further than crystals are"
        cure = "check clock_frequency, and that the pulses come from a good source"
        found.append(Finding(code="clock-far-off", severity="warning", recording=check.name, what=what, cure=cure))
    span_s = float(check.time_s[-1] - check.time_s[0])
    moved = drift.value * span_s
    if (
        abs(drift.value) > _SIGNIFICANT * drift.standard_uncertainty
        and abs(moved) > _SIGNIFICANT * error.standard_uncertainty
    ):
        what = f"the clock's error changes by {1e6 * moved:+.3g} ppm within {readable_time(span_s)}"
        cure = "let the trigger generator warm up before it is used"
        found.append(Finding(code="clock-drifts", severity="warning", recording=check.name, what=what, cure=cure))
    return replace(check, findings=tuple(found))
