"""What the residuals of all recordings share at the same wheel angle is not noise but a property of the rig.

A mask edge that is not straight, a mask plate as warm as neither wheel nor blackbody, a slot that is off: each leaves the
same trace in every recording. It must widen the uncertainty of the absolute delay, for which it is common to all
recordings, and it cancels in relative delays. With one recording the two cannot be told apart.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.inference.correlated_noise import variance_inflation
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array
from irtiming.records.estimate import EdgeDelayFit

_BINS = 200
_ALL_NOISE = 0.8  # of the residual power: the estimate itself scatters by 0.1, so more is taken as noise alone
_LEAST_SHARE = 1e-4  # a recording given twice has no noise of its own


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SharedResidual:
    """What of the residuals is each recording's own, and what all share.

    ``own_share`` (n_fit,) of each recording's residual variance is its own; ``shared_rad2`` (4, 4) is the covariance of the
    edges' angles that the rest stands for.
    """

    own_share: Array
    shared_rad2: Array


def split(fits: Sequence[EdgeDelayFit]) -> SharedResidual:
    """The noise of each recording and the structure that all share.

    Parameters
    ----------
    fits
        One per recording. The residuals are averaged in 200 bins of the wheel angle; what is left of a recording after
        the mean over all recordings is taken off, scaled for the degree of freedom that this costs, is its noise.
    """
    if len(fits) == 1:
        return SharedResidual(own_share=np.ones(1), shared_rad2=np.zeros((4, 4)))
    binned = np.array([_binned(fit) for fit in fits])
    seen = np.maximum(np.sum(np.isfinite(binned), axis=0), 1)
    own = (binned - np.nansum(binned, axis=0) / seen) * np.sqrt(len(fits) / (len(fits) - 1))
    share = np.array([_power(rest) / _power(whole) for whole, rest in zip(binned, own, strict=True)])
    share = np.where(share > _ALL_NOISE, 1.0, share)
    shared = [
        fit.covariance_s2 * (1 - part) * fit.angular_frequency_rad_per_s**2
        for fit, part in zip(fits, share, strict=True)
    ]
    return SharedResidual(own_share=np.maximum(share, _LEAST_SHARE), shared_rad2=np.mean(shared, axis=0))


def _binned(fit: EdgeDelayFit) -> Array:
    """Mean residual per bin of the wheel angle, nan where there is none, shape (200,)."""
    which = np.minimum((fit.wheel_angle_rad / TURN * _BINS).astype(int), _BINS - 1)
    count = np.bincount(which, minlength=_BINS)
    total = np.bincount(which, fit.residual, _BINS)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _power(binned: Array) -> float:
    """Variance of the binned residuals times the variance inflation for their correlation."""
    values = binned[np.isfinite(binned)]
    return float(values.var()) * variance_inflation(values)
