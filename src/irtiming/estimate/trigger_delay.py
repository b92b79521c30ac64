"""From the edge delays of all recordings to the trigger delay and the relative delays, with their covariance.

Edge i of recording f gives the delay  y_fi = t_delay + (e + e_i) / omega_f + noise_fi:  the angle errors e (mask, gates,
slots) and e_i (cutout edge i) stay the same from recording to recording, so they are common to all delays of one wheel
speed and shrink with another. All y_fi are combined by generalised least squares with just this covariance. With several
speeds the angle errors drop out by themselves.
"""

import numpy as np

from irtiming.errors import EstimationError
from irtiming.estimate import rig_wide, shared_residual
from irtiming.estimate.wheel_geometry import WheelGeometry
from irtiming.records.arrays import Array
from irtiming.records.estimate import Contribution, DelayResult, EdgeDelayFit, Estimate, RelativeDelay

_FALLING = (0, 2)
_RISING = (1, 3)
_SUSPICIOUS_BIRGE = 2.0
_RUNS_THAT_TELL = 4


def estimate(fits: list[EdgeDelayFit], geometry: WheelGeometry, *, integration_time_s: float | None) -> DelayResult:
    """Trigger delay, midpoint delay, and the delays by falling and by rising edges.

    Parameters
    ----------
    fits
        One per recording.
    geometry
        The wheel model that the fits used, and the uncertainties of its angles.
    integration_time_s
        None where the recordings do not tell: then the fits gave the middle of the window and no start is reported.

    Raises
    ------
    EstimationError
        If two recordings differ by more than their uncertainties can explain by far.
    """
    delays = np.concatenate([fit.edge_delay_s for fit in fits])
    per_rad = np.repeat([1 / fit.angular_frequency_rad_per_s for fit in fits], 4)
    u_edge = rig_wide.edge_uncertainty(fits, geometry)
    parts = _covariances(fits, geometry, per_rad, u_edge)
    total = np.sum([covariance for _, _, covariance in parts], axis=0)
    weights = np.stack([_weights(total, edges) for edges in ((0, 1, 2, 3), _FALLING, _RISING)])
    values, covariance = weights @ delays, weights @ total @ weights.T
    names = ("trigger_delay", "exposure_midpoint_delay", "trigger_delay_falling", "trigger_delay_rising")
    middle = np.array([[1.0, 0, 0], [1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]])
    half = np.array([0.0, 0.5, 0.0, 0.0]) * (integration_time_s or 0.0)
    keep = [0, 1, 2, 3] if integration_time_s is not None else [1]
    budget = [
        Contribution(source=source, kind=kind, standard_uncertainty_s=float(np.sqrt(weights[0] @ part @ weights[0])))
        for source, kind, part in parts
    ]
    mean = np.mean([fit.edge_delay_s for fit in fits], axis=0)
    noise = np.sqrt(np.mean([np.diag(fit.covariance_s2) for fit in fits], axis=0) / len(fits))
    return DelayResult(
        method="pixel-sum",
        estimate=Estimate(
            names=tuple(names[k] for k in keep),
            values=(middle @ values + half)[keep],
            covariance=(middle @ covariance @ middle.T)[np.ix_(keep, keep)],
        ),
        relative_delays=_relative(fits, total),
        budget=tuple(budget),
        edge_delay_s=mean,
        u_edge_delay_s=noise,
        warnings=geometry.warnings + _doubts(values[0], u_edge) + _remarks(fits),
    )


def _covariances(
    fits: list[EdgeDelayFit], geometry: WheelGeometry, per_rad: Array, u_edge_rad: float
) -> list[tuple[str, str, Array]]:
    """Covariance of all edge delays, shape (4 n_fit, 4 n_fit), s^2, part by part."""
    n = per_rad.size
    found = shared_residual.split(fits)
    noise = np.zeros((n, n))
    for k, (own, factor) in enumerate(zip(found.noise_s2, _run_to_run(fits), strict=True)):
        noise[4 * k : 4 * k + 4, 4 * k : 4 * k + 4] = own * factor
    shared = np.tile(found.shared_rad2, (len(fits), len(fits))) * np.outer(per_rad, per_rad)
    same_edge = np.equal.outer(np.arange(n) % 4, np.arange(n) % 4)
    parts = [
        ("noise of the frames", "A", noise),
        ("structure of the residuals common to all recordings", "A", shared),
        (
            "cutout edges",
            "A" if geometry.u_edge_rad is None else "B",
            u_edge_rad**2 * np.outer(per_rad, per_rad) * same_edge,
        ),
    ]
    parts += [(source, kind, u**2 * np.outer(per_rad, per_rad)) for source, kind, u in geometry.angle_budget]
    return parts


def _weights(total: Array, edges: tuple[int, ...]) -> Array:
    """Weights of the generalised mean over the named edges, shape (4 n_fit,), sum 1."""
    used = np.flatnonzero(np.isin(np.arange(len(total)) % 4, edges))
    part = total[np.ix_(used, used)]
    ridge = 1e-13 * np.trace(part) / used.size * np.eye(used.size)  # a recording given twice has no noise of its own
    solved = np.linalg.solve(part + ridge, np.ones(used.size))
    weights = np.zeros(len(total))
    weights[used] = solved / solved.sum()
    return weights


def _relative(fits: list[EdgeDelayFit], total: Array) -> tuple[RelativeDelay, ...]:
    """Delay of each recording minus the mean of those with the smallest set delay, including what was set."""
    mean_edge = np.kron(np.eye(len(fits)), np.full((1, 4), 0.25))
    values = np.concatenate([fit.edge_delay_s for fit in fits])
    return rig_wide.relative_delays(fits, mean_edge, values=values, total=total)


def _doubts(delay_s: float, u_edge_rad: float) -> tuple[str, ...]:
    """Doubts about the rig's description: a camera that exposes before its trigger, edges that cannot be so far off."""
    doubts = []
    if delay_s < 0:
        doubts.append(
            f"the trigger delay is negative ({1e3 * delay_s:.3f} ms): integration would start before the trigger; check [beams] "
            "whole_slots_between, [mask] centre_angle_deg and the trigger's edge"
        )
    return (*doubts, *rig_wide.edge_doubts(u_edge_rad))


def _remarks(fits: list[EdgeDelayFit]) -> tuple[str, ...]:
    """Doubts about the fits themselves: outliers, correlated residuals, recordings that disagree."""
    remarks = [
        f"{fit.name}: {fit.n_dropped} frames left out as outliers or at the ends" for fit in fits if fit.n_dropped
    ]
    widened = [fit.widening**0.5 for fit in fits if fit.widening > _SUSPICIOUS_BIRGE]
    if widened:
        remarks.append(
            f"residuals of {len(widened)} of {len(fits)} recordings are correlated along the wheel angle: the rig differs from "
            f"the model by more than noise (figure of the residuals); their uncertainty was widened by up to {max(widened):.1f}"
        )
    remarks += _birge_remark(fits)
    return tuple(remarks)


def _birge_ratio(group: list[EdgeDelayFit]) -> float:
    """Scatter of the delays of recordings at one speed over what their own noise explains."""
    delay = np.array([fit.edge_delay_s.mean() for fit in group])
    variance = np.array([fit.covariance_s2.mean() for fit in group])
    mean = np.average(delay, weights=1 / variance)
    birge = float(np.sqrt(np.sum((delay - mean) ** 2 / variance) / (len(group) - 1)))
    if not np.isfinite(birge):
        raise EstimationError(
            f"the delays of {len(group)} recordings have no finite scatter: {delay}; check the frames"
        )
    return birge


def _run_to_run(fits: list[EdgeDelayFit]) -> Array:
    """Factor on the noise covariance of each fit, shape (n_fit,): the Birge ratio squared where it exceeds 1.

    Only where four or more recordings at one speed tell it: fewer say little about their scatter.
    """
    factor = np.ones(len(fits))
    for _, members in rig_wide.by_speed(fits):
        if len(members) >= _RUNS_THAT_TELL:
            factor[members] = max(1.0, _birge_ratio([fits[k] for k in members]) ** 2)
    return factor


def _birge_remark(fits: list[EdgeDelayFit]) -> list[str]:
    """A doubt where recordings at the same speed scatter far more than their own uncertainties say."""
    remarks = []
    for speed, members in rig_wide.by_speed(fits):
        if len(members) < 2:
            continue
        birge = _birge_ratio([fits[k] for k in members])
        if birge > 1 + _SUSPICIOUS_BIRGE / np.sqrt(2 * (len(members) - 1)):
            remarks.append(
                f"{len(members)} recordings at {speed:.4g} Hz scatter {birge:.2f} times more than their noise explains "
                "(Birge ratio); something changed between them"
            )
    return remarks
