"""The nominal wheel angles that a trigger scheme visits, and means over the visits to each (Schatz 2023, 2.3, 3.1.3)."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import ReductionError
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array, Ticks
from irtiming.records.recording import Recording

_MOST_SAMPLES_PER_TRIGGER = 4
_SAMPLES_WITHOUT_SCHEME = 1000
_VISITS_FOR_OWN_SCATTER = 5  # with fewer, all points share one pooled scatter


def samples_per_turn(recording: Recording) -> int:
    """Nominal wheel angles per turn, T / gcd(T, C) (Schatz 2023, 2.3); about one per trigger without a scheme."""
    turn = recording.wheel_period_ticks or round(recording.clock_frequency_hz / recording.rotation_speed_hz)
    camera = recording.camera_period_ticks or int(np.median(np.diff(recording.camera_trigger_ticks)))
    n_triggers = recording.camera_trigger_ticks.size
    n = turn // int(np.gcd(turn, camera))
    return n if n <= _MOST_SAMPLES_PER_TRIGGER * n_triggers else min(_SAMPLES_WITHOUT_SCHEME, n_triggers)


def share_of_turn(wheel_angle_rad: Array, samples_per_turn: int) -> Array:
    """How much of the turn each frame stands for, shape (n_frame,), mean about 1; 0 for a frame without an angle.

    Frames at one nominal angle share what lies half-way to the nearest nominal angles that were visited.

    Parameters
    ----------
    wheel_angle_rad
        Shape (n_frame,); nan where unknown.
    samples_per_turn
        Nominal angles per turn.
    """
    known = np.isfinite(wheel_angle_rad)
    sample = np.mod(
        np.rint(np.where(known, wheel_angle_rad, 0.0) / TURN * samples_per_turn).astype(int), samples_per_turn
    )
    count = np.bincount(sample[known], minlength=samples_per_turn)
    met = np.flatnonzero(count)
    if met.size < 3:
        return known.astype(float)
    gap = np.diff(met, append=met[0] + samples_per_turn)
    span = np.zeros(samples_per_turn)
    span[met] = (gap + np.roll(gap, 1)) / 2
    share = np.where(known, span[sample] / np.maximum(count[sample], 1), 0.0)
    return np.asarray(share * known.sum() / share.sum())


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Visits:
    """Frames grouped by the nominal angle at which they were triggered.

    Parameters
    ----------
    wheel_angle_rad, u_wheel_angle_rad
        Shape (n_used,); mean angle of the visits to each nominal angle, sorted, and its standard uncertainty, None where
        each was visited once.
    """

    wheel_angle_rad: Array
    u_wheel_angle_rad: Array | None
    _sample: Ticks
    _used: Ticks
    _order: Ticks
    _visits: int

    def mean(self, value: Array) -> tuple[Array, Array | None]:
        """Mean per nominal angle and its standard uncertainty from the scatter over visits, shapes (n_used,).

        Parameters
        ----------
        value
            Shape (n,), of the frames that were grouped.
        """
        mean, u_mean = _mean_and_u(value, self._sample, self._used, self._visits)
        return mean[self._order], None if u_mean is None else u_mean[self._order]


def group(wheel_angle_rad: Array, n_nominal: int, *, names: tuple[str, ...]) -> Visits:
    """Group frames by nominal angle.

    Parameters
    ----------
    wheel_angle_rad
        Shape (n,); wheel angle of each frame of all runs.
    n_nominal
        Nominal angles per turn.
    names
        Of the runs, for the message.

    Returns
    -------
    Groups of the angles that were met in at least half of the passes. Standard uncertainties come from the scatter over the
    visits to each angle, be they in several recordings or in one long one: per point from five visits on; with two to four
    the scatter is pooled over all points, since two numbers make no scatter that one can weight by; with one there is none.

    Raises
    ------
    ReductionError
        If the runs share no nominal angles.
    """
    n = n_nominal
    origin = float(np.angle(np.mean(np.exp(1j * n * wheel_angle_rad)))) / n
    sample = np.mod(np.rint((wheel_angle_rad - origin) * n / TURN).astype(np.int64), n)
    beside = np.mod(wheel_angle_rad - origin - TURN * sample / n + np.pi, TURN) - np.pi
    count = np.bincount(sample, minlength=n)
    visits = round(float(np.median(count[count > 0])))
    used = np.flatnonzero(count >= max(min(visits, 2), (visits + 1) // 2))
    if used.size < n // 2:
        raise ReductionError(
            f"only {used.size} of {n} nominal angles were met in at least half of the {visits} passes of "
            f"{', '.join(names)}; runs of one delay must have the same trigger scheme and span whole "
            "measurements"
        )
    mean_beside, u_angle = _mean_and_u(beside, sample, used, visits)
    at = np.mod(origin + TURN * used / n + mean_beside, TURN)
    order = np.argsort(at)
    return Visits(
        wheel_angle_rad=at[order],
        u_wheel_angle_rad=None if u_angle is None else u_angle[order],
        _sample=sample,
        _used=used,
        _order=order,
        _visits=visits,
    )


def _mean_and_u(value: Array, sample: Ticks, used: Ticks, visits: int) -> tuple[Array, Array | None]:
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
