"""Are residuals white? A test whose answer is a probability."""

import numpy as np
from scipy.stats import chi2

from irtiming.records.arrays import Array

_LAGS = 20


def probability(residual: Array) -> float:
    """Probability of autocorrelations at least as large, were the residuals white.

    Parameters
    ----------
    residual
        Shape (n,), in the order along which they might hang together.

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
    return float(chi2.sf(statistic, _LAGS))
