"""The exact model and the data of one recording as curves: the whole opening, and the delay of each row by itself."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.physics.wheel import TURN
from irtiming.physics.wheel_harmonics import at_angles
from irtiming.records.arrays import Array, ComplexArray, Ticks
from irtiming.records.row_timing import RowTimingFit

_DENSE = 1441


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Curve:
    """Points ``fraction`` and ``residual`` (n,) over ``wheel_angle_rad`` (n,), and the model (m,) over ``dense_rad`` (m,)."""

    wheel_angle_rad: Array
    fraction: Array
    residual: Array
    dense_rad: Array
    model: Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RowDelays:
    """Delay of each row by itself, s, with its standard uncertainty from noise, and as all rows together give it.

    Shapes (n_row,).
    """

    row_px: Ticks
    delay_s: Array
    u_delay_s: Array
    line_s: Array


def whole(fit: RowTimingFit) -> Curve:
    """Opening fraction of the whole opening: rows weighted by their light."""
    weight = np.abs(fit.gain_dn) / np.abs(fit.gain_dn).sum()
    return _curve(fit, fit.fraction @ weight, fit.residual @ weight, weight @ fit.harmonics)


def one_row(fit: RowTimingFit, index: int) -> Curve:
    """Opening fraction of one of the fitted rows."""
    return _curve(fit, fit.fraction[:, index], fit.residual[:, index], fit.harmonics[index])


def _curve(fit: RowTimingFit, fraction: Array, residual: Array, harmonics: ComplexArray) -> Curve:
    dense = np.linspace(0, TURN, _DENSE)
    return Curve(
        wheel_angle_rad=fit.wheel_angle_rad,
        fraction=fraction,
        residual=residual,
        dense_rad=dense,
        model=at_angles(harmonics, dense),
    )


def row_delays(fit: RowTimingFit) -> RowDelays:
    """Where each row alone would have the model: one linear step of a fit of that row's delay, gain and offset.

    The step divides the residual's projection on the model's slope by that of the slope on itself; what a change of gain and
    offset would explain is taken out of the slope first.
    """
    order = np.arange(fit.harmonics.shape[1])
    slope = at_angles(1j * order * fit.harmonics, fit.wheel_angle_rad).T
    model = fit.model - fit.model.mean(axis=0)
    slope -= slope.mean(axis=0)
    slope -= model * (np.sum(slope * model, axis=0) / np.sum(model**2, axis=0))
    power = np.sum(slope**2, axis=0)
    omega = fit.angular_frequency_rad_per_s
    line = np.asarray(float(fit.edge_delay_s.mean()) + fit.row_px * fit.row_delay_s, dtype=float)
    return RowDelays(
        row_px=fit.row_px,
        delay_s=line + np.sum(slope * fit.residual, axis=0) / power / omega,
        u_delay_s=fit.noise / np.sqrt(power) / omega,
        line_s=line,
    )


def show_rows(fit: RowTimingFit, *, n: int = 4) -> list[int]:
    """Indices of some fitted rows, evenly spread over those with a fair share of the light."""
    light = np.abs(fit.gain_dn)
    bright = np.flatnonzero(light > 0.25 * light.max())
    places = np.linspace(0.04, 0.96, n) * (bright.size - 1)
    return [int(bright[round(place)]) for place in places]
