r"""One line through the stamps of frames, for measuring a camera and for applying its result alike: the median line.

.. math:: \text{stamp}_n = a + b\,x_n + \text{latency}_n

A frame that waits in a queue is late by milliseconds, never early by as much. So the line is the one with least absolute
deviations (Koenker and Bassett, Econometrica 46 (1978) 33): half of the stamps are later than it, half earlier, and how late a
late one is does not count. *The event* of a frame is its place on this line, so of arrivals the median arrival; a delay that
counts from it holds wherever the line is laid by the same rule.

For a slope b the best level is the median of :math:`y_n - b x_n`, and the sum of absolute deviations from there is convex in b
with the slope :math:`-\sum x_n s_n`, s being the signs of the deviations: the best b is where that changes its sign.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.physics import robust
from irtiming.records.arrays import Array, Ticks
from irtiming.units import readable_time

FEWEST = 8
"""Stamps of a line."""

_LATE = 5.0  # standard deviations
_PARTS, _OF_PART = 16, 5
_ROUNDS = 200
_STRETCHES = 4
_LATEST = 31  # frames whose common place tells where the grid is by now
_FAR = 0.25
_NO_GRID = 0.25
"""Part of a period within which most stamps must lie of the grid."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class StampLine:
    """The line, stamp = ``at_middle_s`` + ``rate`` (x - ``middle``).

    ``middle`` is the mean of x, where level and rate are not correlated; ``u_at_middle_s`` and ``u_rate`` are their standard
    uncertainties. ``deviation_s``, shape (n,), is by how much each stamp is later than the line, ``jitter_s`` its standard
    deviation as the median tells it, ``late_share`` the share later than five of that. ``wander_s`` is by how much stretches of
    the series wander about the line, and ``bend`` by how many times more than independent stamps.
    """

    middle: float
    at_middle_s: float
    rate: float
    u_at_middle_s: float
    u_rate: float
    deviation_s: Array
    jitter_s: float
    wander_s: float
    bend: float
    late_share: float

    def stamp_s(self, x: Array) -> Array:
        """What the stamp is on the line there, same shape."""
        return np.asarray(self.at_middle_s + self.rate * (x - self.middle))

    def x_of(self, stamp_s: Array) -> Array:
        """Where on the line a stamp is, same shape."""
        return np.asarray(self.middle + (stamp_s - self.at_middle_s) / self.rate)

    def u_s(self, x: Array) -> Array:
        """Standard uncertainty of the line there, with the wander; same shape."""
        away = self.u_rate * (np.asarray(x) - self.middle)
        return np.sqrt(self.u_at_middle_s**2 + away**2 + self.wander_s**2)


def median_line(x: Array, stamp_s: Array) -> StampLine:
    """The line with least absolute deviations through stamps.

    Parameters
    ----------
    x
        Shape (n,): times that do not scatter, s, or the number of each frame.
    stamp_s
        Shape (n,), s.

    Raises
    ------
    EstimationError
        If there are fewer than eight, all are at one x, or they do not rise together.

    Notes
    -----
    The place of a median of n independent values has the standard uncertainty 1 / (2 f sqrt(n)), f being their density there. The
    medians of sixteen parts of the series say the same without independence; the larger of the two is taken.
    """
    n = stamp_s.size
    if x.size != n or n < FEWEST:
        raise EstimationError(
            f"there are {x.size} places and {n} stamps; a line needs as many of both, {FEWEST} or more"
        )
    if not float(np.ptp(x)) > 0:
        raise EstimationError(f"all {n} stamps are of one frame or time; a line needs several")
    middle, first_s = float(np.mean(x)), float(np.median(stamp_s))
    away, of_s = np.asarray(x - middle, dtype=np.float64), stamp_s - first_s
    rate = _steepness(away, of_s)
    level = float(np.median(of_s - rate * away))
    if not rate > 0:
        raise EstimationError("stamps do not rise with the frames; check that both belong together")
    beside = of_s - level - rate * away
    jitter_s = max(robust.spread(beside), 1e-12)
    u_alone = 0.5 / (_density(beside) * np.sqrt(n))
    parts = np.array([np.median(part) for part in np.array_split(beside, max(1, min(_PARTS, n // _OF_PART)))])
    scatter = float(parts.var(ddof=1)) if parts.size >= _STRETCHES else 0.0
    u_parts = float(np.sqrt(scatter / parts.size))
    bend = u_parts / u_alone
    return StampLine(
        middle=middle,
        at_middle_s=level + first_s,
        rate=rate,
        u_at_middle_s=max(u_alone, u_parts),
        u_rate=max(1.0, bend) * u_alone / float(np.sqrt(np.mean(away**2))),
        deviation_s=beside,
        jitter_s=jitter_s,
        wander_s=float(np.sqrt(max(scatter - 2 * u_alone**2 * parts.size, 0.0))),
        bend=bend,
        late_share=float(np.mean(beside > _LATE * jitter_s)),
    )


def grid(number: Ticks, time_s: Array) -> StampLine:
    """The line over the counts of frames; stamps that are no grid are refused.

    Parameters
    ----------
    number, time_s
        Shape (n,): count and time of each frame, s.

    Raises
    ------
    EstimationError
        As `median_line`, and if half of the stamps lie further than a quarter of a period from any grid.
    """
    found = median_line(number.astype(np.float64), time_s)
    off_s = float(np.median(np.abs(found.deviation_s)))
    if not off_s < _NO_GRID * found.rate:
        raise EstimationError(
            f"half of the stamps are further than {readable_time(float(f'{off_s:.2g}'))} from a grid of "
            f"{1e3 * found.rate:.4g} ms; check the frame rate, and which frames were lost"
        )
    return found


def numbered(time_s: Array) -> Ticks:
    """Number of each time on a regular grid, from 0, shape (n,), by where the last ones were: a gap is a lost frame.

    Parameters
    ----------
    time_s
        Shape (n,), in order; some may be late, most are not.
    """
    steps = np.diff(time_s)
    if steps.size == 0:
        return np.zeros(time_s.size, np.int64)
    period = float(np.median(steps))
    near = steps[np.abs(steps - period) < _FAR * period]
    period = float(near.mean()) if near.size else period
    number = np.zeros(time_s.size, np.int64)
    beside: list[float] = [0.0]
    for i in range(1, time_s.size):
        late = float(np.median(beside[-_LATEST:]))
        number[i] = max(number[i - 1] + 1, round((time_s[i] - time_s[0] - late) / period))
        beside.append(time_s[i] - time_s[0] - number[i] * period)
    return number


def _steepness(away: Array, values: Array) -> float:
    """Slope of least absolute deviations, by halving the interval in which the sum of them has its least."""
    start = float(away @ values) / float(away @ away)
    width = float(np.ptp(values - start * away)) / float(np.ptp(away)) + 1e-15 * abs(start)
    low, high = start - width, start + width
    while _growth(away, values - low * away) > 0:
        low -= width
        width *= 2
    while _growth(away, values - high * away) < 0:
        high += width
        width *= 2
    for _ in range(_ROUNDS):
        between = (low + high) / 2
        if not low < between < high:
            break
        growth = _growth(away, values - between * away)
        if growth == 0:
            return between
        low, high = (between, high) if growth < 0 else (low, between)
    return (low + high) / 2


def _growth(away: Array, rest: Array) -> float:
    """How the sum of absolute deviations from the median grows with the slope; stamps at the median share what is left over."""
    sign = np.sign(rest - np.median(rest))
    at_median = sign == 0
    if at_median.any():
        sign[at_median] = -float(sign.sum()) / np.count_nonzero(at_median)
    return -float(away @ sign)


def _density(beside: Array) -> float:
    """Density at zero, 1/s, by a box of the width that normal scatter of the middle half asks for."""
    middle_half = float(np.subtract(*np.quantile(beside, (0.75, 0.25)))) / 1.349
    half = max(1.06 * middle_half * beside.size**-0.2, 1e-12)
    return max(1, int(np.count_nonzero(np.abs(beside) <= half))) / (2 * half * beside.size)
