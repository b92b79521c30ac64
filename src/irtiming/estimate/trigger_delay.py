"""The default method for a snapshot photon camera: from the fits of single recordings to one likelihood over all of them.

The joint fit (`estimate.joint_fit`) gives the middle of the integration window; its start is half the integration time
earlier. The integration time is that which the recording states, if it does; what the rounded corners of the sums say of it is
reported beside it and stands in where none is stated.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.estimate import joint_delays as linear
from irtiming.estimate import joint_fit, joint_profile, rig_wide, shared_residual, whiteness
from irtiming.estimate.joint_delays import AnglePart, Told
from irtiming.records.arrays import Array, Ticks
from irtiming.records.estimate import Contribution, DelayResult, EdgeDelayFit, Estimate
from irtiming.records.joint_fit import JointFit
from irtiming.records.reduced import ReducedRecording
from irtiming.records.wheel_geometry import WheelGeometry

_SUSPICIOUS_BIRGE = 2.0
_RUNS_THAT_TELL = 4
_SHORTEST_SHOWN = 2.0  # standard uncertainties: a window that is shorter is not told from none
_SPEED_RATIO = 1.2  # of the wheel, from which it tells a window from mask edges that round the corners as well
_CONTRADICTS = 4.0  # standard uncertainties
_CORNER_RAD = 4.5e-3  # what rounds the corners besides the window and is not in the model, as simulated rigs showed
_WINDOW_SHARE = (
    0.02  # of its length: by how much windows from 50 us to 1 ms came out wrong on simulated rigs, cause unknown
)
_NOT_WHITE = 1e-4  # probability
_NAMES = (
    "trigger_delay",
    "exposure_midpoint_delay",
    "trigger_delay_falling",
    "trigger_delay_rising",
    "integration_time",
)
_LEAST_SHARE = 1e-4


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SnapshotTiming:
    """Result and the joint fit that led to it."""

    result: DelayResult
    joint: JointFit


def estimate(
    recordings: Sequence[ReducedRecording], fits: Sequence[EdgeDelayFit], *, geometry: WheelGeometry,
    integration_time_s: float | None,
) -> SnapshotTiming:  # fmt: skip
    """Trigger delay, midpoint delay, delays by falling and by rising edges, integration time.

    Parameters
    ----------
    recordings, fits
        In the same order.
    geometry
        The wheel model that the fits used, and the uncertainties of its angles.
    integration_time_s
        None where the recordings do not tell: then it is what the corners of the sums say.

    Raises
    ------
    EstimationError
        If the recordings cannot be those of one camera.
    """
    angles, factor = angle_parts(fits, geometry)
    noise = np.array([fit.noise * np.sqrt(fit.widening) for fit in fits]) * np.sqrt(factor)
    given = joint_fit.problem(recordings, fits, geometry=geometry, noise=noise, prior_rad2=linear.total_rad2(angles))
    found = joint_fit.search(given, joint_fit.begin(given, fits))
    image, image_pull = given.image(found.shared)
    told = Told(
        shared=found.shared, information=found.information, pull=found.pull, image=image, image_pull=image_pull,
        angles=angles, angular_frequency_rad_per_s=np.array([fit.angular_frequency_rad_per_s for fit in fits]),
    )  # fmt: skip
    result = combine(
        fits, geometry, told=told, integration_time_s=integration_time_s, is_window_told=not found.is_shape_held
    )
    joint = JointFit(
        shared=found.shared,
        covariance=joint_fit.covariance(given, found),
        start=found.start,
        prior_covariance_rad2=given.prior_rad2,
        information=found.information,
        pull=found.pull,
        reduced_chi_square=found.deviance / max(1, sum(fit.residual.size - 6 for fit in fits)),
        birge=_disagreement(told),
        whiteness=np.array([whiteness.probability(fit.residual) for fit in fits]),
        n_steps=found.n_steps,
        profiles=joint_profile.profiles(given, found, estimate=result.estimate, integration_time_s=integration_time_s),
    )
    return SnapshotTiming(result=replace(result, warnings=result.warnings + _doubts_about_the_fit(joint)), joint=joint)


def combine(
    fits: Sequence[EdgeDelayFit],
    geometry: WheelGeometry,
    *,
    told: Told,
    integration_time_s: float | None,
    is_window_told: bool = True,
) -> DelayResult:
    """The result by linear algebra at the minimum.

    Parameters
    ----------
    fits, geometry
        As for `estimate`.
    told
        What the joint fit says.
    integration_time_s
        As stated by the recordings; None where they do not.
    is_window_told
        False where the length of the window was held in the fit.
    """
    shared = linear.shared_delays(told)
    fastest, slowest = (pick(fit.angular_frequency_rad_per_s for fit in fits) for pick in (max, min))
    window = _Window(
        length_s=float(shared.values[3]),
        u_s=_u_window_s(shared, fastest),
        stated_s=integration_time_s,
        is_told=is_window_told and fastest > _SPEED_RATIO * slowest,
    )
    estimate, in_window = _measurands(shared, window)
    each, each_covariance = linear.each_delay(told, setting=_settings(fits))
    n_frames = sum(fit.residual.size - 10 for fit in fits)
    noise = np.sqrt(np.mean([np.diag(fit.covariance_s2) for fit in fits], axis=0) / len(fits))
    return DelayResult(
        method="pixel-sum",
        estimate=estimate,
        relative_delays=rig_wide.relative_delays(fits, np.eye(len(fits)), values=each, total=each_covariance),
        budget=(*linear.budget(told, degrees_of_freedom=float(n_frames)), *in_window),
        edge_delay_s=np.mean([fit.edge_delay_s for fit in fits], axis=0),
        u_edge_delay_s=noise,
        warnings=geometry.warnings
        + _doubts(float(estimate.values[0]), rig_wide.edge_uncertainty(fits, geometry))
        + _window_doubts(window)
        + _angle_doubts(shared, told.prior_rad2)
        + _remarks(fits),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Window:
    """Length of the window as the corners tell it, as the recordings state it, and whether several speeds tell it at all."""

    length_s: float
    u_s: float
    stated_s: float | None
    is_told: bool

    @property
    def is_seen(self) -> bool:
        """Whether it is told from none."""
        return self.is_told and self.length_s > _SHORTEST_SHOWN * self.u_s


def _u_window_s(shared: linear.SharedDelays, fastest_rad_per_s: float) -> float:
    """Standard uncertainty of the window: what the fit says, and what rounds corners that the model does not have."""
    alone = float(np.sqrt(shared.covariance[3, 3]))
    unknown = _CORNER_RAD**2 / (2 * max(float(shared.values[3]), alone) * fastest_rad_per_s**2)
    return float(np.linalg.norm([alone, unknown, _WINDOW_SHARE * float(shared.values[3])]))


def _measurands(shared: linear.SharedDelays, window: _Window) -> tuple[Estimate, tuple[Contribution, ...]]:
    """What is reported, and what the window's length adds to the budget of the trigger delay."""
    mix = np.array([[1.0, 0, 0, -0.5], [1, 0, 0, 0], [0, 1, 0, -0.5], [0, 0, 1, -0.5], [0, 0, 0, 1]])
    offset = np.zeros(5)
    if window.stated_s is not None:
        mix[[0, 2, 3], 3] = 0.0
        offset[[0, 2, 3]] = -window.stated_s / 2
    keep = [0, 1, 2, 3, 4] if window.is_seen else [0, 1, 2, 3] if window.stated_s is not None else [1]
    told = shared.covariance.copy()
    told[3, 3] = window.u_s**2
    values, covariance = mix @ shared.values + offset, mix @ told @ mix.T
    in_window = (
        ()
        if window.stated_s is not None or not window.is_seen
        else (Contribution(source="length of the window (corners)", kind="A", standard_uncertainty_s=window.u_s / 2),)
    )
    names = tuple(_NAMES[k] for k in keep)
    return Estimate(
        names=names, units=("s",) * len(names), values=values[keep], covariance=covariance[np.ix_(keep, keep)]
    ), in_window


def angle_parts(fits: Sequence[EdgeDelayFit], geometry: WheelGeometry) -> tuple[tuple[AnglePart, ...], Array]:
    """Why edges may not be where they are drawn, and by how much the fits' own covariances are not their noise.

    Parameters
    ----------
    fits
        One per recording.
    geometry
        What is known of the angles.

    Returns
    -------
    The parts, and factors on the variances, shape (n_fit,): less where the residuals are common to all recordings, more where
    recordings scatter more than they should.
    """
    split = shared_residual.split(list(fits))
    share = np.array([own[0, 0] / fit.covariance_s2[0, 0] for own, fit in zip(split.noise_s2, fits, strict=True)])
    share = np.maximum(share, _LEAST_SHARE)  # a recording given twice has no noise of its own
    u_edge = rig_wide.edge_uncertainty(fits, geometry)
    parts = [
        AnglePart(
            source="structure of the residuals common to all recordings", kind="A", covariance_rad2=split.shared_rad2
        ),
        AnglePart(
            source="cutout edges",
            kind="A" if geometry.u_edge_rad is None else "B",
            covariance_rad2=u_edge**2 * np.eye(4),
        ),
    ]
    parts += [
        AnglePart(source=source, kind=kind, covariance_rad2=np.full((4, 4), u**2))
        for source, kind, u in geometry.angle_budget
    ]
    return tuple(parts), share * _run_to_run(fits)


def _settings(fits: Sequence[EdgeDelayFit]) -> Ticks:
    """Number of each recording's set delay."""
    return np.unique(np.round([fit.trigger_delay_time_set_s for fit in fits], 9), return_inverse=True)[1].astype(
        np.int64
    )


def _disagreement(told: Told) -> float:
    """Square root of the deviance of the recordings' delays about the common one, over its degrees of freedom; 1 expected."""
    each, covariance = linear.each_delay(told, setting=np.zeros(len(told.pull), np.int64))
    if each.size < 2:
        return 1.0
    ones = np.ones(each.size)
    through = np.linalg.solve(covariance, np.stack([ones, each], axis=1))
    mean = float(ones @ through[:, 1]) / float(ones @ through[:, 0])
    apart = each - mean
    return float(np.sqrt(apart @ np.linalg.solve(covariance, apart) / (each.size - 1)))


def _window_doubts(window: _Window) -> tuple[str, ...]:
    if (
        not window.is_seen
        or window.stated_s is None
        or abs(window.length_s - window.stated_s) <= _CONTRADICTS * window.u_s
    ):
        return ()
    return (
        f"the corners of the sums say {1e6 * window.length_s:.1f} us of integration (u = {1e6 * window.u_s:.1f} us), their "
        f"count_time says {1e6 * window.stated_s:.1f} us; trigger_delay counts on the latter, exposure_midpoint_delay on neither",
    )


def _angle_doubts(shared: linear.SharedDelays, prior_rad2: Array) -> tuple[str, ...]:
    """A doubt where several wheel speeds find the edges' common angle far from where rig.toml allows it."""
    found, allowed = float(shared.edge_angles_rad.mean()), float(np.sqrt(prior_rad2.mean()))
    if abs(found) <= _CONTRADICTS * allowed:
        return ()
    return (
        f"the wheel speeds agree on edges that come {1e3 * found:+.2f} mrad early, rig.toml allows u = {1e3 * allowed:.2f} "
        "mrad; check [mask] centre_angle_deg and [beams]",
    )


def _doubts_about_the_fit(joint: JointFit) -> tuple[str, ...]:
    doubts, white = [], joint.whiteness
    moved = abs(joint.shared[joint_fit.T_MIDDLE] - joint.start[joint_fit.T_MIDDLE])
    if joint.n_steps < 2 and moved == 0:
        doubts.append("the joint fit did not leave its start value: nothing in the recordings moved it")
    if np.any(white < _NOT_WHITE):
        doubts.append(
            f"residuals of {int(np.sum(white < _NOT_WHITE))} of {white.size} recordings are not white along the wheel angle "
            f"(smallest probability {white.min():.1g}); their uncertainty is widened for it"
        )
    return tuple(doubts)


def _doubts(delay_s: float, u_edge_rad: float) -> tuple[str, ...]:
    """Doubts about the rig's description: a camera that exposes before its trigger, edges that cannot be so far off."""
    doubts = []
    if delay_s < 0:
        doubts.append(
            f"the trigger delay is negative ({1e3 * delay_s:.3f} ms): integration would start before the trigger; check [beams] "
            "whole_slots_between, [mask] centre_angle_deg and the trigger's edge"
        )
    return (*doubts, *rig_wide.edge_doubts(u_edge_rad))


def _remarks(fits: Sequence[EdgeDelayFit]) -> tuple[str, ...]:
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


def _run_to_run(fits: Sequence[EdgeDelayFit]) -> Array:
    """Factor on the noise covariance of each fit, shape (n_fit,): the Birge ratio squared where it exceeds 1.

    Only where four or more recordings at one speed tell it: fewer say little about their scatter.
    """
    factor = np.ones(len(fits))
    for _, members in rig_wide.by_speed(fits):
        if len(members) >= _RUNS_THAT_TELL:
            factor[members] = max(1.0, _birge_ratio([fits[k] for k in members]) ** 2)
    return factor


def _birge_remark(fits: Sequence[EdgeDelayFit]) -> list[str]:
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
