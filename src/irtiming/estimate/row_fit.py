"""The exact model fitted to one recording: from row sums to delays, time constant, row delay and their covariance."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.estimate import harmonic_data, row_timing
from irtiming.estimate.harmonic_data import HarmonicData, packed
from irtiming.estimate.one_thread import one_thread
from irtiming.estimate.row_light import SHAPE_NUMBERS, RowLight
from irtiming.estimate.row_residuals import robust_covariance
from irtiming.estimate.row_timing import HARMONICS, Parabola, RowModel, Solution
from irtiming.physics import wheel_harmonics
from irtiming.physics.wheel import TURN
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Array, ComplexArray, Mask
from irtiming.records.reduced import ReducedRecording
from irtiming.records.row_timing import RowTimingFit, TimeConstantScan
from irtiming.records.wheel_geometry import WheelModel

_SCAN_POINTS, _SCAN_WIDTH = 21, 4.0


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Task:
    """Wheel angle (n,) of each frame, sums (n, n_row) of the lit rows, frames of each stretch; compressed, and the model."""

    angle: Array
    sums: Array
    stretches: list[Mask]
    data: list[HarmonicData]
    model: RowModel


def fit(
    rows: ReducedRecording, wheel: WheelModel, *, light: RowLight, start: RowTimingFit | None = None
) -> RowTimingFit:
    """All rows of one recording at once.

    Parameters
    ----------
    rows
        Row sums over the trigger ticks.
    wheel
        Geometry of wheel and gates; its opening angle plays no part, the light has its own.
    light
        Of the rows.
    start
        An earlier fit of the same camera; without one the start values are searched for.

    Returns
    -------
    The fit as if the light were exact: ``shape_effect`` is zero.

    Raises
    ------
    EstimationError
        If the fit does not settle.
    """
    with one_thread():
        return _fit(rows, wheel, light=light, start=start)


def with_shape_effect(
    found: RowTimingFit, rows: ReducedRecording, *, wheel: WheelModel, light: RowLight, changes: ComplexArray
) -> RowTimingFit:
    """A fit that knows what its six numbers owe to each number of the sector: one linear step.

    Parameters
    ----------
    found, rows, wheel, light
        The fit and what it was made of.
    changes
        Derivatives of the light to the sector's numbers, shape (10, n_row, M + 1); see `row_light.changes`.
    """
    with one_thread():
        task = _task(rows, wheel, light)
        values = np.array([*found.edge_delay_s, found.time_constant_s, found.row_delay_s])
        sign = -1 if rows.opening.blackbody_is_colder else 1
        again = row_timing.solve(task.data, task.model, start=values, signs=(sign,))
        functions = row_timing.row_functions(task.model, again.values)
        return replace(found, shape_effect=_shape_effect(task, again, functions=functions, changes=changes))


def _fit(rows: ReducedRecording, wheel: WheelModel, *, light: RowLight, start: RowTimingFit | None) -> RowTimingFit:
    task = _task(rows, wheel, light)
    begin = None if start is None else np.array([*start.edge_delay_s, start.time_constant_s, start.row_delay_s])
    sign = -1 if rows.opening.blackbody_is_colder else 1
    found = row_timing.solve(task.data, task.model, start=begin, signs=(sign,))
    whole, slopes = row_timing.row_functions(task.model, found.values)
    waves = harmonic_data.basis(task.angle, n_harmonics=HARMONICS)
    model = (packed(whole) @ waves).T
    residual, fraction = _residuals(task, found, model)
    scores = _scores(task, found, residual=residual, functions=(whole, slopes), waves=waves)
    covariance, widening = robust_covariance(scores[np.argsort(np.mod(task.angle, TURN))], found.normal)
    mass = light.harmonics[:, 0].real
    return RowTimingFit(
        name=rows.name,
        trigger_delay_time_set_s=rows.trigger_delay_time_set_s,
        angular_frequency_rad_per_s=rows.track.angular_frequency_rad_per_s,
        edge_delay_s=found.values[:4],
        time_constant_s=float(found.values[4]),
        row_delay_s=float(found.values[5]),
        covariance_s2=covariance,
        shape_effect=np.zeros((6, len(SHAPE_NUMBERS))),
        start_s=(float(found.start[:4].mean()), float(found.start[4]), float(found.start[5])),
        n_steps=found.n_steps,
        row_px=light.row_px,
        wheel_angle_rad=np.mod(task.angle, TURN),
        fraction=fraction / mass,
        model=model / mass,
        residual=(fraction - model) / mass,
        noise=np.std((fraction - model) / mass, axis=0),
        harmonics=whole / mass[:, None],
        gain_dn=found.gain.mean(axis=0) * mass,
        widening=widening,
        blackbody_temperature_k=rows.blackbody_temperature_k,
    )


def likelihood(rows: ReducedRecording, wheel: WheelModel, *, light: RowLight) -> Callable[[Array], Parabola]:
    """How well any six numbers (four edge delays, tau, t_row; s) fit one recording; parameters as for `fit`."""
    task = _task(rows, wheel, light)
    return lambda values: row_timing.parabola(task.data, task.model, values=values)


def scan(rows: ReducedRecording, wheel: WheelModel, *, light: RowLight, found: RowTimingFit) -> TimeConstantScan:
    """How much worse other time constants fit, four standard uncertainties to both sides, all else at its best."""
    task = _task(rows, wheel, light)
    values = np.array([*found.edge_delay_s, found.time_constant_s, found.row_delay_s])
    reach = min(_SCAN_WIDTH * float(np.sqrt(found.covariance_s2[4, 4])), 0.9 * found.time_constant_s)
    constants = found.time_constant_s + reach * np.linspace(-1, 1, _SCAN_POINTS)
    deviance = [row_timing.profile(task.data, task.model, values=values, time_constant_s=tau) for tau in constants]
    return TimeConstantScan(time_constant_s=constants, deviation=np.array(deviance) - min(deviance))


def _task(rows: ReducedRecording, wheel: WheelModel, light: RowLight) -> _Task:
    angle = wheel_angle_rad(rows.trigger_delay_time_set_s, rows.track, at_ticks=rows.trigger_ticks)
    sums = rows.row_sums.row_sum_dn[:, light.is_lit]
    stretches = [np.asarray(rows.segment == number) for number in np.unique(rows.segment)]
    return _Task(
        angle=angle,
        sums=sums,
        stretches=stretches,
        data=[harmonic_data.compress(angle[part], sums[part], n_harmonics=HARMONICS) for part in stretches],
        model=RowModel(
            open_harmonics=wheel_harmonics.open_harmonics(wheel, HARMONICS),
            row_harmonics=light.harmonics,
            row_px=light.row_px,
            angular_frequency_rad_per_s=rows.track.angular_frequency_rad_per_s,
        ),
    )


def _residuals(task: _Task, found: Solution, model: Array) -> tuple[Array, Array]:
    """Residual in DN and row sums over gain and offset, each of shape (n, n_row)."""
    residual, fraction = np.empty_like(task.sums), np.empty_like(task.sums)
    for part, gain in zip(task.stretches, found.gain, strict=True):
        expected = model[part]
        level = task.sums[part].mean(axis=0) - gain * expected.mean(axis=0)
        residual[part] = task.sums[part] - level - gain * expected
        fraction[part] = expected + residual[part] / gain
    return residual, fraction


def _scores(
    task: _Task, found: Solution, *, residual: Array, functions: tuple[ComplexArray, ComplexArray], waves: Array
) -> Array:
    """Gradient of the log-likelihood that each frame contributes, shape (n, 6); gain and offset of the rows projected out."""
    scores = np.zeros((residual.shape[0], 6))
    whole, slopes = functions
    shape = packed(whole)
    for part, data, gain in zip(task.stretches, task.data, found.gain, strict=True):
        weighted = np.ascontiguousarray((residual[part] * (gain / found.variance)).T, dtype=np.float32)
        own_waves = waves[:, part].astype(np.float32)  # seven digits are plenty for a covariance
        through = shape @ data.gram
        norm = np.einsum("yp,yp->y", through, shape)
        mean = waves[:, part].mean(axis=1)
        for k, slope in enumerate(packed(slopes)):
            free = slope - (np.einsum("yp,yp->y", through, slope) / norm)[:, None] * shape
            free[:, 0] -= free @ mean
            scores[part, k] = np.einsum("yn,yn->n", free.astype(np.float32) @ own_waves, weighted)
    return scores


def _shape_effect(
    task: _Task, found: Solution, *, functions: tuple[ComplexArray, ComplexArray], changes: ComplexArray
) -> Array:
    """Change of the six numbers per unit of each number of the sector, shape (6, 10): one linear step of the fit."""
    whole, slopes = functions
    light = task.model.row_harmonics
    moved = packed(changes * (whole / np.where(light == 0, 1, light)))
    shape, slope = packed(whole), packed(slopes)
    pull = np.zeros((6, len(changes)))
    for data, gain in zip(task.data, found.gain, strict=True):
        through = slope @ data.gram
        along = np.einsum("kyp,yp->ky", through, shape)
        beside = shape @ data.gram
        norm = np.einsum("yp,yp->y", beside, shape)
        off = np.einsum("syp,yp->sy", moved, beside)
        both = through.transpose(1, 0, 2) @ moved.transpose(1, 2, 0)
        pull -= np.tensordot(gain**2 / found.variance, both, 1) - (along / norm * gain**2 / found.variance) @ off.T
    return np.asarray(np.linalg.solve(found.normal, pull), dtype=float)
