r"""How well a set of runs can tell what is sought: Fisher information, run by run, and the uncertainty that comes of it.

One run tells the parameters p with an information matrix J = sum over its samples of (df/dp) (df/dp)^T / sigma^2. What a run has
for itself (its level, its step, its drift) is eliminated within; what all runs share stays. Information of independent runs
adds. The rig's angle errors are parameters too, counted in units of their standard uncertainty, so that what rig.toml says of
them is an information of 1. The inverse of the sum is the covariance C of the best estimate (Cramer and Rao):

.. math:: C = (\sum_f n_f J_f + P)^{-1},\quad P = 1 \text{ for the angle errors, 0 else}

and C = C (sum n J) C + C P C splits it into noise and the angle errors, source by source. With one wheel speed an angle error
looks like a delay and stays; with several it does not, and the frames tell them apart.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias, final

import numpy as np

from irtiming.errors import PlanError
from irtiming.physics.covariance import inverse
from irtiming.records.arrays import Array
from irtiming.records.prediction import PredictedPart, PredictedUncertainty

NOISE = "noise of the frames"
EDGES = "cutout edges"

Weights: TypeAlias = Mapping[str, Mapping[str, float]]
"""What is asked for, by name: each a sum of parameters with these weights."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Information:
    """Of one run: ``matrix`` (n, n) over the parameters ``names``, then over the errors named in ``sources``.

    Several errors may have the same source; each has a standard uncertainty of 1.
    """

    names: tuple[str, ...]
    sources: tuple[str, ...]
    matrix: Array

    def times(self, n_runs: float) -> "Information":
        """That of so many runs."""
        return Information(names=self.names, sources=self.sources, matrix=self.matrix * n_runs)


def total(parts: Sequence[Information]) -> Information:
    """Information of independent runs together.

    Raises
    ------
    PlanError
        If they do not have the same parameters and errors.
    """
    first = parts[0]
    if any((part.names, part.sources) != (first.names, first.sources) for part in parts):
        raise PlanError(
            "the runs do not have the same parameters, so their information cannot be added; plan them apart"
        )
    return Information(names=first.names, sources=first.sources, matrix=np.sum([part.matrix for part in parts], axis=0))


def apart(delayed: Information, reference: Information) -> Information:
    """Information of two sets of runs with two set delays: the difference of their delays is the parameter relative_delay."""
    at, n = delayed.names.index("trigger_delay"), len(delayed.matrix)
    without = np.concatenate([np.zeros((n, 1)), np.eye(n)], axis=1)
    spread = without.copy()
    spread[at, 0] = 1.0
    matrix = spread.T @ delayed.matrix @ spread + without.T @ reference.matrix @ without
    return Information(names=("relative_delay", *delayed.names), sources=delayed.sources, matrix=matrix)


def covariance(one: Information) -> Array:
    """Covariance of parameters and errors, shape (n, n).

    Raises
    ------
    PlanError
        If nothing is told of one of them.
    """
    told = one.matrix + np.diag(_known(one))
    if not np.all(np.diag(told) > 0):
        raise PlanError(
            f"nothing is told of {one.names[int(np.argmin(np.diag(told)))]}; plan another measurement for it"
        )
    return inverse(told)


def uncertainties(one: Information, weights: Weights) -> tuple[PredictedUncertainty, ...]:
    """Predicted standard uncertainty of each sum of parameters, with its parts: noise, and the errors by source."""
    spread = covariance(one)
    known = _known(one)
    found = []
    for name, share in weights.items():
        row = np.array([share.get(parameter, 0.0) for parameter in one.names] + [0.0] * len(one.sources)) @ spread
        by_error = row**2 * known
        squares = {NOISE: float(row @ one.matrix @ row)}
        for source, square in zip(one.sources, by_error[len(one.names) :], strict=True):
            squares[source] = squares.get(source, 0.0) + float(square)
        parts = tuple(
            PredictedPart(source=source, standard_uncertainty_s=float(np.sqrt(max(square, 0.0))))
            for source, square in squares.items()
        )
        found.append(
            PredictedUncertainty(
                name=name, standard_uncertainty_s=float(np.sqrt(max(sum(squares.values()), 0.0))), parts=parts
            )
        )
    return tuple(found)


def variances(one: Information, weights: Weights) -> Array:
    """Squares of the uncertainties alone, shape (n_asked,), where many sets of runs are compared; s^2."""
    rows = np.array([[share.get(name, 0.0) for name in one.names] for share in weights.values()])
    n = len(one.names)
    return np.asarray(np.einsum("ki,ij,kj->k", rows, covariance(one)[:n, :n], rows))


def _known(one: Information) -> Array:
    """Information that is there without any run: 1 for each error."""
    return np.array([0.0] * len(one.names) + [1.0] * len(one.sources))


def without_own(columns: Array, own: Array) -> Array:
    """Columns less what a run's own parameters could take over.

    Parameters
    ----------
    columns, own
        Shapes (n, k) and (n, j); derivatives over the noise of each sample.

    Returns
    -------
    Shape (n, k), orthogonal to ``own``.
    """
    basis, _ = np.linalg.qr(own / np.maximum(np.linalg.norm(own, axis=0), 1e-300))
    return np.asarray(columns - basis @ (basis.T @ columns))
