"""What the residuals say: a covariance that holds when they are correlated among rows and along the wheel angle."""

import numpy as np

from irtiming.physics.covariance import hac_covariance, hac_samples, root, shrunk
from irtiming.records.arrays import Array

_CORRELATED_FRAMES = 8  # neighbours whose residuals may be correlated
_CORRELATED_TURN = 8e-3  # of a turn: how far along the wheel angle, where repeats of a turn lie close together
_MOST_TAKEN = 0.75  # of the scores' variance by the fit: fewer frames tell nothing of their correlation


def robust_covariance(scores: Array, normal: Array, *, information: Array) -> tuple[Array, float]:
    """Covariance from the scores of the frames, and by how much it exceeds that of white residuals.

    Parameters
    ----------
    scores
        Shape (n, k); gradient of the log-likelihood that each frame contributes with all its rows, sorted by wheel angle.
        Frames with the same noise in all rows, or neighbours with the same error of the model, show here.
    normal
        Shape (k, k); inverse covariance were the residuals white.
    information
        Shape (n, k, k); what each frame contributes to that.

    Returns
    -------
    Covariance, shape (k, k), nowhere smaller on its diagonal than for white residuals; and the mean factor on the variances.

    Notes
    -----
    `physics.covariance.hac_covariance` on the circle of the wheel angle, with as many neighbours as lie within 3 degrees, 8 at
    least: what the model misses at an angle is there in each repeat of the turn. Its correlations are drawn to those of white
    residuals by as much as they differ by chance: what combines several recordings weighs by its inverse.
    """
    neighbours = max(_CORRELATED_FRAMES, round(_CORRELATED_TURN * len(scores)))
    white = np.asarray(np.linalg.inv(normal), dtype=float)
    half = root(white)
    middle = hac_covariance(scores @ half, n_neighbours=neighbours, is_circular=True)
    restored = _restored(half.T @ information @ half, n_neighbours=neighbours)
    estimated = half @ restored @ middle @ restored @ half.T
    found = shrunk(estimated, white, n_samples=hac_samples(len(scores), n_neighbours=neighbours))
    ratio = np.diag(found) / np.diag(white)
    stretch = np.sqrt(np.maximum(1.0, 1 / np.maximum(ratio, 1e-3)))
    found = found * np.outer(stretch, stretch)
    return found, max(1.0, float(np.mean(ratio)))


def _restored(shares: Array, *, n_neighbours: int) -> Array:
    """What gives back to scores the scatter that the fit has taken from them, shape (k, k).

    A fit brings the sum of the scores to zero, and with it a part of what neighbours have in common: a few frames on one edge of
    the light make one edge's delay. Frame i having the share M_i of all information, scores that scatter as that have the
    covariance 1 - sum w_ij M_i M_j after the fit, w_ij being the weights of neighbours (as Bell and McCaffrey, Survey Methodology
    28 (2002) 169, for clusters).

    Parameters
    ----------
    shares
        Shape (n, k, k), in units in which they add up to 1.
    n_neighbours
        To either side, that are taken together.
    """
    taken = np.sum(
        [hac_covariance(one, n_neighbours=n_neighbours, is_circular=True) for one in shares.transpose(1, 0, 2)], axis=0
    )
    sizes, axes = np.linalg.eigh(taken)
    return np.asarray(axes / np.sqrt(1 - np.minimum(sizes, _MOST_TAKEN)) @ axes.T)


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
