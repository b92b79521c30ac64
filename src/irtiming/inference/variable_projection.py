"""Parameters that a model is linear in, taken out of its residuals: separable least squares.

Golub and Pereyra, Inverse Problems 19 (2003) R1; derivatives in Kaufman's approximation, which has the same minimum.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

from irtiming.inference import orthonormal
from irtiming.inference.optimiser import Linearised
from irtiming.records.arrays import Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Projected:
    """The model without its linear parameters, and these at their best, shape (j,); ``basis`` (m, k) spans their shapes."""

    at: Linearised
    levels: Array
    basis: Array


def project(data: Array, shapes: Array, *, slopes_of: Callable[[Array], Array]) -> Projected:
    """Residuals of data that are a sum of shapes, at the best amounts of each.

    Parameters
    ----------
    data
        Shape (m,), in units of its standard deviation.
    shapes
        Shape (m, j); what the linear parameters multiply, in the same units.
    slopes_of
        Called with the linear parameters (j,); derivatives of the model, shape (m, n), to the others.
    """
    found = orthonormal.of(shapes)
    basis = found.columns
    along = basis.T @ data
    levels = found.amounts(along)
    slopes = slopes_of(levels)
    return Projected(
        at=Linearised(residual=data - basis @ along, jacobian=basis @ (basis.T @ slopes) - slopes),
        levels=levels,
        basis=basis,
    )
