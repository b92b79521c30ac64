r"""Delay by falling slopes minus delay by rising ones, as a constant time and an angle.

.. math:: \delta(\omega) = t + a / \omega

A mask edge that is not where it seems, an edge of a cutout that is off, a warm blade: each is an angle, a. A detector that
remembers the frame before, or settles more slowly one way, is a time, t. At one wheel speed they cannot be distinguished; Schatz
2023, 3.1.5 has 78.8 us at 3 Hz, "cause not apparent".
"""

from collections.abc import Sequence

import numpy as np

from irtiming.errors import EstimationError
from irtiming.estimate.joint import Joint
from irtiming.inference.information import combine
from irtiming.records.estimate import EDGE_DELAYS, Estimate, RecordingFit

TIME, ANGLE = "falling_rising_time", "falling_rising_angle"
_LEAST_SPEED_RATIO = 1.2  # of the wheel's speeds
_SENSE = dict(zip(EDGE_DELAYS, (0.5, -0.5, 0.5, -0.5), strict=True))


def of(joint: Joint, fits: Sequence[RecordingFit]) -> Estimate | None:
    """Time and angle with their covariance, beyond the errors of the wheel's edges that are known to a size; None at one speed.

    Parameters
    ----------
    joint
        Of all recordings; one linear step from its minimum.
    fits
        One per recording; of each the wheel's speed counts.
    """
    speeds = [fit.angular_frequency_rad_per_s for fit in fits]
    if max(speeds) < _LEAST_SPEED_RATIO * min(speeds):
        return None
    names, pieces = (*joint.names, TIME, ANGLE), []
    for piece, made, omega in zip(joint.pieces, joint.designs(), speeds, strict=True):
        sense = np.array([_SENSE.get(name, 0.0) for name in piece.names])
        pieces.append(piece.of(names, np.column_stack([made, sense, sense / omega])))
    try:
        whole = combine([*pieces, *joint.priors])
    except EstimationError:
        return None
    return Estimate(
        names=(TIME, ANGLE), units=("s", "rad"), values=whole.step[-2:], covariance=whole.covariance[-2:, -2:]
    )
