"""How much, and when, each pixel follows the wheel: its projection on the second harmonic of the wheel angle."""

import numpy as np

from irtiming.physics.response import in_camera_filter
from irtiming.records.arrays import Array, Ticks
from irtiming.records.reduced import ContrastImage, ContrastPairs, Opening
from irtiming.reduce.accumulators.projection import PairProjection, Projection
from irtiming.reduce.nonuniformity import Correction
from irtiming.reduce.opening import dead_rows, wheel_contrast

_STUCK = 1e-4  # of the noise: a pixel that swings by less with any order of the wheel has none, nor do its level and gain sway


def projection(
    wheel_angle_rad: Array, opening: Opening, *, share: Array | float = 1.0, trigger_ticks: Ticks | None = None
) -> Projection:
    """Accumulator of the contrast image.

    Parameters
    ----------
    wheel_angle_rad
        Shape (n_frame,); nan where unknown.
    opening
        Whose region of interest is projected.
    share
        Weight of each frame, shape (n_frame,), mean 1.
    trigger_ticks
        Shape (n_frame,); where given, frames that followed each other are projected in pairs as well.
    """
    row0, row1, column0, column1 = opening.roi
    return Projection(
        share * np.exp(-2j * wheel_angle_rad),
        shape=(row1 - row0, column1 - column0),
        follows=None if trigger_ticks is None else in_camera_filter.follows(trigger_ticks),
    )


def mean_dn(projected: Projection, opening: Opening, *, correct: Correction) -> Array:
    """Mean of each pixel over the frames that were kept, shape (roi rows, roi columns), corrected DN.

    Parameters
    ----------
    projected
        That took them in.
    opening, correct
        Whose region of interest it is; the correction of the whole image.
    """
    within = correct.within(opening.roi)
    return within.offset_dn + within.gain * projected.level / projected.frame_weight.size


def of(
    projected: Projection, opening: Opening, *, correct: Correction, drift_dn: Array, noise_dn: float
) -> ContrastImage:
    """The contrast image of the frames that were kept.

    Parameters
    ----------
    projected
        That took them in.
    opening, correct
        Whose region of interest it is; the correction of the whole image.
    drift_dn
        Shape (n,); level that is taken off all pixels of each kept frame, corrected DN.
    noise_dn
        Of one pixel from frame to frame, for where no still pixels tell the noise of the image.
    """
    weight = projected.frame_weight
    within = correct.within(opening.roi)
    own = projected.total * within.gain * 2 / weight.size
    value = own - np.sum(weight * drift_dn)
    box = np.s_[slice(*opening.roi[:2]), slice(*opening.roi[2:])]
    u_still = wheel_contrast.noise_between_neighbours(value, ~opening.summed[box])
    dead = dead_rows.of(opening.bad)[slice(*opening.roi[:2])]
    u_dn = noise_dn * float(np.sqrt(2 / weight.size)) if np.isnan(u_still) else u_still
    return ContrastImage(
        pairs=None if projected.pairs is None else _pairs(projected.pairs, within.gain, drift_dn),
        projection_dn=dead_rows.filled(value, dead),
        frame_weight=weight,
        u_dn=u_dn,
        good=~opening.bad[box] & (np.abs(own) >= _STUCK * u_dn),
        roi=opening.roi,
    )


def _pairs(projected: PairProjection, gain: Array, drift_dn: Array) -> ContrastPairs | None:
    """Of frames that followed each other; None where none did."""
    weight = projected.frame_weight
    n = np.count_nonzero(weight)
    if not n:
        return None
    return ContrastPairs(
        projection_dn=projected.now * gain * 2 / n - np.sum(weight * drift_dn),
        before_dn=projected.before * gain * 2 / n - np.sum(weight[1:] * drift_dn[:-1]),
        frame_weight=weight,
    )
