"""Frames that are not like the others: a person before the lens, a disturbed exposure, a wrong trigger."""

import numpy as np

from irtiming.errors import EstimationError
from irtiming.physics import robust
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array, Mask

_OUTLIER = 6.0  # times the robust standard deviation
_LEAST_WILD = 5e-4  # of the step: a frame that is less off does no harm
_NEIGHBOURS = 15
_DROPPED_SHARE = 0.05
_LARGEST_SPREAD = 0.1  # of the step


def of(residual: Array, angle_rad: Array, *, name: str) -> Mask:
    """Frames that differ from what their neighbours along the wheel angle foretell, shape (n,).

    Parameters
    ----------
    residual
        Of the pixel sums, in units of the step, shape (n,).
    angle_rad
        Of the wheel, shape (n,); what all are off leaves neighbours as they are.
    name
        Of the recording.

    Raises
    ------
    EstimationError
        If too many do, or the sums do not follow the model at all.
    """
    residual = residual - np.median(residual)  # where many are wild, the rest is shifted
    spread = robust.spread(residual)
    if spread > _LARGEST_SPREAD:
        raise EstimationError(
            f"{name}: the pixel sums do not follow the wheel: they scatter about the model by {spread:.2g} of the "
            f"step, at most {_LARGEST_SPREAD} may be; check rig.toml and that the timestamps belong to these frames"
        )
    alone = _beside_neighbours(residual, angle_rad)
    spread = robust.spread(alone)
    outlier = np.abs(alone) > max(_OUTLIER * spread, _LEAST_WILD)
    if outlier.mean() > _DROPPED_SHARE:
        raise EstimationError(
            f"{name}: {outlier.sum()} of {outlier.size} frames differ from their neighbours by more than "
            f"{_OUTLIER:.0f} standard deviations ({spread:.2g} of the step), at most {_DROPPED_SHARE:.0%} may; check rig.toml "
            "against the mean frame and the frames for disturbances"
        )
    return np.asarray(outlier)


def _beside_neighbours(residual: Array, angle: Array) -> Array:
    """Residuals less what their neighbours along the wheel angle foretell: a frame that is wild, not a model that is coarse.

    The median of the means of pairs to both sides follows a slope, and does not hold the frame itself.
    """
    order = np.argsort(np.mod(angle, TURN))
    sorted_by_angle = residual[order]
    pairs = [(np.roll(sorted_by_angle, k) + np.roll(sorted_by_angle, -k)) / 2 for k in range(1, _NEIGHBOURS // 2 + 1)]
    alone = np.empty_like(residual)
    alone[order] = sorted_by_angle - np.median(pairs, axis=0)
    return alone
