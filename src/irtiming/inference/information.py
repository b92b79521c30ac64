r"""One algebra for all that is known: pieces of information on named numbers that add.

A piece of information says of some numbers p that its deviance is

.. math:: D(p_0 + x) = D(p_0) - 2 g^T x + x^T J x

(the normal equations: gradient g, matrix J). Recordings give such pieces, and so do rig.toml, images and a person's plan. Pieces
from independent sources add, whatever numbers each speaks of. With C the inverse of the whole matrix the best estimate is
:math:`p_0 + C \sum g`, its covariance C (Cramer and Rao), and since

.. math:: C = \sum_s C J_s C

each source s has its share in the variance of any weighted sum of the numbers: the uncertainty budget.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias, final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.inference import orthonormal
from irtiming.physics.covariance import inverse
from irtiming.records.arrays import Array

Weights: TypeAlias = Mapping[str, float]
"""A sum of numbers, by name, with these weights."""

EvaluationType: TypeAlias = Literal["A", "B"]
"""As in the GUM: from the scatter of this measurement, or from elsewhere."""

NOISE = "noise of the frames"
"""Source of what the frames themselves say."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Information:
    """What one source says of some numbers.

    Parameters
    ----------
    source
        Where it comes from, as a budget names it; ``kind`` A or B as in the GUM.
    names
        Numbers that it speaks of.
    matrix
        Shape (n, n), per product of their units.
    gradient
        Shape (n,); 0 where these numbers stand at their best for this source.
    """

    source: str
    names: tuple[str, ...]
    matrix: Array
    gradient: Array
    kind: EvaluationType = "A"

    def times(self, n: float) -> "Information":
        """The same from so many independent repetitions."""
        return replace(self, matrix=self.matrix * n, gradient=self.gradient * n)

    def of(self, names: Sequence[str], design: Array) -> "Information":
        """The same in other numbers, of which ``design`` (n, k) makes these."""
        return replace(
            self, names=tuple(names), matrix=design.T @ self.matrix @ design, gradient=design.T @ self.gradient
        )

    def without(self, *names: str) -> "Information":
        """What is left where some of the numbers may be anything (Schur complement); they stay, with nothing said of them."""
        if not names:
            return self
        keep = self.forgetting(*names)
        return replace(self, matrix=keep @ self.matrix @ keep.T, gradient=keep @ self.gradient)

    def forgetting(self, *names: str) -> Array:
        """Projection (n, n) that takes from a gradient what it says of some numbers: 1 - J E (E^T J E)^-1 E^T."""
        alone = np.eye(len(self.names))[:, [self.names.index(name) for name in names]]
        if not names:
            return np.eye(len(self.names))
        return np.asarray(
            np.eye(len(self.names)) - self.matrix @ alone @ inverse(alone.T @ self.matrix @ alone) @ alone.T
        )


def prior(name: str, u: float, *, source: str, kind: EvaluationType = "B", gap: float = 0.0) -> Information:
    """What is known of one number beforehand.

    Parameters
    ----------
    name, u
        The number and its standard uncertainty, in its unit.
    source, kind
        Who says so.
    gap
        By how much the value known beforehand exceeds the present one, same unit.
    """
    return Information(
        source=source, kind=kind, names=(name,), matrix=np.array([[u**-2.0]]), gradient=np.array([gap / u**2])
    )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Combined:
    """All pieces together.

    ``names`` (n,) are the numbers that any piece speaks of, ``covariance`` (n, n) theirs, ``step`` (n,) what they move to their
    best; ``parts`` are the pieces, each over all names.
    """

    names: tuple[str, ...]
    parts: tuple[Information, ...]
    covariance: Array = field(repr=False)

    @property
    def step(self) -> Array:
        """To the best estimate, shape (n,)."""
        return np.asarray(self.covariance @ np.sum([part.gradient for part in self.parts], axis=0))

    def row(self, weights: Weights) -> Array:
        """The weights in the order of ``names``, shape (n,).

        Parameters
        ----------
        weights
            Of numbers among ``names``.

        Raises
        ------
        EstimationError
            If nothing is said of one of them.
        """
        unknown = sorted(set(weights) - set(self.names))
        if unknown:
            raise EstimationError(f"nothing is said of {', '.join(unknown)}; the numbers are {', '.join(self.names)}")
        return np.array([weights.get(name, 0.0) for name in self.names])

    def variance(self, weights: Weights) -> float:
        """Of a sum of numbers."""
        row = self.row(weights)
        return float(row @ self.covariance @ row)

    def shares(self, weights: Weights) -> dict[str, float]:
        """What each source adds to that variance; sources in the order of their first piece."""
        follows = self.row(weights) @ self.covariance
        found: dict[str, float] = {}
        for part in self.parts:
            found[part.source] = found.get(part.source, 0.0) + float(follows @ part.matrix @ follows)
        return found


def combine(pieces: Iterable[Information]) -> Combined:
    """The sum of pieces from independent sources.

    Parameters
    ----------
    pieces
        One or more.

    Raises
    ------
    EstimationError
        If nothing is said of a number.
    """
    given = tuple(pieces)
    names = tuple(dict.fromkeys(name for piece in given for name in piece.names))
    parts = tuple(_over(piece, names) for piece in given)
    matrix = np.sum([part.matrix for part in parts], axis=0)
    silent = [name for name, information in zip(names, np.diag(matrix), strict=True) if not information > 0]
    if silent:
        raise EstimationError(f"nothing determines {', '.join(silent)}; plan another measurement for it")
    return Combined(names=names, parts=parts, covariance=inverse(matrix))


def _over(piece: Information, names: tuple[str, ...]) -> Information:
    if piece.names == names:
        return piece
    at = [names.index(name) for name in piece.names]
    matrix, gradient = np.zeros((len(names), len(names))), np.zeros(len(names))
    matrix[np.ix_(at, at)], gradient[at] = piece.matrix, piece.gradient
    return replace(piece, names=names, matrix=matrix, gradient=gradient)


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
    basis = orthonormal.of(own).columns
    return np.asarray(columns - basis @ (basis.T @ columns))
