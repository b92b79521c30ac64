r"""Stamps that scatter, such as arrival times, against a clock that does not: a robust straight line.

.. math:: \text{stamp}_n = A + r\,t_n + \text{latency}_n

A frame that waits in a queue is late by milliseconds, never early by as much. So the line is fitted with Tukey's biweight: a
stamp counts less the farther it lies from the line, and nothing beyond 4.7 standard deviations. What is left after it in
stretches of the series is the clocks' wander, which goes into the uncertainty.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.records.arrays import Array, Ticks

_TUKEY = 4.685  # 95 % as good as least squares on normal noise
_TO_SIGMA = 1.4826
_MOST_ROUNDS = 50
_FEWEST = 8
_STRETCHES = 8


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ClockLine:
    """The line, stamp = ``at_middle_s`` + ``rate`` (t - ``middle_s``).

    ``u_at_middle_s`` and ``u_rate`` are standard uncertainties, ``jitter_s`` the standard deviation of a single stamp about the
    line as the median tells it, ``wander_s`` by how much the clocks wander about it, and ``late_share`` the share of stamps that
    were left out as too far off.
    """

    middle_s: float
    at_middle_s: float
    rate: float
    u_at_middle_s: float
    u_rate: float
    jitter_s: float
    wander_s: float
    late_share: float

    def stamp_s(self, time_s: Array) -> Array:
        """What the stamp of a time is on the line, same shape."""
        return np.asarray(self.at_middle_s + self.rate * (time_s - self.middle_s))

    def time_s(self, stamp_s: Array) -> Array:
        """The time whose stamp it is, same shape."""
        return np.asarray(self.middle_s + (stamp_s - self.at_middle_s) / self.rate)

    def u_s(self, time_s: Array) -> Array:
        """Standard uncertainty of the line there, with the wander; same shape."""
        away = self.u_rate * (np.asarray(time_s) - self.middle_s)
        return np.sqrt(self.u_at_middle_s**2 + away**2 + self.wander_s**2)


def line(time_s: Array, stamp_s: Array) -> ClockLine:
    """The line through stamps over times.

    Parameters
    ----------
    time_s
        Shape (n,), rising: times that do not scatter, or the number of each frame times its period.
    stamp_s
        Shape (n,).

    Raises
    ------
    EstimationError
        If there are fewer than eight, or they do not rise together.
    """
    if time_s.size != stamp_s.size or time_s.size < _FEWEST:
        raise EstimationError(
            f"there are {time_s.size} times and {stamp_s.size} stamps; a clock needs as many of both, {_FEWEST} or more"
        )
    middle_s, first_s = float(np.mean(time_s)), float(stamp_s[0])
    away, values = time_s - middle_s, stamp_s - first_s
    rate, level = _start(away, values)
    for _ in range(_MOST_ROUNDS):
        rest = values - level - rate * away
        weight = _weights(rest)
        total = float(weight.sum())
        centre = float(weight @ away) / total
        spread = float(weight @ (away - centre) ** 2)
        new = float(weight @ ((away - centre) * values)) / spread
        old, rate = rate, new
        level = float(weight @ (values - rate * away)) / total
        if abs(new - old) * np.ptp(away) < 1e-12:
            break
    if not rate > 0:
        raise EstimationError("stamps do not rise with the frames; check that both belong together")
    rest = values - level - rate * away
    counted = weight > 0
    jitter_s = _sigma(rest)
    n = max(int(np.count_nonzero(counted)) - 2, 1)
    scatter = float(np.sqrt(np.sum((weight * rest) ** 2) / max(float(np.mean(_slopes(rest))) ** 2, 1e-12) / n))
    spread = float(np.sum(away**2))
    return ClockLine(
        middle_s=middle_s,
        at_middle_s=level + first_s,
        rate=rate,
        u_at_middle_s=scatter / np.sqrt(time_s.size),
        u_rate=scatter / np.sqrt(spread),
        jitter_s=jitter_s,
        wander_s=_wander(rest[counted], scatter),
        late_share=float(1 - np.mean(counted)),
    )


def frame_numbers(stamp_s: Array) -> Ticks:
    """Number of each frame by the median time between them, shape (n,): a gap is a lost frame.

    Raises
    ------
    EstimationError
        If stamps scatter by so much that frames cannot be counted.
    """
    steps = np.diff(stamp_s)
    if steps.size < _FEWEST:
        raise EstimationError(f"there are {stamp_s.size} stamps; a clock needs more than {_FEWEST}")
    period_s = float(np.median(steps))
    if not period_s > 0:
        raise EstimationError("stamps do not rise; check their order")
    for _ in range(3):  # the median is off where queues are emptied at once; the line over the numbers is not
        numbers = np.rint((stamp_s - stamp_s[0]) / period_s)
        numbers = np.maximum.accumulate(np.maximum(numbers, np.arange(stamp_s.size)))
        if np.unique(numbers).size < stamp_s.size:
            raise EstimationError(
                f"stamps {1e3 * period_s:.3f} ms apart scatter by more than that; give the number of each frame beside its stamp"
            )
        period_s *= float(_start(numbers - numbers.mean(), (stamp_s - stamp_s[0]) / period_s)[0])
    return numbers.astype(np.int64)


def _start(away: Array, values: Array) -> tuple[float, float]:
    """Slope by medians of far pairs (Theil and Sen), and the level by the median."""
    half = away.size // 2
    run = away[half : 2 * half] - away[:half]
    rate = float(np.median((values[half : 2 * half] - values[:half]) / run))
    return rate, float(np.median(values - rate * away))


def _sigma(rest: Array) -> float:
    return max(_TO_SIGMA * float(np.median(np.abs(rest - np.median(rest)))), 1e-12)


def _weights(rest: Array) -> Array:
    far = rest / (_TUKEY * _sigma(rest))
    return np.where(np.abs(far) < 1, (1 - far**2) ** 2, 0.0)


def _slopes(rest: Array) -> Array:
    """Derivative of weight times residual to the residual: what a least-squares fit would have 1 of."""
    far = (rest / (_TUKEY * _sigma(rest))) ** 2
    return np.where(far < 1, (1 - far) * (1 - 5 * far), 0.0)


def _wander(rest: Array, scatter: float) -> float:
    """Standard deviation of the means of stretches beyond what their scatter explains."""
    parts = [part for part in np.array_split(rest, _STRETCHES) if part.size > 1]
    if len(parts) < 4:
        return 0.0
    means = np.array([np.mean(part) for part in parts])
    expected = scatter**2 / (rest.size / len(parts))
    return float(np.sqrt(max(np.var(means, ddof=1) - 2 * expected, 0.0)))
