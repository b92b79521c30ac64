"""Residuals that are not white: a test for it, and by how much variances grow with it."""

import numpy as np
from scipy.special import chdtrc

from irtiming.records.arrays import Array

_LAGS = 20
_SIGNIFICANT = 2.0  # standard deviations of an autocorrelation of white noise


def ljung_box_p_value(residual: Array) -> float:
    """Probability of autocorrelations at least as large, were the residuals white.

    Parameters
    ----------
    residual
        Shape (n,), in the order along which they might be correlated.

    Notes
    -----
    Ljung and Box, Biometrika 65 (1978) 297: n (n + 2) sum of r_k^2 / (n - k) over 20 lags is chi-square distributed.
    """
    centred = residual - residual.mean()
    power, n = float(centred @ centred), residual.size
    if power == 0 or n <= 2 * _LAGS:
        return 1.0
    correlation = np.array([float(centred[:-lag] @ centred[lag:]) for lag in range(1, _LAGS + 1)]) / power
    statistic = n * (n + 2) * float(np.sum(correlation**2 / (n - np.arange(1, _LAGS + 1))))
    return float(chdtrc(_LAGS, statistic))


def variance_inflation(residual: Array) -> float:
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
        if correlation < _SIGNIFICANT / np.sqrt(residual.size):
            break
        total += 2 * correlation
    return total
