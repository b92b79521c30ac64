"""Covariances as every stage needs them: of parameters in different units, and of what neighbours share."""

import numpy as np

from irtiming.records.arrays import Array

FLAT = 1e-11
"""Of the largest: sizes of axes along which a normal matrix says nothing."""
_NONE = 1e-12  # of the variance expected: less is that of frames that are made up


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


def hac_samples(n_samples: int, *, n_neighbours: int) -> float:
    """How many independent samples would estimate a covariance as well as `hac_covariance` does.

    Parameters
    ----------
    n_samples, n_neighbours
        Scores, and neighbours to either side.

    Notes
    -----
    Where scores are white, variances are those of n samples times the sum of the squared weights (Andrews, Econometrica 59
    (1991) 817).
    """
    weights = np.arange(1, n_neighbours + 1) / (n_neighbours + 1)
    return float(n_samples / (1 + 2 * np.sum(weights**2)))


def shrunk(estimated: Array, expected: Array, *, n_samples: float) -> Array:
    """A covariance of few samples, its correlations drawn to those expected by as much as they differ by chance.

    A covariance that few samples estimate is too small along some axes by chance. Its variances are right on average, but what
    weighs by its inverse trusts those axes most.

    Parameters
    ----------
    estimated
        Shape (n, n); its diagonal stays as it is.
    expected
        Shape (n, n), positive; only its correlations matter.
    n_samples
        Independent samples that made the estimate.

    Returns
    -------
    Shape (n, n).

    Notes
    -----
    Ledoit and Wolf (Journal of Multivariate Analysis 88 (2004) 365) with a target that has the estimate's variances (Schaefer
    and Strimmer, Statistical Applications in Genetics and Molecular Biology 4 (2005) 32). S being the estimate in units of the
    target, the target's share is E|S - Sigma|^2 / |S - 1|^2, at most 1. Of Gaussian samples the numerator is
    (tr(S)^2 + tr(S^2)) / n_samples, of which (n - 1) / (n + 1) is left where variances are held.
    """
    n, scale = len(estimated), np.sqrt(np.maximum(np.diag(estimated) / np.diag(expected), _NONE))
    target = expected * np.outer(scale, scale)
    half = np.linalg.inv(root(target))
    there = half @ estimated @ half.T
    chance = (float(np.trace(there)) ** 2 + float(np.sum(there**2))) / n_samples * (n - 1) / (n + 1)
    apart = float(np.sum((there - np.eye(n)) ** 2))
    share = min(1.0, chance / apart) if apart > 0 else 0.0
    return np.asarray(estimated + share * (target - estimated))
