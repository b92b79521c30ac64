"""Opening fractions of the whole mask and of its rows over the wheel angle, averaged over runs (Schatz 2023, 3.2.3, figure 6)."""

from typing import Any

import numpy as np
import numpy.typing as npt

from irtiming.errors import ReductionError
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array, Ticks
from irtiming.records.exposed import ExposedRows
from irtiming.records.reduced import ReducedRecording
from irtiming.reduce.published import trigger_angles
from irtiming.reduce.wheel import nominal_angles

_FEWEST_PIXELS = 4  # of the mask in a row
_WINDOW_RAD = 0.069  # of the parabolas: 11 of 1000 samples per turn
_FEWEST_IN_WINDOW = 5
_CLEARLY = 0.15  # of the range from the middle: then a point is on one side


def average(runs: list[ReducedRecording]) -> ExposedRows:
    """Opening fractions over the wheel angle at the trigger, averaged over runs.

    Parameters
    ----------
    runs
        Recordings of one nominal delay and one rotation speed, with the same mask.

    Returns
    -------
    Sums over the mask and over each of its rows with four pixels or more, normalised in each run "using the averages of the
    extrema of the two upper and lower plateaus" and reversed for a cold blackbody. Standard uncertainties come from the
    scatter over the visits to each nominal angle.

    Raises
    ------
    ReductionError
        If the runs share no nominal angles or rows, or a run has no two plateaus of either kind.

    Notes
    -----
    With a lag a plateau is round, and its extremum one point of noisy data. We take the extremum of the curve that is, at
    each point, the value of a parabola fitted to the 0.07 rad around it (11 of 1000 samples): an exact one where the lag,
    as an angle of the wheel, is longer than that window's half, and with less than half of the noise.
    """
    first = runs[0]
    rows = _common_rows(runs)
    angles, curves = [], []
    for run in runs:
        angle = trigger_angles.of_run(run)
        is_known = np.isfinite(angle)
        places, sums = np.searchsorted(run.row_sums.row_px, rows), run.row_sums.mask_row_sum_dn[is_known]
        together = np.concatenate([sums.sum(axis=1)[None], sums[:, places].T])
        angles.append(angle[is_known])
        fraction = _normalised(angle[is_known], together, run.name)
        curves.append(1 - fraction if run.opening.blackbody_is_colder else fraction)
    names = tuple(run.name for run in runs)
    visits = nominal_angles.group(np.concatenate(angles), first.samples_per_turn, names=names)
    curve = np.concatenate(curves, axis=1)
    usable = np.asarray(np.isfinite(curve).all(axis=1))
    if usable.sum() < 2:
        raise ReductionError(
            f"{', '.join(names)}: no row of the opening has two upper and two lower plateaus; the blackbody is too near to "
            "room temperature for the noise, or the wheel too fast for the camera's lag"
        )
    means, us = zip(*(visits.mean(one) for one in curve[usable]), strict=True)
    return ExposedRows(
        trigger_delay_time_set_s=first.trigger_delay_time_set_s,
        rotation_speed_hz=first.rotation_speed_hz,
        angular_frequency_rad_per_s=float(np.mean([run.equal_track.angular_frequency_rad_per_s for run in runs])),
        names=names,
        files=tuple(run.file for run in runs),
        wheel_angle_rad=visits.wheel_angle_rad,
        fraction=means[0],
        u_fraction=us[0],
        row_px=rows[usable[1:]],
        row_fraction=np.array(means[1:]),
        u_row_fraction=None if us[0] is None else np.array(us[1:]),
        mask=first.opening.mask,
    )


def _common_rows(runs: list[ReducedRecording]) -> Ticks:
    """Rows that hold enough pixels of the mask in all runs."""
    rows = runs[0].row_sums.row_px
    for run in runs:
        row_px = run.row_sums.row_px
        wide = row_px[run.opening.mask[row_px].sum(axis=1) >= _FEWEST_PIXELS]
        rows = np.intersect1d(rows, wide)
    if not rows.size:
        raise ReductionError(
            f"{', '.join(run.name for run in runs)}: no image row holds {_FEWEST_PIXELS} pixels of the opening in all runs; "
            "runs of one delay must be recorded without moving the camera"
        )
    return rows


def _normalised(angle: Array, sums: Array, name: str) -> Array:
    """Each curve, shape (curve, n), scaled by its plateaus; nan for a row that has not two of either kind."""
    order = np.argsort(angle)
    smooth = _parabolas(angle[order], sums[:, order])
    levels = np.array([_levels(curve) for curve in smooth])
    if not np.isfinite(levels[0]).all():
        raise ReductionError(
            f"{name}: the sum over the opening has not two upper and two lower plateaus in a turn; the recording must span "
            "whole turns and show the whole opening, and the mask must be narrower than the wheel's cutouts"
        )
    low, high = levels.T[:, :, None]
    return np.asarray((sums - low) / (high - low))


def _parabolas(angle: Array, curves: Array) -> Array:
    """Value at each point of the parabola fitted to the points around it, shape (curve, n); angles sorted."""
    n = angle.size
    half = max(_FEWEST_IN_WINDOW // 2, round(0.5 * _WINDOW_RAD / TURN * n))
    window = np.mod(np.arange(n)[:, None] + np.arange(-half, half + 1), n)
    beside = np.mod(angle[window] - angle[:, None] + np.pi, TURN) - np.pi
    powers = (beside / max(float(np.abs(beside).max()), 1e-12))[:, :, None] ** np.arange(3)
    weights = np.linalg.pinv(powers)[:, 0, :]
    smooth = np.zeros_like(curves)
    for k in range(window.shape[1]):
        smooth += weights[:, k] * curves[:, window[:, k]]
    return smooth


def _levels(curve: Array) -> tuple[float, float]:
    """Averages of the extrema of the two lower and of the two upper plateaus; nan where there are not two of each."""
    low, high = float(curve.min()), float(curve.max())
    place = (curve - low) / max(high - low, 1e-300) - 0.5
    side: npt.NDArray[Any] = np.where(place > _CLEARLY, 1, np.where(place < -_CLEARLY, -1, 0))
    clear = np.flatnonzero(side)
    changes = np.flatnonzero(side[clear] != np.roll(side[clear], 1))
    if changes.size != 4:
        return np.nan, np.nan
    runs = np.split(np.roll(clear, -changes[0]), changes[1:] - changes[0])
    uppers = [curve[run].max() for run in runs if side[run[0]] > 0]
    lowers = [curve[run].min() for run in runs if side[run[0]] < 0]
    return float(np.mean(lowers)), float(np.mean(uppers))
