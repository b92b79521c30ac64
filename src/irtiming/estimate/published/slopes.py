"""Straight lines through the four slopes of the opening fraction (Schatz 2023, 3.1.4)."""

import numpy as np

from irtiming.errors import EstimationError
from irtiming.physics.wheel import EDGE_SIGNS, TURN, slope_centres_rad
from irtiming.records.arrays import Array
from irtiming.records.estimate import PublishedFit, SlopeLine
from irtiming.records.exposed import ExposedFraction
from irtiming.records.wheel_geometry import WheelModel

_FEWEST_POINTS = 10


def fit(
    data: ExposedFraction, model: WheelModel, *, angular_frequency_rad_per_s: float, limits: tuple[float, float]
) -> PublishedFit:
    """One line 1/2 + m (x - c) per slope, through the points between the limits.

    Slopes that cross 2 pi are wrapped around. Each slope is given to the wheel edge whose nominal place, shifted by the
    delay that was set, is nearest among those with the same sign.

    Parameters
    ----------
    data
        Averaged opening fractions over the wheel angle at the trigger.
    model
        Where the slopes would be without any delay.
    angular_frequency_rad_per_s
        Of the wheel.
    limits
        Opening fractions between which points are used; 0.05 and 0.95 in the paper.

    Raises
    ------
    EstimationError
        If a slope has fewer than 10 points.
    """
    shift = angular_frequency_rad_per_s * data.trigger_delay_time_set_s
    nominal = np.mod(slope_centres_rad(model) - shift, TURN)
    ordered = sorted(data.plateaus)
    lines: dict[int, SlopeLine] = {}
    for before, after in zip(ordered, ordered[1:] + ordered[:1], strict=True):
        middle = before[1] + np.mod(after[0] - before[1], TURN) / 2
        kind = after[2] - before[2]
        candidates = [i for i in range(4) if EDGE_SIGNS[i] == kind and i not in lines]
        if not candidates:
            raise EstimationError(
                f"{', '.join(data.names)}: the plateaus alternate as {[p[2] for p in ordered]} over a turn, they must "
                "alternate between 0 and 1; record again with the whole opening in view"
            )
        away = np.abs(np.angle(np.exp(1j * (nominal - middle))))
        edge = min(candidates, key=lambda i: float(away[i]))
        lines[edge] = _slope_line(data, edge, middle, limits)
    return PublishedFit(
        data=data,
        lines=(lines[0], lines[1], lines[2], lines[3]),
        angular_frequency_rad_per_s=angular_frequency_rad_per_s,
    )


def _slope_line(data: ExposedFraction, edge: int, middle: float, limits: tuple[float, float]) -> SlopeLine:
    angle = middle + np.mod(data.wheel_angle_rad - middle + np.pi, TURN) - np.pi
    on_slope = (np.abs(angle - middle) < TURN / 8) & (data.fraction > limits[0]) & (data.fraction < limits[1])
    if on_slope.sum() < _FEWEST_POINTS:
        raise EstimationError(
            f"{', '.join(data.names)}: slope of edge {edge} has {on_slope.sum()} points between {limits[0]} and {limits[1]}, at "
            f"least {_FEWEST_POINTS} are needed; sample the turn more finely"
        )
    order = np.argsort(angle[on_slope])
    x, y = angle[on_slope][order], data.fraction[on_slope][order]
    u_x = None if data.u_wheel_angle_rad is None else data.u_wheel_angle_rad[on_slope][order]
    u_y = None if data.u_fraction is None else data.u_fraction[on_slope][order]
    (slope, centre), covariance, chi_square = line_through(x, y, u_x=u_x, u_y=u_y)
    return SlopeLine(
        edge=edge,
        centre_rad=centre,
        u_centre_rad=float(np.sqrt(covariance[1, 1])),
        slope_per_rad=slope,
        reduced_chi_square=chi_square,
        angle_rad=x,
        fraction=y,
    )


def line_through(
    x: Array, y: Array, *, u_x: Array | None, u_y: Array | None
) -> tuple[tuple[float, float], Array, float]:
    """Fit y = 1/2 + m (x - c) with uncertainties in both variables.

    Each point weighs 1 / (u_y^2 + m^2 u_x^2), its effective variance; without uncertainties all weigh the same. The
    covariance is scaled by the reduced chi square, as gnuplot's ``fit`` does.

    Parameters
    ----------
    x, y, u_x, u_y
        Shape (n,).

    Returns
    -------
    (m, c), their covariance (2, 2), and the reduced chi square (the residual variance where there are no uncertainties).
    """
    origin = float(x.mean())
    slope, height = (float(v) for v in np.polyfit(x - origin, y, 1))
    for _ in range(50):
        weight = np.ones_like(x) if u_x is None or u_y is None else 1 / np.maximum(u_y**2 + slope**2 * u_x**2, 1e-30)
        design = np.stack([x - origin, np.ones_like(x)], axis=1)
        normal = design.T @ (weight[:, None] * design)
        before = slope
        slope, height = (float(v) for v in np.linalg.solve(normal, design.T @ (weight * y)))
        if abs(slope - before) <= 1e-13 * abs(slope):
            break
    residual = y - height - slope * (x - origin)
    chi_square = float(weight @ residual**2) / (x.size - 2)
    centre = origin + (0.5 - height) / slope
    jacobian = np.array([[1.0, 0.0], [-(0.5 - height) / slope**2, -1 / slope]])
    covariance = jacobian @ np.linalg.inv(normal) @ jacobian.T * chi_square
    return (slope, centre), covariance, chi_square
