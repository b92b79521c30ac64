"""A smooth curve over one axis: cubic splines on equal intervals, from a straight line to as many bends as wanted."""

import numpy as np
from scipy.interpolate import BSpline

from irtiming.records.arrays import Array


def columns(place: Array, n_intervals: int) -> Array:
    """What such a curve is made of beside a constant.

    Parameters
    ----------
    place
        Shape (n,); from 0 to 1.
    n_intervals
        Of the spline; 0 for a straight line.

    Returns
    -------
    Shape (n, k): the straight line, or all cubic B-splines but one, which the constant stands for.
    """
    if n_intervals == 0:
        return np.asarray(place[:, None] - 0.5)
    knots = np.concatenate([np.zeros(3), np.linspace(0, 1, n_intervals + 1), np.ones(3)])
    return np.asarray(BSpline.design_matrix(np.clip(place, 0, 1), knots, 3).toarray()[:, 1:])
