"""By how much the wheel turns from one frame to the next, and which frames follow the camera's frame before."""

import numpy as np

from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Mask
from irtiming.records.reduced import ReducedRecording

_MOST_PERIODS = 1.5  # between two triggers, the second of which follows the first


def follows(recording: ReducedRecording) -> Mask:
    """Which kept frames come one trigger after the kept frame before, in the same stretch; shape (n,), the first never.

    Parameters
    ----------
    recording
        Its triggers are periodic but for those that were lost; of a frame after a lost one nobody knows what it holds of that.
    """
    period = np.diff(recording.trigger_ticks)
    near = (period < _MOST_PERIODS * np.median(period)) & (np.diff(recording.segment) == 0)
    return np.concatenate([[False], near])


def step_rad(recording: ReducedRecording) -> float:
    """Angle by which the wheel turns from trigger to trigger: the mean over frames that follow one another.

    Parameters
    ----------
    recording
        Two frames or more; where none follows another, the step of a median period.
    """
    angle = wheel_angle_rad(
        0.0, recording.track, at_ticks=recording.trigger_ticks, set_s=recording.trigger_delay_time_set_s
    )
    steps = np.diff(angle)[follows(recording)[1:]]
    if steps.size:
        return float(np.mean(steps))
    period_s = float(np.median(np.diff(recording.trigger_ticks))) / recording.track.clock_frequency_hz
    return recording.track.angular_frequency_rad_per_s * period_s
