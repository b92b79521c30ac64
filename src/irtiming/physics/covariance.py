"""Covariances as every stage needs them: of parameters in different units, and of what neighbours share."""

import numpy as np

from irtiming.records.arrays import Array

FLAT = 1e-11
"""Of the largest: sizes of axes along which a normal matrix says nothing."""


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


def generalised_inverse(symmetric: Array, *, flat: float = FLAT) -> Array:
    """The same of a matrix that may say nothing along some axes: there it is zero.

    Parameters
    ----------
    symmetric
        Shape (n, n); a row and column may be zero.
    flat
        Size of such axes, over the largest.

    Returns
    -------
    Shape (n, n).
    """
    scale = np.sqrt(np.maximum(np.diag(symmetric), 1e-300))
    units = np.outer(scale, scale)
    return np.asarray(np.linalg.pinv(symmetric / units, rcond=flat, hermitian=True) / units)


def root(covariance: Array) -> Array:
    """A matrix whose product with its transpose is this, which may be singular.

    Parameters
    ----------
    covariance
        Shape (n, n).

    Returns
    -------
    Shape (n, n).
    """
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    sizes, axes = np.linalg.eigh(covariance / np.outer(scale, scale))
    return np.asarray(scale[:, None] * axes * np.sqrt(np.maximum(sizes, 0.0)))


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
