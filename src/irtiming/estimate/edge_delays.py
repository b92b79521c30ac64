"""Fit the piecewise model to the pixel sums of one recording: one delay per wheel edge, no threshold.

Blur moves light but keeps its sum, so the sum over the opening with its whole border is exactly the exposed fraction, and
the integration window rounds its corners by a known parabola (eq. 1). The wheel angle is taken at the moment of exposure,
not at the trigger: an irregular slot or a change of speed between trigger and exposure does no harm. The fit says where the
joint fit of all recordings (`estimate.joint_fit`) begins, and which frames are wild.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares

from irtiming.errors import EstimationError
from irtiming.estimate import pixel_sum_model as model_of
from irtiming.estimate import shared_residual
from irtiming.estimate.pixel_sum_model import PixelSums
from irtiming.physics.wheel import TURN, exposed_fraction
from irtiming.records.arrays import Array
from irtiming.records.estimate import EdgeDelayFit
from irtiming.records.reduced import ReducedRecording
from irtiming.records.wheel_geometry import WheelModel

_SCAN = 240  # trial delays over a quarter turn to either side
_OUTLIER = 6.0  # times the robust standard deviation
_LEAST_WILD = 5e-4  # of the step: a frame that is less off does no harm
_NEIGHBOURS = 15
_GAP_SEARCH = 81  # delays over the scan: closer together than the shortest gap in the slots is long
_DROPPED_SHARE = 0.05
_LARGEST_SPREAD = 0.1  # of the step


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
    told, covered_dn = model_of.pixel_sums(reduced, model)
    told = _inside_track(model_of.at_one_radius(told))
    start = _scan(told)
    numbers = np.array([*[start] * 4, model.opening_angle_rad, covered_dn, told.unit_dn, 0.0, 0.0, 0.0])
    numbers, _ = _fit(told, numbers)
    residual = model_of.residual(_values(numbers, told), told)
    residual = residual - np.median(residual)  # where many are wild, the rest is shifted
    spread = 1.4826 * float(np.median(np.abs(residual)))
    if spread > _LARGEST_SPREAD:
        raise EstimationError(
            f"{reduced.name}: the pixel sums do not follow the wheel: they scatter about the model by {spread:.2g} of the step, "
            f"at most {_LARGEST_SPREAD} may be; check rig.toml and that the timestamps belong to these frames"
        )
    alone = _beside_neighbours(residual, told.angle(float(numbers[:4].mean())))
    spread = 1.4826 * float(np.median(np.abs(alone)))
    outlier = np.abs(alone) > max(_OUTLIER * spread, _LEAST_WILD)
    if outlier.mean() > _DROPPED_SHARE:
        raise EstimationError(
            f"{reduced.name}: {outlier.sum()} of {outlier.size} frames differ from their neighbours by more than {_OUTLIER:.0f} "
            f"standard deviations ({spread:.2g} of the step), at most {_DROPPED_SHARE:.0%} may; check rig.toml against the "
            "mean frame and the frames for disturbances"
        )
    kept = told.kept.copy()
    kept[np.flatnonzero(kept)[outlier]] = False
    told = replace(told, kept=kept)
    numbers, covariance = _fit(told, np.array([*[numbers[:4].mean()] * 4, *numbers[4:]]))
    return _result(told, numbers, covariance, start=start)


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


def _inside_track(told: PixelSums) -> PixelSums:
    """Leave out frames whose exposure, for any delay of the scan, may fall outside the recorded wheel or into a gap."""
    quarter_s = TURN / 4 / told.angular_frequency_rad_per_s
    trials = np.linspace(-quarter_s, quarter_s, _GAP_SEARCH)
    inside = np.all([np.isfinite(told.angle(float(trial))) for trial in trials], axis=0)
    if inside.sum() < 100:
        raise EstimationError(
            f"{told.reduced.name}: {inside.sum()} frames lie a quarter turn inside the recorded wheel, at least 100 must; "
            "record the wheel's edges from before the first to after the last frame"
        )
    return replace(told, kept=inside)


def _scan(told: PixelSums) -> float:
    """Best of a grid of delays over a quarter turn to either side: the fit needs no start value from the user."""
    quarter_s = TURN / 4 / told.angular_frequency_rad_per_s
    sums = told.sums_dn - told.sums_dn.mean()
    trials = np.linspace(-quarter_s, quarter_s, _SCAN, endpoint=False)
    fits = [exposed_fraction(told.angle(float(t)), told.wheel) for t in trials]
    match = [np.sign(told.unit_dn) * float(sums @ (f - f.mean())) / float(np.std(f)) for f in fits]
    return float(trials[int(np.argmax(match))])


def _values(numbers: Array, told: PixelSums) -> Array:
    """The model's values from four edge delays (middle of the window), opening, covered, step, drift, skew, plate."""
    delays, mean = numbers[:4], float(numbers[:4].mean())
    edges = told.angular_frequency_rad_per_s * (delays - mean)
    return np.array([mean, *numbers[5:10], *edges, numbers[4], told.reduced.integration_time_s or 0.0, 0.0, 0.0])


def _fit(told: PixelSums, start: Array) -> tuple[Array, Array]:
    """Ten numbers as for `_values` and their covariance for white residuals."""
    size = abs(told.unit_dn) * 1e-3
    scale = np.array([1e-4] * 4 + [1e-3, size, size, 1e-3, 1e-2, 1e-2])

    def misfit(numbers: Array) -> Array:
        return model_of.residual(_values(numbers, told), told)

    def derivative(numbers: Array) -> Array:
        to_all = model_of.slopes(_values(numbers, told), told)
        by_edge = to_all[:, model_of.EDGES] * told.angular_frequency_rad_per_s
        return -np.concatenate([by_edge, to_all[:, [model_of.OPENING]], to_all[:, 1:6]], axis=1)

    found = least_squares(misfit, start, jac=derivative, x_scale=scale, xtol=1e-14, ftol=1e-14)
    numbers = np.asarray(found.x)
    if not np.all(np.isfinite(numbers)) or not 0.2 < numbers[4] / told.wheel.opening_angle_rad < 5:
        raise EstimationError(
            f"{told.reduced.name}: the pixel sums do not follow the wheel: fitted opening angle "
            f"{np.degrees(numbers[4]):.2f} deg, rig.toml says {np.degrees(told.wheel.opening_angle_rad):.2f} deg; "
            "check rig.toml and that the timestamps belong to these frames"
        )
    residual, jacobian = misfit(numbers), derivative(numbers) * scale
    variance = float(residual @ residual) / (residual.size - numbers.size)
    return numbers, np.linalg.inv(jacobian.T @ jacobian) * variance * np.outer(scale, scale)


def _result(told: PixelSums, numbers: Array, covariance: Array, *, start: float) -> EdgeDelayFit:
    values = _values(numbers, told)
    half_s = (told.reduced.integration_time_s or 0.0) / 2
    angle = np.mod(told.angle(float(values[model_of.DELAY]) - half_s), TURN)
    order = np.argsort(angle)
    residual = model_of.residual(values, told) * told.unit_dn / values[model_of.STEP]
    widening = shared_residual.widening(residual[order])
    return EdgeDelayFit(
        name=told.reduced.name,
        trigger_delay_time_set_s=told.reduced.trigger_delay_time_set_s,
        angular_frequency_rad_per_s=told.angular_frequency_rad_per_s,
        edge_delay_s=numbers[:4] - half_s,
        covariance_s2=covariance[:4, :4] * widening,
        start_delay_s=start - half_s,
        wheel_angle_rad=angle[order],
        fraction=(residual + model_of.expected_fraction(values, told))[order],
        residual=residual[order],
        opening_angle_rad=float(numbers[4]),
        noise=float(np.sqrt(residual @ residual / (residual.size - numbers.size))),
        widening=widening,
        n_dropped=int(told.reduced.trigger_ticks.size - told.kept.sum()),
        kept=told.kept,
        values=values,
    )
