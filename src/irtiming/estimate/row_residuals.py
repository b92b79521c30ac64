"""What the residuals say: a covariance that holds when they are correlated among rows and along the wheel angle."""

import numpy as np

from irtiming.physics.covariance import hac_covariance, hac_samples, shrunk
from irtiming.records.arrays import Array

_CORRELATED_FRAMES = 8  # neighbours whose residuals may be correlated
_CORRELATED_TURN = 8e-3  # of a turn: how far along the wheel angle, where repeats of a turn lie close together


def robust_covariance(scores: Array, normal: Array) -> tuple[Array, float]:
    """Covariance from the scores of the frames, and by how much it exceeds that of white residuals.

    Parameters
    ----------
    scores
        Shape (n, k); gradient of the log-likelihood that each frame contributes with all its rows, sorted by wheel angle.
        Frames with the same noise in all rows, or neighbours with the same error of the model, show here.
    normal
        Shape (k, k); inverse covariance were the residuals white.

    Returns
    -------
    Covariance, shape (k, k), nowhere smaller on its diagonal than for white residuals; and the mean factor on the variances.

    Notes
    -----
    `physics.covariance.hac_covariance` on the circle of the wheel angle, with as many neighbours as lie within 3 degrees, 8 at
    least: what the model misses at an angle is there in each repeat of the turn. Its correlations are drawn to
    those of white residuals by as much as they differ by chance: what combines several recordings weighs by its inverse.
    """
    neighbours = max(_CORRELATED_FRAMES, round(_CORRELATED_TURN * len(scores)))
    middle = hac_covariance(scores, n_neighbours=neighbours, is_circular=True)
    white = np.asarray(np.linalg.inv(normal), dtype=float)
    n_samples = hac_samples(len(scores), n_neighbours=neighbours)
    found = shrunk(white @ middle @ white, white, n_samples=n_samples)
    ratio = np.diag(found) / np.diag(white)
    stretch = np.sqrt(np.maximum(1.0, 1 / np.maximum(ratio, 1e-3)))
    found = found * np.outer(stretch, stretch)
    return found, max(1.0, float(np.mean(ratio)))


def inflated_in_time(covariance: Array, scores: Array, *, normal: Array) -> Array:
    """The covariance, no smaller than that of frames correlated in the order of the triggers.

    Parameters
    ----------
    covariance
        Shape (k, k); as known so far.
    scores, normal
        As for `robust_covariance`, frames in the order of their triggers.
    """
    middle = hac_covariance(scores, n_neighbours=_CORRELATED_FRAMES, is_circular=False)
    white = np.linalg.inv(normal)
    stretch = np.sqrt(np.maximum(1.0, np.diag(white @ middle @ white) / np.diag(covariance)))
    return np.asarray(covariance * np.outer(stretch, stretch))
