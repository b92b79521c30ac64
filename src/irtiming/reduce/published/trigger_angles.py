"""The wheel angle at each trigger, over which the published procedures average (Schatz 2023, 3.1.3)."""

import numpy as np

from irtiming.physics.wheel import TURN
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Array
from irtiming.records.reduced import ReducedRecording


def of_run(run: ReducedRecording) -> Array:
    """Wheel angle at each trigger, with all slots taken for equal.

    Parameters
    ----------
    run
        One recording.

    Returns
    -------
    Shape (n_frame,), rad, in [0, 2 pi); nan where unknown: a trigger may lie before the first slot while its delayed exposure
    does not.
    """
    return np.mod(wheel_angle_rad(0.0, run.equal_track, at_ticks=run.trigger_ticks), TURN)
