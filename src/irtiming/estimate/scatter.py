"""By how much recordings differ, over what their noise explains: between edges, between runs, and along the wheel angle."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy import special

from irtiming.errors import EstimationError
from irtiming.estimate import by_speed
from irtiming.records.arrays import Array
from irtiming.records.estimate import EDGE_DELAYS, EdgeDelayFit, Estimate, RecordingFit
from irtiming.records.finding import Finding
from irtiming.records.reduced import ReducedRecording
from irtiming.records.wheel_geometry import WheelGeometry

_T_FACTOR = 3.0  # nu / (nu - 2) with the 3 degrees of freedom of four edges (JCGM 101, 6.4.9)
_ENOUGH_RUNS = 4
_SUSPICIOUS = 2.0  # standard deviations of a Birge ratio
_SIGNIFICANCE = 1e-6  # that recordings scatter as much: once in the life of all laboratories
_CAMERA = ("time_constant", "row_delay")  # of the local numbers, beside the delay: what runs may differ in


@final
@dataclass(frozen=True, kw_only=True)
class Alike:
    """Recordings that should agree: the wheel's rate, and the indices of their fits."""

    speed_hz: float
    members: list[int]


def edge_uncertainty(fits: Sequence[RecordingFit], geometry: WheelGeometry) -> float:
    """Standard uncertainty of one cutout edge, rad: as stated, else from the scatter of the four edges.

    Parameters
    ----------
    fits
        One per recording.
    geometry
        What rig.toml states.

    Notes
    -----
    The four edges of a perfect wheel would give one delay. Their scatter, with 3 degrees of freedom, is that of the cutout
    edges against the ring (plus noise, which is small beside it).
    """
    if geometry.u_edge_rad is not None:
        return geometry.u_edge_rad
    angles = np.mean([_delays(fit) * fit.angular_frequency_rad_per_s for fit in fits], axis=0)
    return float(np.sqrt(_T_FACTOR * np.var(angles, ddof=1)))


def alike(fits: Sequence[RecordingFit], blackbodies: Sequence[Sequence[int]]) -> list[Alike]:
    """Fits of one wheel rate and blackbody, for each such pair.

    Parameters
    ----------
    fits
        One per recording.
    blackbodies
        Indices of the fits before each blackbody.
    """
    speeds_hz = [fit.angular_frequency_rad_per_s / (2 * np.pi) for fit in fits]
    return [
        Alike(speed_hz=round(float(np.mean([speeds_hz[k] for k in same])), 2), members=both)
        for same in by_speed.groups(speeds_hz)
        for group in blackbodies
        if (both := [k for k in same if k in group])
    ]


def birge_ratio(group: Sequence[RecordingFit]) -> float:
    """Scatter of what single recordings find of the camera, over what their own noise explains; 1 where it explains all.

    Parameters
    ----------
    group
        Fits of recordings that should agree, two or more.

    Raises
    ------
    EstimationError
        If they have no finite scatter.
    """
    found = [_of_camera(fit.estimate) for fit in group]
    values = np.array([one.values for one in found])
    inverses = np.array([np.linalg.inv(one.covariance) for one in found])
    mean = np.linalg.solve(inverses.sum(axis=0), np.einsum("fij,fj->i", inverses, values))
    apart = values - mean
    square = float(np.einsum("fi,fij,fj->", apart, inverses, apart))
    ratio = float(np.sqrt(max(square, 0.0) / (values.shape[1] * (len(group) - 1))))
    if not np.isfinite(ratio):
        raise EstimationError(
            f"the delays of {len(group)} recordings have no finite scatter: {values[:, 0]}; check the frames"
        )
    return ratio


def run_to_run(fits: Sequence[RecordingFit], groups: Sequence[Alike]) -> Array:
    """Factor on the noise covariance of each fit, shape (n_fit,): the Birge ratio squared where it exceeds 1.

    Only where four or more recordings that should agree tell it: fewer say little about their scatter.

    Parameters
    ----------
    fits
        One per recording.
    groups
        From `alike`.
    """
    factor = np.ones(len(fits))
    for group in groups:
        if len(group.members) >= _ENOUGH_RUNS:
            factor[group.members] = max(1.0, birge_ratio([fits[k] for k in group.members]) ** 2)
    return factor


def with_variance(fit: EdgeDelayFit, factor: float) -> EdgeDelayFit:
    """The fit with variances that many times larger.

    Parameters
    ----------
    fit
        Of one recording.
    factor
        1 leaves it as it is.
    """
    return replace(fit, estimate=replace(fit.estimate, covariance=fit.estimate.covariance * factor))


def birge_findings(fits: Sequence[RecordingFit], groups: Sequence[Alike]) -> list[Finding]:
    """Where recordings that should agree scatter far more than their own uncertainties say.

    A doubt where that is no chance and no widening makes up for it, which fewer than four recordings do not tell.

    Parameters
    ----------
    fits, groups
        As for `run_to_run`.
    """
    found = []
    for group in groups:
        speed, members = group.speed_hz, group.members
        if len(members) < 2:
            continue
        freedom = _of_camera(fits[members[0]].estimate).values.size * (len(members) - 1)
        ratio = birge_ratio([fits[k] for k in members])
        if ratio > 1 + _SUSPICIOUS / np.sqrt(2 * freedom):
            is_chance = special.chdtrc(freedom, ratio**2 * freedom) > _SIGNIFICANCE
            found.append(
                Finding(
                    code="recordings-disagree",
                    severity="warning" if is_chance or len(members) >= _ENOUGH_RUNS else "doubt",
                    what=f"{len(members)} recordings at {speed:.4g} Hz scatter {ratio:.2f} times more than their noise "
                    "explains (Birge ratio)",
                    cure="something changed between them",
                )
            )
    return found


def of_triggers(fits: Sequence[RecordingFit], recordings: Sequence[ReducedRecording]) -> tuple[Finding, ...]:
    """A doubt where recordings of one camera differ by more than half the time between triggers.

    No angle that is stated wrongly makes as much of a difference, not even between two wheel speeds. A camera that missed the
    first trigger of one recording, frames beside the timestamps of another run, or a set delay that is not stated do.

    Parameters
    ----------
    fits, recordings
        One per recording.
    """
    delays = np.array([float(np.mean(_delays(fit))) for fit in fits])
    periods = [
        float(np.diff(one.trigger_ticks).min()) / one.track.clock_frequency_hz
        for one in recordings
        if one.trigger_ticks.size > 1
    ]
    if len(fits) < 2 or not periods or np.ptp(delays) <= 0.5 * min(periods):
        return ()
    first, last = recordings[int(np.argmin(delays))].name, recordings[int(np.argmax(delays))].name
    return (
        Finding(
            code="recordings-of-other-triggers",
            severity="doubt",
            what=f"the delay is {1e3 * np.ptp(delays):.3f} ms longer in {last} than in {first}, triggers come every "
            f"{1e3 * min(periods):.3f} ms: frames of one of them belong to other triggers, or its trigger_delay_time_set is "
            "wrong",
            cure="check that frames and timestamps are of one run, that the camera took the first trigger, and the set delays",
        ),
    )


def _delays(fit: RecordingFit) -> Array:
    return np.array([fit.estimate.value(name) for name in EDGE_DELAYS])


def _of_camera(estimate: Estimate) -> Estimate:
    """Mean delay over the edges, and what else is the camera's own."""
    beside = [name for name in _CAMERA if name in estimate]
    weights = np.zeros((1 + len(beside), len(estimate.names)))
    weights[0, [estimate.names.index(name) for name in EDGE_DELAYS]] = 0.25
    for k, name in enumerate(beside):
        weights[k + 1, estimate.names.index(name)] = 1.0
    return Estimate(
        names=("delay", *beside),
        units=("s",) * (1 + len(beside)),
        values=weights @ estimate.values,
        covariance=weights @ estimate.covariance @ weights.T,
    )
