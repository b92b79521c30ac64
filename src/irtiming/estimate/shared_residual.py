r"""What the residuals of all recordings share at the same wheel angle is not noise but a property of the rig.

A mask edge that is not straight, a mask plate as warm as neither wheel nor blackbody, a slot that is off: each leaves the
same trace in every recording. To the wheel it is an error of each edge's angle, the same in all recordings: it widens the
absolute delay at one speed, and cancels in relative delays and between speeds. What counts there is each recording's own noise.

With r_f the residuals of recording f over its noise, F waves around the wheel, and all that the recording's own fit can take from
residuals projected out, b_f = F^T r_f and G_f = F^T F are what the waves say. With white noise of variance v_f, found by
differences of neighbours along the angle (Hall, Kay and Titterington, Biometrika 77 (1990) 521),

.. math:: \sum_f b_f^T G_f^{-1} b_f / v_f - \bar b^T \bar G^{-1} \bar b, \qquad \bar b = \sum_f b_f / v_f, \quad \bar G = \sum_f
    G_f / v_f

is chi-square distributed with (n - 1) k degrees of freedom, k the number of waves, whatever the recordings share. Where it is
larger, waves that are a recording's own stand beside the white noise, and variances grow by that ratio. It is never taken for
less than 1: a recording has at least its white noise.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import comb
from typing import TypeAlias, final

import numpy as np

from irtiming.records.arrays import Array

_WAVES = 20  # of the turn: down to a quarter of a slope of 75 deg; what is shorter averages out over a slope
_DIFFERENCES = 4
_LEAST = 1e-15
_LEAST_INFORMATION = 0.1  # of the best determined wave: one that the fit has taken away says nothing


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Trace:
    """Residuals of one recording along the wheel angle.

    Shapes (n,): ``angle_rad`` in [0, 2 pi), ``residual`` over the noise. ``taken`` (n, k) is an orthonormal basis of all that the
    recording's own fit can take from its residuals.
    """

    angle_rad: Array
    residual: Array
    taken: Array


TraceModel: TypeAlias = Callable[[Mapping[str, float]], Trace]
"""Residuals at named local numbers."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SharedResidual:
    """What of the residuals is each recording's own, and what all share; variances in units of the noise that was assumed.

    ``own`` (n_fit,) and ``shared`` (n_fit,) are the variances per frame; ``degrees_of_freedom`` say how well ``own`` is known.
    """

    own: Array
    shared: Array
    degrees_of_freedom: float


def split(traces: Sequence[Trace]) -> SharedResidual | None:
    """The noise of each recording and the structure that all share; None of a single recording, where nothing tells them apart.

    Parameters
    ----------
    traces
        One per recording.
    """
    if len(traces) < 2:
        return None
    white = np.array([_white_variance(one) for one in traces])
    per_fit = [_waves(one) for one in traces]
    matrices = np.array([matrix for matrix, _ in per_fit])
    gradients = np.array([gradient for _, gradient in per_fit])
    sizes, axes = np.linalg.eigh(np.sum(matrices / white[:, None, None], axis=0))
    determined = axes[:, sizes > _LEAST_INFORMATION * sizes[-1]]
    matrices, gradients = determined.T @ matrices @ determined, gradients @ determined
    whole = np.sum(matrices / white[:, None, None], axis=0)
    common = np.linalg.solve(whole, np.sum(gradients / white[:, None], axis=0))
    apart = gradients - matrices @ common
    square = float(np.sum(np.einsum("fk,fk->f", apart, _solved(matrices, apart)) / white))
    freedom = float((len(traces) - 1) * determined.shape[1])
    ratio = max(1.0, square / freedom)
    by_noise = ratio * np.trace(np.linalg.solve(whole, matrices), axis1=1, axis2=2)
    shared = (np.einsum("k,fkl,l->f", common, matrices, common) - by_noise) / determined.shape[1]
    return SharedResidual(
        own=ratio * white * _copies(traces), shared=np.maximum(shared, 0.0), degrees_of_freedom=freedom
    )


def all_own(n_fits: int) -> SharedResidual:
    """Nothing shared, and the noise as it was assumed.

    Parameters
    ----------
    n_fits
        Recordings.
    """
    return SharedResidual(own=np.ones(n_fits), shared=np.zeros(n_fits), degrees_of_freedom=np.inf)


def _copies(traces: Sequence[Trace]) -> Array:
    """How often each recording was given: copies of a file add nothing, shape (n_fit,)."""
    return np.array([sum(np.array_equal(one.residual, other.residual) for other in traces) for one in traces], float)


def _white_variance(trace: Trace) -> float:
    """Mean square of fourth differences along the angle, over that of white noise; never 0, as without any noise.

    What is smooth over five neighbours leaves no trace in them.
    """
    ordered = trace.residual[np.argsort(trace.angle_rad)]
    differences = np.diff(ordered, n=_DIFFERENCES)
    return max(float(np.mean(differences**2)) / comb(2 * _DIFFERENCES, _DIFFERENCES), _LEAST * float(ordered @ ordered))


def _waves(trace: Trace) -> tuple[Array, Array]:
    """What the waves around the wheel say beside what the fit can take: matrix (k, k) and gradient (k,)."""
    phase = np.outer(trace.angle_rad, np.arange(1, _WAVES + 1))
    waves = np.hstack([np.cos(phase), np.sin(phase)])
    free = waves - trace.taken @ (trace.taken.T @ waves)
    return free.T @ free, free.T @ trace.residual


def _solved(matrices: Array, vectors: Array) -> Array:
    """Each matrix (f, k, k) divided into its vector (f, k)."""
    return np.asarray(np.linalg.solve(matrices, vectors[:, :, None])[:, :, 0])
