"""Least squares whose residuals differ from the model by more than noise, and alike within a cluster (White 1982, Liang 1986).

Residuals are in units of their noise. Within a cluster they may err together, as pixels do that share a mask's edge; so the
gradients of clusters are what scatters independently, and in no direction less than noise alone would make them.
"""

import numpy as np

from irtiming.records.arrays import Array, Ticks

_FLAT = 1e-12  # of the largest: sizes of axes along which residuals say nothing


def covariance(jacobian: Array, residual: Array, *, clusters: Ticks) -> Array:
    """Of the parameters, shape (n, n), in no direction smaller than noise and prior knowledge alone would make it.

    Parameters
    ----------
    jacobian, residual
        Shapes (m, n) and (m,).
    clusters
        Shape (m,); numbers of the clusters, -1 for what is known beforehand, which is taken at its word.
    """
    axes, root, turn, scale = _along_axes(jacobian, residual, clusters)
    half = axes / root @ turn / scale[:, None]
    return np.asarray(half @ half.T)


def normal_matrix(jacobian: Array, residual: Array, *, clusters: Ticks) -> Array:
    """Inverse of that, shape (n, n), zero along axes of which residuals say nothing.

    Parameters
    ----------
    jacobian, residual, clusters
        Shapes (m, n), (m,) and (m,); as of `covariance`.
    """
    axes, root, turn, scale = _along_axes(jacobian, residual, clusters)
    half = np.where(root**2 > _FLAT * np.max(root) ** 2, axes * root, 0.0) @ np.linalg.inv(turn).T * scale[:, None]
    return np.asarray(half @ half.T)


def _along_axes(jacobian: Array, residual: Array, clusters: Ticks) -> tuple[Array, Array, Array, Array]:
    """Axes A (n, n) of the scaled normal matrix, roots R (n,) of its sizes, what takes noise to scores, and scales (n,).

    The covariance is that of A R^-1 T x over the scales, x being white.
    """
    scale = np.sqrt(np.einsum("ij,ij->j", jacobian, jacobian))
    scale = np.where(scale > 0, scale, 1.0)
    scaled = jacobian / scale
    sizes, axes = np.linalg.eigh(scaled.T @ scaled)
    root = np.sqrt(np.maximum(sizes, _FLAT))  # the largest lies between 1 and n
    white = (scaled @ axes) / root
    scores = np.array([np.bincount(clusters + 1, one)[1:] for one in (white * residual[:, None]).T])
    known = white[clusters < 0]
    spread, turn = np.linalg.eigh(scores @ scores.T + known.T @ known)
    return axes, root, turn * np.sqrt(np.maximum(spread, 1.0)), scale
