r"""Generalised least squares of values over one setting: a level, a line, and a line with one step.

.. math:: \hat b = (X^T V^{-1} X)^{-1} X^T V^{-1} y, \qquad \chi^2 = (y - X \hat b)^T V^{-1} (y - X \hat b)

V has what the values have in common too. With V from the budgets, the covariance of the coefficients is
:math:`(X^T V^{-1} X)^{-1}`; nothing is scaled by chi-squared here.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.special import chdtrc

from irtiming.records.arrays import Array
from irtiming.records.setting_series import LineFit, Step

_SIDE = 2  # values on either side of a step


def fit(design: Array, y: Array, *, covariance: Array) -> LineFit:
    """Generalised least squares.

    Parameters
    ----------
    design
        Shape (n, k), of rank k.
    y
        Shape (n,).
    covariance
        Of y, shape (n, n), positive definite.
    """
    scale = np.max(np.abs(design), axis=0)  # columns of a like size: settings may be microseconds
    scaled = design / scale
    solved = np.linalg.solve(covariance, scaled)
    found = np.linalg.inv(scaled.T @ solved)
    best = found @ solved.T @ y
    rest = y - scaled @ best
    chi_squared = float(rest @ np.linalg.solve(covariance, rest))
    freedom = y.size - design.shape[1]
    return LineFit(
        coefficients=best / scale,
        covariance=found / np.outer(scale, scale),
        residuals=rest,
        chi_squared=chi_squared,
        degrees_of_freedom=freedom,
        probability=float(chdtrc(freedom, chi_squared)) if freedom > 0 else 1.0,
    )


def level(y: Array, *, covariance: Array) -> LineFit:
    """The one value that all are; shape of y (n,)."""
    return fit(np.ones((y.size, 1)), y, covariance=covariance)


def line(x: Array, y: Array, *, covariance: Array) -> LineFit:
    """Value at x = 0, and slope; shapes (n,), of at least two different x."""
    return fit(np.column_stack([np.ones_like(x), x]), y, covariance=covariance)


def step(x: Array, y: Array, *, covariance: Array) -> Step | None:
    """A line of one slope with a step, at the place between two settings where it fits best.

    Parameters
    ----------
    x, y
        Shape (n,).
    covariance
        Of y, shape (n, n).

    Returns
    -------
    None where there are too few values: two on either side, and one more than the line with its step takes.
    """
    plain, places = line(x, y, covariance=covariance), np.unique(x)
    found: list[tuple[float, Step]] = []
    for after, before in pairwise(places):
        is_beyond = x > after
        if min(is_beyond.sum(), (~is_beyond).sum()) < _SIDE:
            continue
        design = np.column_stack([np.ones_like(x), x, is_beyond.astype(np.float64)])
        if np.linalg.matrix_rank(design / np.max(np.abs(design), axis=0)) < design.shape[1]:
            continue
        one = fit(design, y, covariance=covariance)
        u = float(np.sqrt(one.covariance[2, 2]))
        found.append(
            (plain.chi_squared - one.chi_squared,
             Step(after=float(after), before=float(before), size=float(one.coefficients[2]), standard_uncertainty=u, p_value=1.0))
        )  # fmt: skip
    if not found:
        return None
    gain, best = max(found, key=lambda each: each[0])
    p_value = min(1.0, len(found) * float(chdtrc(1, max(gain, 0.0))))
    return replace(best, p_value=p_value)


def line_weights(x: Array, y: Array, *, covariance: Array, at: float) -> tuple[Array, float]:
    """Weights by which values at x make the value at another place of their generalised least-squares line, and chi-squared.

    Parameters
    ----------
    x, y
        Shape (n,).
    covariance
        Of y, shape (n, n), positive definite.
    at
        Where the line is wanted.
    """
    design = np.column_stack([np.ones_like(x), (x - at) / np.ptp(x)])
    solved = np.linalg.solve(covariance, design)
    weights = np.linalg.solve(design.T @ solved, solved.T)
    rest = y - design @ (weights @ y)
    return weights[0], float(rest @ np.linalg.solve(covariance, rest))
