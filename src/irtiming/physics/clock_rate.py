"""The rate of a clock from events whose number is known: a straight line, its uncertainty, and what the residuals say of it.

True seconds are ticks / (f (1 + e)), so that an event every P seconds comes every P f (1 + e) ticks.
"""

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import ReductionError
from irtiming.physics import robust
from irtiming.records.arrays import Array, Ticks
from irtiming.records.clock_check import CameraClock
from irtiming.records.rig import Measured

_LARGEST_ERROR = 1e-3
"""Relative; no crystal is so far off, and pulses of another period are further."""

_NEAR = 2e-3
"""By this share of the period a pulse may be beside the regular time that its neighbours tell."""

_STRAY = 8.0
"""Robust standard deviations beside the line beyond which a pulse is not one of the train."""

_FEWEST = 4
_ROUNDING = 1 / math.sqrt(12)
_COLOURED = 3.0


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Train:
    """Pulses a period apart, shapes (n_pulse,), ``number`` from 0; ``missing`` are numbers, ``extra`` indices of others."""

    ticks: Ticks
    number: Ticks
    missing: tuple[int, ...]
    extra: tuple[int, ...]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Line:
    """Straight line of times over other times: slope in its middle, the slope's change per second, residuals, shape (n,)."""

    slope: Measured
    bend_per_s: Measured
    residual_s: Array
    scatter_s: float


def pulse_train(ticks: Ticks, *, period_ticks: float) -> Train:
    """Number pulses that come about every ``period_ticks``; find the missing ones and those that do not belong to them.

    Parameters
    ----------
    ticks
        Shape (n,), in order.
    period_ticks
        Nominal.

    Raises
    ------
    ReductionError
        If fewer than four pulses are such a period apart.
    """
    times = ticks.astype(np.float64) - float(ticks[0]) if ticks.size else np.empty(0)
    best = np.empty(0, dtype=np.int64)
    for seed in range(times.size):
        apart = (times - times[seed]) / period_ticks
        number = np.rint(apart)
        beside = np.abs(apart - number)
        near = np.flatnonzero(beside <= np.minimum(_NEAR + _LARGEST_ERROR * np.abs(number), 0.25))
        if near.size > best.size:
            best = near
        if near.size > 0.9 * times.size:
            break
    if best.size < _FEWEST:
        raise ReductionError(
            f"{best.size} of {times.size} pulses are {period_ticks:.0f} ticks apart, at least {_FEWEST} are needed; check the "
            "period of the pulses, their cable and clock_frequency"
        )
    number = np.rint((times[best] - times[best[0]]) / period_ticks).astype(np.int64)
    kept = _in_line(times[best], number)
    index, number = best[kept], number[kept]
    number -= number[0]
    missing = sorted(set(range(int(number[-1]) + 1)) - set(number.tolist()))
    extra = sorted(set(range(times.size)) - set(index.tolist()))
    return Train(ticks=ticks[index], number=number, missing=tuple(missing), extra=tuple(extra))


def _in_line(times: Array, number: Ticks) -> Ticks:
    """Indices of one pulse for each number, the nearest to a line that strays do not move; strays left out."""
    step = np.diff(number)
    slope = float(np.median(np.diff(times)[step > 0] / step[step > 0]))
    for _ in range(3):
        beside = times - slope * number
        beside -= np.median(beside)
        order = np.lexsort((np.abs(beside), number))
        nearest = np.sort(order[np.unique(number[order], return_index=True)[1]])
        scatter = robust.spread(beside[nearest])
        kept = nearest[np.abs(beside[nearest]) <= max(_STRAY * scatter, 2.0)]
        if kept.size < _FEWEST:
            break
        slope = float(np.polyfit(number[kept], times[kept], 1)[0])
    if kept.size < _FEWEST:
        raise ReductionError(f"the pulses scatter so much that only {kept.size} lie on a line; check their source")
    return kept


def line(over_s: Array, of_s: Array, *, tick_s: float) -> Line:
    """Least squares, the uncertainty from the residuals, inflated where they are correlated.

    Parameters
    ----------
    over_s, of_s
        Shape (n,), n >= 4, s.
    tick_s
        One tick of the coarser clock: residuals are not trusted to be smaller than its rounding.

    Notes
    -----
    Residuals of a steady clock are those of the edges, independent of each other. Where the frequency wanders they are not:
    then the uncertainty is that of a first-order process of the same correlation. The slope is that of the middle: a steady drift
    does not move it where events are evenly spread.
    """
    middle = float(over_s.mean())
    x, n = over_s - middle, over_s.size
    squares = float(x @ x)
    slope = float(x @ (of_s - of_s.mean())) / squares
    residual = of_s - of_s.mean() - slope * x
    scatter = math.sqrt(float(residual @ residual) / (n - 2))
    noise = max(scatter, _ROUNDING * tick_s)
    span = float(over_s[-1] - over_s[0])
    u = max(noise * _inflation(residual) / math.sqrt(squares), tick_s / span / math.sqrt(6))
    bend = x * x - squares / n
    bend -= x * float(bend @ x) / squares
    of_bend = float(bend @ bend)
    drift = 2 * float(bend @ residual) / of_bend
    left = residual - drift / 2 * bend
    noise_left = max(math.sqrt(float(left @ left) / (n - 3)), _ROUNDING * tick_s)
    u_drift = 2 * noise_left * _inflation(left) / math.sqrt(of_bend)
    return Line(slope=Measured(slope, u), bend_per_s=Measured(drift, u_drift), residual_s=residual, scatter_s=scatter)


def _inflation(residual: Array) -> float:
    """Factor of an uncertainty where neighbouring residuals are correlated; 1 where they do not."""
    power = float(residual @ residual)
    if power == 0 or residual.size < 8:
        return 1.0
    together = float(residual[1:] @ residual[:-1]) / power
    if together <= _COLOURED / math.sqrt(residual.size):
        return 1.0
    return math.sqrt((1 + min(together, 0.99)) / (1 - min(together, 0.99)))


def allan_deviation(number: Ticks, late_s: Array, *, period_s: float) -> tuple[tuple[float, float], ...]:
    """Overlapping Allan deviation of the relative frequency at 1, 2, 4 ... periods, for those with three pairs or more.

    Parameters
    ----------
    number
        Of each pulse, shape (n,); a gap is a missing one.
    late_s
        How much later than regular each was stamped, s, shape (n,).
    period_s
        Of the pulses.

    Returns
    -------
    Interval in s and deviation, one pair for each interval.
    """
    phase = np.full(int(number[-1]) + 1, np.nan)
    phase[number] = late_s
    found, step = [], 1
    while phase.size > 2 * step:
        second = phase[2 * step :] - 2 * phase[step:-step] + phase[: -2 * step]
        second = second[np.isfinite(second)]
        if second.size >= 3:
            interval = step * period_s
            found.append((interval, math.sqrt(float(np.mean(second**2)) / 2) / interval))
        step *= 2
    return tuple(found)


def camera_clock(
    name: str, *, stamp_ticks: Ticks, stamp_frequency_hz: float, trigger_ticks: Ticks, clock_frequency_hz: float
) -> CameraClock | None:
    """Rate of the camera's own clock relative to the trigger generator's; None where too few frames carry its timestamps.

    The trigger of each frame is known, so a straight line over the triggers tells the rate; the frames' delay and the offset
    of the two clocks drop out.

    Parameters
    ----------
    name
        Of the recording.
    stamp_ticks, trigger_ticks
        Shape (n_frame,): what the camera's clock said of each frame, 0 for unknown, and the trigger that made it.
    stamp_frequency_hz, clock_frequency_hz
        Nominal, of the camera's clock and the trigger generator's.
    """
    known = stamp_ticks != 0
    n_frames = int(np.count_nonzero(known))
    if n_frames < _FEWEST or any(np.unique(ticks[known]).size < _FEWEST for ticks in (stamp_ticks, trigger_ticks)):
        return None
    if trigger_ticks[known][-1] <= trigger_ticks[known][0]:
        return None  # they go back: there is no line over them
    over_s = (trigger_ticks[known] - trigger_ticks[known][0]) / clock_frequency_hz
    of_s = (stamp_ticks[known] - stamp_ticks[known][0]) / stamp_frequency_hz
    found = line(over_s, of_s, tick_s=max(1 / stamp_frequency_hz, 1 / clock_frequency_hz))
    rate = Measured(found.slope.value - 1, found.slope.standard_uncertainty)
    return CameraClock(name=name, relative_rate=rate, scatter_s=found.scatter_s, n_frames=n_frames)
