"""A sum of squares of many residuals as one of few: what a search needs to know of them, and no more."""

import numpy as np

from irtiming.inference.optimiser import Linearised
from irtiming.records.arrays import Array

_LEAST = 1e-15  # of an eigenvalue, in units of each parameter's own; the largest lies between 1 and their number


def condensed(*, deviance: float, gradient: Array, normal: Array) -> Linearised:
    """As many residuals as parameters and one more, with the same deviance, gradient and normal equations.

    Parameters
    ----------
    deviance
        Sum of squares, not negative; may be any other measure that has these derivatives, such as n log(variance).
    gradient
        Shape (n,); direction in which it falls: half its gradient with the sign turned.
    normal
        Shape (n, n); half its curvature: the normal equations' matrix.
    """
    # of a parameter that nothing tells, rounding may leave less than zero
    scale = np.sqrt(np.maximum(np.diag(normal), 0.0))
    scale = np.where(scale > 0, scale, 1.0)
    sizes, axes = np.linalg.eigh(normal / np.outer(scale, scale))
    root = np.sqrt(np.maximum(sizes, _LEAST))
    determined = -(axes.T @ (gradient / scale)) / root
    rest = np.sqrt(max(deviance - float(determined @ determined), 0.0))
    jacobian = root[:, None] * axes.T * scale
    return Linearised(residual=np.append(determined, rest), jacobian=np.vstack([jacobian, np.zeros((1, scale.size))]))
