"""A plausible time constant from the start of the slopes, where the search begins (Schatz 2023, 3.2.4)."""

import numpy as np
from scipy.optimize import least_squares

from irtiming.errors import EstimationError
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array
from irtiming.records.exposed import ExposedRows

_TRIED_S = (1e-3, 3e-3, 10e-3, 30e-3)
_FEWEST_POINTS = 8


def plausible_time_constant_s(data: ExposedRows) -> float:
    """Median over the slopes of the whole opening of the time constant with which each begins, s.

    From the moment at which a wheel edge enters the opening, the target goes down, or up, on a straight line, and the pixel
    follows: what it is behind that line is a decaying exponential. Line and exponential are fitted from the end of a plateau
    to half way down, or up. As rows are read one after the other, the slope of the whole opening begins gradually and the
    value comes out too large, by a quarter for the camera of the paper: good enough to begin with.

    Raises
    ------
    EstimationError
        If no slope begins like that.
    """
    found = [tau for start in _starts(data) if (tau := _fit(*start)) is not None]
    if not found:
        raise EstimationError(
            f"{', '.join(data.names)}: at the start of none of the slopes does the opening fraction fall behind on a decaying "
            "exponential, so that no range of time constants can be given; sample the turn more finely"
        )
    return float(np.median(found))


def _starts(data: ExposedRows) -> list[tuple[Array, Array]]:
    """Time after the plateau's extremum and way made since, both from 0 on, for each slope that has enough points."""
    fraction, n = data.fraction, data.fraction.size
    high = fraction > 0.5
    arrived = np.flatnonzero(high != np.roll(high, 1))
    starts = []
    for before, end in zip(np.roll(arrived, 1), arrived, strict=True):
        index = np.arange(before, end if end > before else end + n) % n
        way = 1 - fraction[index] if high[before] else fraction[index]
        index, way = index[np.argmin(way) :], way[np.argmin(way) :]
        if index.size >= _FEWEST_POINTS:
            angle = np.mod(data.wheel_angle_rad[index] - data.wheel_angle_rad[index[0]], TURN)
            starts.append((angle / data.angular_frequency_rad_per_s, way))
    return starts


def _fit(time_s: Array, way: Array) -> float | None:
    """Time constant of way = c + m (s - tau (1 - exp(-s / tau))), s the time since the edge entered; None if it fails."""
    steep = way > 0.25
    if steep.sum() < 2:
        return None
    slope, height = np.polyfit(time_s[steep], way[steep], 1)

    def residual(parameters: Array) -> Array:
        entered_s, rate, tau_s, level = parameters
        since = np.maximum(time_s - entered_s, 0.0)
        return level + rate * (since + tau_s * np.expm1(-since / tau_s)) - way

    fits = [
        least_squares(
            residual,
            [max(-height / slope - tau_s, 0.0), slope, tau_s, 0.0],
            bounds=([-np.inf, 0.0, 1e-5, -0.5], [time_s[-1], np.inf, 1.0, 0.5]),
            x_scale=[1e-3, slope, tau_s, 0.01],
        )
        for tau_s in _TRIED_S
    ]
    best = min(fits, key=lambda fit: fit.cost)
    return float(best.x[2]) if best.success and 2e-5 < best.x[2] < time_s[-1] else None
