"""Average the runs of one nominal delay per nominal wheel angle (Schatz 2023, 3.1.3)."""

import numpy as np

from irtiming.errors import ReductionError
from irtiming.physics.wheel import TURN
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Array
from irtiming.records.reduced import ExposedFraction, ReducedRecording
from irtiming.reduce import plateaus

_VISITS_FOR_OWN_SCATTER = 5  # with fewer, all points share one pooled scatter


def average(runs: list[ReducedRecording], *, plateau_margin: float = 0.15) -> ExposedFraction:
    """Opening fraction of pixel counts over the wheel angle at the trigger, averaged over runs.

    Parameters
    ----------
    runs
        Recordings of one nominal delay and one rotation speed.
    plateau_margin
        Share of a plateau's width kept away from each of its corners.

    Returns
    -------
    One point per nominal angle, sorted by angle. Standard uncertainties come from the scatter over the visits to each
    angle, be they in several recordings or in one long one: per point from five visits on; with two to four the scatter
    is pooled over all points, since two numbers make no scatter that one can weight by; with one there is none.

    Raises
    ------
    ReductionError
        If a run has no plateaus or the runs share no nominal angle.
    """
    n = runs[0].samples_per_turn
    angles, fractions = [], []
    for run in runs:
        angle = np.mod(wheel_angle_rad(0.0, run.equal_track, at_ticks=run.trigger_ticks), TURN)
        seen = np.isfinite(angle)  # a trigger may lie before the first slot while its delayed exposure does not
        angle, counted = angle[seen], run.pixel_count[seen]
        found = plateaus.find(angle, counted, name=run.name, margin=plateau_margin)
        angles.append(angle)
        fractions.append(plateaus.normalise(angle, counted, plateaus=found))
    angle, fraction = np.concatenate(angles), np.concatenate(fractions)
    origin = float(np.angle(np.mean(np.exp(1j * n * angle)))) / n
    sample = np.mod(np.rint((angle - origin) * n / TURN).astype(np.int64), n)
    beside = np.mod(angle - origin - TURN * sample / n + np.pi, TURN) - np.pi
    count = np.bincount(sample, minlength=n)
    visits = round(float(np.median(count[count > 0])))
    used = np.flatnonzero(count >= max(min(visits, 2), (visits + 1) // 2))
    if used.size < n // 2:
        raise ReductionError(
            f"only {used.size} of {n} nominal angles were met in at least half of the {visits} passes of "
            f"{', '.join(run.name for run in runs)}; runs of one delay must have the same trigger scheme and span whole "
            "measurements"
        )
    mean_beside, u_angle = _mean_and_u(beside, sample, used, visits)
    mean_fraction, u_fraction = _mean_and_u(fraction, sample, used, visits)
    at = np.mod(origin + TURN * used / n + mean_beside, TURN)
    order = np.argsort(at)
    return ExposedFraction(
        trigger_delay_time_set_s=runs[0].trigger_delay_time_set_s,
        rotation_speed_hz=runs[0].rotation_speed_hz,
        names=tuple(run.name for run in runs),
        wheel_angle_rad=at[order],
        fraction=mean_fraction[order],
        u_wheel_angle_rad=None if u_angle is None else u_angle[order],
        u_fraction=None if u_fraction is None else u_fraction[order],
        plateaus=found,
    )


def _mean_and_u(value: Array, sample: np.ndarray, used: np.ndarray, visits: int) -> tuple[Array, Array | None]:
    """Mean per nominal angle and its standard uncertainty from the scatter over runs."""
    size = int(sample.max()) + 1
    count = np.bincount(sample, minlength=size)[used]
    mean = np.bincount(sample, value, size)[used] / count
    if visits == 1:
        return mean, None
    full = np.zeros(size)
    full[used] = mean
    squares = np.bincount(sample, (value - full[sample]) ** 2, size)[used]
    variance = squares / (count - 1)
    if visits < _VISITS_FOR_OWN_SCATTER:
        variance = np.full_like(variance, squares.sum() / (count - 1).sum())
    return mean, np.sqrt(variance / count)
