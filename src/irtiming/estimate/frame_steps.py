"""By how much the wheel turns from one frame to the next, and which frames follow the camera's frame before."""

from dataclasses import replace

import numpy as np

from irtiming.physics.response import in_camera_filter
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Mask
from irtiming.records.reduced import ReducedRecording


def follows(recording: ReducedRecording) -> Mask:
    """Which kept frames come one trigger after the kept frame before, in the same stretch; shape (n,), the first never.

    Parameters
    ----------
    recording
        Its triggers are periodic but for those that were lost; what a frame after a lost one holds of that is unknown.
    """
    same = np.concatenate([[False], np.diff(recording.segment) == 0])
    return same & in_camera_filter.follows(recording.trigger_ticks)


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
    return recording.track.angular_frequency_rad_per_s * recording.trigger_period_s


def unfiltered(recording: ReducedRecording, share: float) -> ReducedRecording:
    """The recording with a contrast image as the pixels saw it, before a recursive filter of the camera.

    Parameters
    ----------
    recording
        Whose image was made of pairs of frames as well.
    share
        k of the filter; 0 leaves the recording as it is.
    """
    image = recording.contrast_image
    if not share or image.pairs is None:
        return recording
    pairs = image.pairs
    left = abs(in_camera_filter.transfer(step_rad(recording), share, n_harmonics=2)[2])
    n_before, n_now = (np.count_nonzero(weight) for weight in (image.frame_weight, pairs.frame_weight))
    contrast = replace(
        image,
        projection_dn=np.asarray((pairs.projection_dn - share * pairs.before_dn) / (1 - share), complex),
        frame_weight=pairs.frame_weight,
        u_dn=image.u_dn / float(left) * float(np.sqrt(n_before / n_now)),
        pairs=None,
    )
    return replace(recording, contrast=contrast)
