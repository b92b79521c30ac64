"""Covariances as every stage needs them: of parameters in different units, and of what neighbours share."""

import numpy as np

from irtiming.records.arrays import Array


def inverse(symmetric: Array) -> Array:
    """Inverse of a positive matrix whose rows have different units: scaled to a diagonal of ones first.

    Parameters
    ----------
    symmetric
        Shape (n, n), its diagonal positive.

    Returns
    -------
    Shape (n, n).
    """
    scale = np.sqrt(np.diag(symmetric))
    return np.asarray(np.linalg.inv(symmetric / np.outer(scale, scale)) / np.outer(scale, scale), dtype=float)


def hac_covariance(scores: Array, *, n_neighbours: int, is_circular: bool) -> Array:
    """Covariance of a sum of correlated scores, robust against heteroscedasticity and autocorrelation (HAC).

    Parameters
    ----------
    scores
        Shape (n, k); gradient that each sample contributes, in an order in which correlation fades.
    n_neighbours
        To either side, that may be correlated.
    is_circular
        Whether the last sample is the first one's neighbour.

    Returns
    -------
    Shape (k, k).

    Notes
    -----
    Newey and West's estimator (1987): products of neighbours weighed with a triangle, which cannot become negative.
    """
    total = scores.T @ scores
    for lag in range(1, n_neighbours + 1):
        first, second = (scores, np.roll(scores, -lag, axis=0)) if is_circular else (scores[:-lag], scores[lag:])
        beside = first.T @ second
        total += (1 - lag / (n_neighbours + 1)) * (beside + beside.T)
    return np.asarray(total)
