"""Fit the piecewise model to the pixel sums of one recording: one delay per wheel edge, no threshold.

Blur moves light but keeps its sum, so the sum over the opening with its whole border is exactly the exposed fraction, and
the integration window rounds its corners by a known parabola (eq. 1). The wheel angle is taken at the moment of exposure,
not at the trigger: an irregular slot or a change of speed between trigger and exposure does no harm.
"""

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy.optimize import least_squares

from irtiming.errors import EstimationError
from irtiming.estimate import shared_residual
from irtiming.physics.wheel import EDGE_SIGNS, TURN, WheelModel, edge_in_opening, exposed_fraction, skewed_fraction
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Array, Mask
from irtiming.records.estimate import EdgeDelayFit
from irtiming.records.reduced import ReducedRecording

_SCAN = 240  # trial delays over a quarter turn to either side
_OUTLIER = 6.0  # times the robust standard deviation
_LEAST_WILD = 5e-4  # of the step: a frame that is less off does no harm
_NEIGHBOURS = 15
_GAP_SEARCH = 81  # delays over the scan: closer together than the shortest gap in the slots is long
_DROPPED_SHARE = 0.05
_LARGEST_SPREAD = 0.1  # of the step
_SMALLEST_WIDTH_RAD = 1e-3
_BORDER_RAD = 0.1  # where the axle was not found in the image


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Problem:
    """Pixel sums, the angle of each frame's trigger, and a first guess of the sum when covered and of the step."""

    reduced: ReducedRecording
    model: WheelModel
    sweep_rad: float
    kept: Mask
    time: Array
    covered_dn: float
    step_dn: float
    border_rad: float

    def angle(self, delay_s: float) -> Array:
        """Wheel angle of the kept frames this long after the trigger and the delay set, rad."""
        delay = delay_s + self.reduced.trigger_delay_time_set_s
        return wheel_angle_rad(delay, self.reduced.track, at_ticks=self.reduced.trigger_ticks[self.kept])

    @property
    def sums(self) -> Array:
        """Pixel sums of the kept frames, DN."""
        return self.reduced.pixel_sum[self.kept]


def estimate(reduced: ReducedRecording, model: WheelModel) -> EdgeDelayFit:
    """Delay of the start of integration as seen from each of the four wheel edges.

    Parameters
    ----------
    reduced
        One recording.
    model
        Wheel and opening; its edge angles are where a zero delay would be.

    Returns
    -------
    Where the recording does not tell the integration time, the delays are those of the window's middle.

    Raises
    ------
    EstimationError
        If the sums do not follow the model, or too many frames are outliers.
    """
    omega = reduced.track.angular_frequency_rad_per_s
    ticks = reduced.trigger_ticks
    covered, step = _levels(reduced)
    problem = _Problem(
        reduced=reduced,
        model=model,
        sweep_rad=omega * (reduced.integration_time_s or 0.0),
        kept=np.ones(ticks.size, bool),
        time=(ticks - ticks.mean()) / max(1.0, float(np.ptp(ticks))),
        covered_dn=covered,
        step_dn=step,
        border_rad=_border(reduced),
    )
    problem = _inside_track(problem, omega)
    start = _scan(problem)
    values, _, _ = _fit(problem, start, model.opening_angle_rad)
    residual = _misfit(values, problem)
    residual = residual - np.median(residual)  # where many are wild, the rest is shifted
    spread = 1.4826 * float(np.median(np.abs(residual)))
    if spread > _LARGEST_SPREAD:
        raise EstimationError(
            f"{reduced.name}: the pixel sums do not follow the wheel: they scatter about the model by {spread:.2g} of the step, "
            f"at most {_LARGEST_SPREAD} may be; check rig.toml and that the timestamps belong to these frames"
        )
    alone = _beside_neighbours(residual, problem.angle(float(values[:4].mean())))
    spread = 1.4826 * float(np.median(np.abs(alone)))
    outlier = np.abs(alone) > max(_OUTLIER * spread, _LEAST_WILD)
    if outlier.mean() > _DROPPED_SHARE:
        raise EstimationError(
            f"{reduced.name}: {outlier.sum()} of {outlier.size} frames differ from their neighbours by more than {_OUTLIER:.0f} "
            f"standard deviations ({spread:.2g} of the step), at most {_DROPPED_SHARE:.0%} may; check rig.toml against the "
            "mean frame and the frames for disturbances"
        )
    kept = problem.kept.copy()
    kept[np.flatnonzero(kept)[outlier]] = False
    problem = replace(problem, kept=kept)
    values, covariance, residual = _fit(problem, float(values[:4].mean()), float(values[4]))
    return _result(problem, values, covariance, residual, start=start)


def _beside_neighbours(residual: Array, angle: Array) -> Array:
    """Residuals less what their neighbours along the wheel angle foretell: a frame that is wild, not a model that is coarse.

    The median of the means of pairs to both sides follows a slope, and does not hold the frame itself.
    """
    order = np.argsort(np.mod(angle, TURN))
    sorted_by_angle = residual[order]
    pairs = [(np.roll(sorted_by_angle, k) + np.roll(sorted_by_angle, -k)) / 2 for k in range(1, _NEIGHBOURS // 2 + 1)]
    alone = np.empty_like(residual)
    alone[order] = sorted_by_angle - np.median(pairs, axis=0)
    return alone


def _border(reduced: ReducedRecording) -> float:
    """Angle about the axle of the border by which the summed region exceeds the opening, rad."""
    if reduced.axle is None:
        return _BORDER_RAD
    rows, columns = np.nonzero(reduced.opening.mask)
    radius = np.hypot(rows - reduced.axle.row_px, columns - reduced.axle.column_px).mean()
    return float(np.clip(reduced.opening.border_px / radius, 1e-2, 0.3))


def _levels(reduced: ReducedRecording) -> tuple[float, float]:
    """First guess of the sum when covered and of the signed step to open, DN."""
    low, high = (float(v) for v in np.quantile(reduced.pixel_sum, [0.03, 0.97]))
    hot = reduced.opening.peaks_dn[1] > reduced.opening.peaks_dn[0]
    return (low, high - low) if hot else (high, low - high)


def _inside_track(problem: _Problem, omega: float) -> _Problem:
    """Leave out frames whose exposure, for any delay of the scan, may fall outside the recorded wheel or into a gap."""
    quarter_s = TURN / 4 / omega
    trials = np.linspace(-quarter_s, quarter_s, _GAP_SEARCH)
    inside = np.all([np.isfinite(problem.angle(float(trial))) for trial in trials], axis=0)
    if inside.sum() < 100:
        raise EstimationError(
            f"{problem.reduced.name}: {inside.sum()} frames lie a quarter turn inside the recorded wheel, at least 100 must; "
            "record the wheel's edges from before the first to after the last frame"
        )
    return replace(problem, kept=inside)


def _scan(problem: _Problem) -> float:
    """Best of a grid of delays over a quarter turn to either side: the fit needs no start value from the user."""
    quarter_s = TURN / 4 / problem.reduced.track.angular_frequency_rad_per_s
    sums = problem.sums - problem.sums.mean()
    sign = np.sign(problem.reduced.opening.peaks_dn[1] - problem.reduced.opening.peaks_dn[0])
    trials = np.linspace(-quarter_s, quarter_s, _SCAN, endpoint=False)
    half = 0.5 * problem.sweep_rad  # the middle of the window will do here
    fits = [exposed_fraction(problem.angle(float(t)) + half, problem.model) for t in trials]
    match = [sign * float(sums @ (f - f.mean())) / float(np.std(f)) for f in fits]
    return float(trials[int(np.argmax(match))])


def _shifted(values: Array, problem: _Problem) -> tuple[WheelModel, float]:
    """Model whose edges come as much earlier as the edge delays differ from their mean, and that mean."""
    mean = float(values[:4].mean())
    omega = problem.reduced.track.angular_frequency_rad_per_s
    earlier = omega * (values[:4] - mean)
    edges = tuple(float(e - d) for e, d in zip(problem.model.cutout_edges_rad, earlier, strict=True))
    shifted = replace(
        problem.model,
        cutout_edges_rad=(edges[0], edges[1], edges[2], edges[3]),
        opening_angle_rad=max(float(values[4]), _SMALLEST_WIDTH_RAD),
    )
    return shifted, mean


def _expected(values: Array, problem: _Problem) -> Array:
    shifted, mean = _shifted(values, problem)
    angle = problem.angle(mean)
    fraction, skewed, plate = _shapes(angle, shifted, problem)
    return fraction + values[8] * skewed + values[9] * plate


def _shapes(angle: Array, model: WheelModel, problem: _Problem) -> tuple[Array, Array, Array]:
    """Exposed fraction of the even opening, and what a skewed opening and a shining mask plate add to it.

    A plate that is not as warm as the wheel shows around the opening while a cutout passes: an opening that is wider by the
    summed border.
    """
    fraction = exposed_fraction(angle, model, sweep_rad=problem.sweep_rad)
    wider = replace(model, opening_angle_rad=model.opening_angle_rad + 2 * problem.border_rad)
    plate = exposed_fraction(angle, wider, sweep_rad=problem.sweep_rad) - fraction
    return fraction, skewed_fraction(angle, model, sweep_rad=problem.sweep_rad), plate


def _misfit(values: Array, problem: _Problem) -> Array:
    """Sums minus model, in units of the guessed step: a fitted one would let the misfit vanish by growing."""
    fraction = _expected(values, problem) + values[7] * problem.time[problem.kept]
    return (problem.sums - values[5] - values[6] * fraction) / problem.step_dn


def _derivative(values: Array, problem: _Problem) -> Array:
    """Analytic derivatives of the misfit, shape (n, 10); skew and plate are small and taken as even in the others."""
    shifted, mean = _shifted(values, problem)
    angle, gamma = problem.angle(mean), shifted.opening_angle_rad
    omega = problem.reduced.track.angular_frequency_rad_per_s
    crossing = edge_in_opening(angle, shifted, sweep_rad=problem.sweep_rad)
    step = values[6] / problem.step_dn
    columns = [-step * s * omega / gamma * c for s, c in zip(EDGE_SIGNS, crossing, strict=True)]
    half = 0.5 * problem.sweep_rad
    fraction, skewed, plate = _shapes(angle, shifted, problem)
    ends = 0.5 * (_open_share(angle + half, shifted, 1) + _open_share(angle + half, shifted, -1))
    columns.append(step * (fraction - ends) / gamma)
    time = problem.time[problem.kept]
    columns += [
        np.full(angle.size, -1 / problem.step_dn),
        -(fraction + values[7] * time + values[8] * skewed + values[9] * plate) / problem.step_dn,
        -step * time,
        -step * skewed,
        -step * plate,
    ]
    return np.stack(columns, axis=1)


def _open_share(angle: Array, model: WheelModel, side: int) -> Array:
    """Whether the radial edge of the mask on one side is uncovered: the fraction of a vanishingly narrow opening there."""
    edge = replace(
        model,
        opening_angle_rad=_SMALLEST_WIDTH_RAD,
        centre_angle_rad=model.centre_angle_rad - side * model.opening_angle_rad / 2,
    )
    return exposed_fraction(angle, edge)


def _fit(problem: _Problem, start_s: float, opening_angle_rad: float) -> tuple[Array, Array, Array]:
    """Values, covariance (for white residuals) and residuals. Edge delays are scaled by the quarter turn."""
    step = problem.step_dn
    initial = np.array([start_s] * 4 + [opening_angle_rad, problem.covered_dn, step, 0.0, 0.0, 0.0])
    scale = np.array([1e-4] * 4 + [1e-3, abs(step) * 1e-3, abs(step) * 1e-3, 1e-3, 1e-2, 1e-2])
    found = least_squares(_misfit, initial, jac=_derivative, x_scale=scale, args=(problem,), xtol=1e-14, ftol=1e-14)
    values = np.asarray(found.x)
    if not np.all(np.isfinite(values)) or not 0.2 < values[4] / problem.model.opening_angle_rad < 5:
        raise EstimationError(
            f"{problem.reduced.name}: the pixel sums do not follow the wheel: fitted opening angle "
            f"{np.degrees(values[4]):.2f} deg, rig.toml says {np.degrees(problem.model.opening_angle_rad):.2f} deg; "
            "check rig.toml and that the timestamps belong to these frames"
        )
    residual = _misfit(values, problem)
    jacobian = _derivative(values, problem) * scale
    variance = float(residual @ residual) / (residual.size - values.size)
    covariance = np.linalg.inv(jacobian.T @ jacobian) * variance * np.outer(scale, scale)
    return values, covariance, residual


def _result(problem: _Problem, values: Array, covariance: Array, residual: Array, *, start: float) -> EdgeDelayFit:
    angle = np.mod(problem.angle(float(values[:4].mean())), TURN)
    order = np.argsort(angle)
    residual = residual * problem.step_dn / values[6]
    widening = shared_residual.widening(residual[order])
    return EdgeDelayFit(
        name=problem.reduced.name,
        trigger_delay_time_set_s=problem.reduced.trigger_delay_time_set_s,
        angular_frequency_rad_per_s=problem.reduced.track.angular_frequency_rad_per_s,
        edge_delay_s=values[:4],
        covariance_s2=covariance[:4, :4] * widening,
        start_delay_s=start,
        wheel_angle_rad=angle[order],
        fraction=(residual + _expected(values, problem))[order],
        residual=residual[order],
        opening_angle_rad=float(values[4]),
        noise=float(np.sqrt(residual @ residual / (residual.size - values.size))),
        widening=widening,
        n_dropped=int(problem.reduced.trigger_ticks.size - problem.kept.sum()),
    )
