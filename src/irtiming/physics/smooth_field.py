"""A smooth field over a part of the image: what a solid wheel reflects of the camera, say.

It is a sum of Gaussian basis functions on a grid, as wide as the grid's steps; without those a step beyond the region its ends
could not be met. Each is a product of one along the rows with one along the columns, so that sums over pixels are products of
small matrices.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Self, final

import numpy as np

from irtiming.records.arrays import Array

_STEPS = 10  # of the grid from end to end: the reflection of a small aperture is a narrow one


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SmoothField:
    """Basis functions of a smooth field over a region of r rows and c columns.

    Parameters
    ----------
    along_rows, along_columns
        Shapes (k, r) and (l, c); basis function i l + j is the product of row i of the one and row j of the other.
    """

    along_rows: Array
    along_columns: Array

    @classmethod
    def over(cls, rows: Array, columns: Array, *, steps: int = _STEPS) -> Self:
        """Basis over pixels at these places along each axis, ascending, shapes (r,) and (c,)."""
        return cls(along_rows=_along(rows, steps), along_columns=_along(columns, steps))

    @property
    def size(self) -> int:
        """Number n of basis functions."""
        return len(self.along_rows) * len(self.along_columns)

    def sums(self, image: Array) -> Array:
        """Sum over the pixels of each basis function times an image of shape (r, c); shape (n,)."""
        return np.asarray(self.along_rows @ image @ self.along_columns.T).ravel()

    def products(self, weight: Array) -> Array:
        """Sum over the pixels of each two basis functions times a weight of shape (r, c); shape (n, n)."""
        n_rows, n_columns = len(self.along_rows), len(self.along_columns)
        both = self._row_pairs @ (weight @ self._column_pairs.T)
        return np.asarray(
            both.reshape(n_rows, n_rows, n_columns, n_columns).transpose(0, 2, 1, 3).reshape(self.size, self.size)
        )

    @cached_property
    def _row_pairs(self) -> Array:
        return _pairs(self.along_rows)

    @cached_property
    def _column_pairs(self) -> Array:
        return _pairs(self.along_columns)

    def at(self, heights: Array) -> Array:
        """The field that the basis functions make with heights of shape (n,); shape (r, c)."""
        height = heights.reshape(len(self.along_rows), len(self.along_columns))
        return np.asarray(self.along_rows.T @ height @ self.along_columns)


def _along(places: Array, steps: int) -> Array:
    step = (places[-1] - places[0]) / steps
    tops = places[0] + step * np.arange(-1, steps + 2)
    return np.asarray(np.exp(-0.5 * ((places - tops[:, None]) / step) ** 2))


def _pairs(along: Array) -> Array:
    """Products of each two rows, shape (k^2, p)."""
    return np.asarray((along[:, None] * along).reshape(-1, along.shape[1]))
