"""Average the runs of one nominal delay per nominal wheel angle (Schatz 2023, 3.1.3)."""

import numpy as np

from irtiming.records.exposed import ExposedFraction
from irtiming.records.reduced import ReducedRecording
from irtiming.reduce.published import plateaus, trigger_angles
from irtiming.reduce.wheel import nominal_angles


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
    angle, as `nominal_angles.group` says; with a single visit there is none.

    Raises
    ------
    ReductionError
        If a run has no plateaus or the runs share no nominal angle.
    """
    angles, fractions = [], []
    for run in runs:
        angle = trigger_angles.of_run(run)
        is_known = np.isfinite(angle)
        angle, counted = angle[is_known], run.pixel_sums.pixel_count[is_known]
        found = plateaus.find(angle, counted, name=run.name, margin=plateau_margin)
        angles.append(angle)
        fractions.append(plateaus.normalise(angle, counted, plateaus=found))
    names = tuple(run.name for run in runs)
    visits = nominal_angles.group(np.concatenate(angles), runs[0].samples_per_turn, names=names)
    fraction, u_fraction = visits.mean(np.concatenate(fractions))
    return ExposedFraction(
        trigger_delay_time_set_s=runs[0].trigger_delay_time_set_s,
        rotation_speed_hz=runs[0].rotation_speed_hz,
        angular_frequency_rad_per_s=float(np.mean([run.equal_track.angular_frequency_rad_per_s for run in runs])),
        names=names,
        files=tuple(run.file for run in runs),
        wheel_angle_rad=visits.wheel_angle_rad,
        fraction=fraction,
        u_wheel_angle_rad=visits.u_wheel_angle_rad,
        u_fraction=u_fraction,
        plateaus=found,
    )
