"""Slow drift of a camera's level, separated from what the wheel does to it."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.physics import robust, smooth_curve
from irtiming.records.arrays import Array, Ticks

_ORDERS = 30
_KNOT_EVERY_S = 5.0
_ROUNDS = 6
_SETTLED = 0.02
_HUBER = 1.5
_CHUNK = 4096
_RIDGE = 1e-10


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Drift:
    """Slow change of level, shape (n,), mean zero; ``jump_dn`` the part of it that is a level of its own per segment."""

    level_dn: Array
    jump_dn: Array


def fit(
    level_dn: Array, time_s: Array, *, wheel_angle_rad: Array | None, segment: Ticks, straight: bool = False
) -> Drift:
    """Drift of a level over time: a straight line or, where the data show more, a smooth curve; and jumps between segments.

    Parameters
    ----------
    level_dn, time_s, wheel_angle_rad, segment
        Shape (n,).
        ``wheel_angle_rad`` is None for a level that does not follow the wheel.
    straight
        A straight line and no more, as published (Schatz 2023, 3.2.3).

    Notes
    -----
    Harmonics of the wheel angle are fitted beside the drift. Sampled once a frame, some of them may look as slow as a drift:
    167 samples of 1000 from frame to frame make a beat of two periods a run of order 6. Then the two cannot be distinguished, and
    it takes a level that does not follow the wheel, fitted without harmonics.
    Cubic splines with 1, 2, 4.. intervals, none shorter than 5 s, against the straight line: the Bayesian information
    criterion chooses. Huber weights keep single frames from bending the curve.
    """
    span = float(np.ptp(time_s)) or 1.0
    place = (time_s - time_s.min()) / span
    n_segments = int(segment.max()) + 1
    orders = 0 if wheel_angle_rad is None else _ORDERS
    angle = np.zeros(level_dn.size) if wheel_angle_rad is None else wheel_angle_rad
    fixed = _Fixed(level=level_dn - np.median(level_dn), angle=angle, segment=segment, orders=orders)
    best, best_criterion = None, np.inf
    most = 0 if straight else max(1, int(span / _KNOT_EVERY_S))
    intervals = sorted({0, most, *(2**k for k in range(16) if 2**k < most)})
    for n_intervals in intervals:
        trend = smooth_curve.columns(place, n_intervals)
        size = trend.shape[1] + n_segments + 2 * orders
        if size > level_dn.size // 4 and best is not None:
            break
        coefficients, deviance = _robust(fixed, trend)
        criterion = level_dn.size * np.log(max(deviance, 1e-300)) + size * np.log(level_dn.size)
        if criterion < best_criterion:
            best, best_criterion = (trend, coefficients), criterion
    if best is None:
        return Drift(level_dn=np.zeros(level_dn.size), jump_dn=np.zeros(level_dn.size))
    trend, coefficients = best
    jump = coefficients[:n_segments][segment]
    curve = trend @ coefficients[n_segments : n_segments + trend.shape[1]]
    return Drift(level_dn=curve + jump - np.mean(curve + jump), jump_dn=jump - jump.mean())


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Fixed:
    """What does not change from one trend to the next."""

    level: Array
    angle: Array
    segment: Ticks
    orders: int

    def design(self, trend: Array, part: slice) -> Array:
        """Columns: one per segment, the trend, cosine and sine of each order."""
        segments = (self.segment[part, None] == np.arange(int(self.segment.max()) + 1)).astype(float)
        phase = np.arange(1, self.orders + 1) * self.angle[part, None]
        return np.concatenate([segments, trend[part], np.cos(phase), np.sin(phase)], axis=1)


def _robust(fixed: _Fixed, trend: Array) -> tuple[Array, float]:
    """Coefficients by Huber weights, and the mean Huber loss."""
    n = fixed.level.size
    weight = np.ones(n)
    coefficients = np.zeros(0)
    deviance = 0.0
    for _ in range(_ROUNDS):
        normal: Array | float = 0.0
        right: Array | float = 0.0
        for first in range(0, n, _CHUNK):
            part = slice(first, first + _CHUNK)
            design = fixed.design(trend, part)
            normal = normal + design.T @ (weight[part, None] * design)
            right = right + design.T @ (weight[part] * fixed.level[part])
        matrix = np.asarray(normal)
        matrix = matrix + _RIDGE * np.trace(matrix) * np.eye(len(matrix))
        coefficients = np.linalg.solve(matrix, np.asarray(right))
        beside = np.concatenate(
            [
                fixed.level[first : first + _CHUNK] - fixed.design(trend, slice(first, first + _CHUNK)) @ coefficients
                for first in range(0, n, _CHUNK)
            ]
        )
        size = np.abs(beside)
        limit = max(_HUBER * robust.OF_NORMAL * float(np.median(size)), 1e-12)
        deviance = float(np.mean(robust.huber_loss(size, limit)))
        before, weight = weight, robust.huber_weight(size, limit)
        if np.abs(weight - before).max() < _SETTLED:
            break
    return coefficients, deviance
