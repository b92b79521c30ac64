"""What the residuals of all recordings share at the same wheel angle is not noise but a property of the rig.

A mask edge that is not straight, a mask plate as warm as neither wheel nor blackbody, a slot that is off: each leaves the
same trace in every recording. It must widen the uncertainty of the absolute delay, for which it is common to all
recordings, and it cancels in relative delays. With one recording the two cannot be told apart.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array
from irtiming.records.estimate import EdgeDelayFit

_BINS = 200
_ALL_NOISE = 0.8  # of the residual power: the estimate itself scatters by 0.1, so more is taken as noise alone


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SplitCovariance:
    """Covariance of the four edge delays: ``noise_s2`` (n_fit, 4, 4) of each recording, ``shared_rad2`` (4, 4) of all."""

    noise_s2: Array
    shared_rad2: Array


def split(fits: list[EdgeDelayFit]) -> SplitCovariance:
    """Covariances of the noise of each recording and of the structure that they share.

    Parameters
    ----------
    fits
        One per recording. The residuals are averaged in 200 bins of the wheel angle; what is left of a recording after
        the mean over all recordings is taken off, scaled for the degree of freedom that this costs, is its noise.
    """
    if len(fits) == 1:
        return SplitCovariance(noise_s2=fits[0].covariance_s2[None], shared_rad2=np.zeros((4, 4)))
    binned = np.array([_binned(fit) for fit in fits])
    seen = np.maximum(np.sum(np.isfinite(binned), axis=0), 1)
    own = (binned - np.nansum(binned, axis=0) / seen) * np.sqrt(len(fits) / (len(fits) - 1))
    noise, shared = [], []
    for fit, whole, rest in zip(fits, binned, own, strict=True):
        share = _power(rest) / _power(whole)
        share = 1.0 if share > _ALL_NOISE else share
        noise.append(fit.covariance_s2 * share)
        shared.append(fit.covariance_s2 * (1 - share) * fit.angular_frequency_rad_per_s**2)
    return SplitCovariance(noise_s2=np.array(noise), shared_rad2=np.mean(shared, axis=0))


def _binned(fit: EdgeDelayFit) -> Array:
    """Mean residual per bin of the wheel angle, nan where there is none, shape (200,)."""
    which = np.minimum((fit.wheel_angle_rad / TURN * _BINS).astype(int), _BINS - 1)
    count = np.bincount(which, minlength=_BINS)
    total = np.bincount(which, fit.residual, _BINS)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _power(binned: Array) -> float:
    """Variance of the binned residuals times the widening for their correlation."""
    values = binned[np.isfinite(binned)]
    return float(values.var()) * widening(values)


def widening(residual: Array) -> float:
    """1 + 2 sum of the autocorrelations along the angle, up to the first that is not significant.

    Parameters
    ----------
    residual
        Shape (n,), in the order of the angle.

    Returns
    -------
    Factor on the variance of a mean; 1 for white residuals.
    """
    centred = residual - residual.mean()
    power = float(centred @ centred)
    if power == 0:
        return 1.0
    total = 1.0
    for lag in range(1, residual.size // 4):
        correlation = float(centred[:-lag] @ centred[lag:]) / power
        if correlation < 2 / np.sqrt(residual.size):
            break
        total += 2 * correlation
    return total
