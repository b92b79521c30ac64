r"""Distortion of a lens, in closed form where there is one.

A point at the undistorted distance r_u from the lens centre appears at

    r_d = r_u (1 + k r_u^2)

both in half diagonals of the image, hypot(rows, columns) / 2 px. The lens centre lies by ``off_row_px`` and ``off_column_px``
beside the middle of the image, ((rows - 1) / 2, (columns - 1) / 2). k is negative for a barrel, positive for a pincushion. A lens
that others calibrated has OpenCV's further terms: (x, y) being columns and rows from the lens centre and r their distance,

    x_d = x (1 + k r^2 + k_2 r^4 + k_3 r^6) + 2 p_1 x y + p_2 (r^2 + 2 x^2)
    y_d = y (1 + k r^2 + k_2 r^4 + k_3 r^6) + p_1 (r^2 + 2 y^2) + 2 p_2 x y

and rows that are f_y / f_x times as large. Straight lines are straight in the undistorted plane, called flat here; blur and
pixels act in the image.
"""

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias, final

import numpy as np
from numba import njit
from numba.extending import register_jitable

from irtiming.records.arrays import Array
from irtiming.records.row_timing import LensTerms

LOWEST, HIGHEST = -0.14, 0.5
"""Distortions between which every point of the image has one point in the flat plane; below -4/27 its corners have none."""

_TURNING, _FARTHEST = -4 / 27, 1.5  # k r_d^2 where r_d stops growing with r_u, and r_u / r_d there
_MOST_STEPS = 40
_NO_TERMS = LensTerms()

Place: TypeAlias = tuple[Any, Any]
"""Down and across, numbers or arrays that broadcast."""


@final
class Coefficients(NamedTuple):
    """k, k_2, k_3, p_1, p_2 and f_y / f_x; k may be an array."""

    distortion: Any
    quartic: float
    sextic: float
    tangential_row: float
    tangential_column: float
    row_stretch: float


@final
@dataclass(frozen=True, kw_only=True)
class Lens:
    """Distortion k, size of the image, lens centre and further terms; an image without a size is for no distortion at all.

    Distortion and lens centre may be arrays that broadcast against places: where many lenses show them, and they many lenses.
    """

    distortion: Any
    rows: int
    columns: int
    off_row_px: Any = 0.0
    off_column_px: Any = 0.0
    terms: LensTerms = field(default_factory=LensTerms)

    @property
    def middle_px(self) -> tuple[float, float]:
        """Row and column of the lens centre: the point that stays."""
        return (self.rows - 1) / 2 + self.off_row_px, (self.columns - 1) / 2 + self.off_column_px

    @property
    def half_diagonal_px(self) -> float:
        """Unit of the distances."""
        return math.hypot(self.rows, self.columns) / 2

    @property
    def is_straight(self) -> bool:
        """Whether image and flat plane are the same."""
        return not np.any(self.distortion) and self.terms == _NO_TERMS

    def seen(self, row_px: Any, column_px: Any) -> tuple[Any, Any]:
        """Where points of the flat plane appear; numbers or arrays that broadcast, px."""
        if self.is_straight:
            return row_px, column_px
        unit, (row, column) = self.half_diagonal_px, self.middle_px
        down, across = bent(((row_px - row) / unit, (column_px - column) / unit), self.coefficients)
        return row + unit * down, column + unit * across

    def flat(self, row_px: Any, column_px: Any) -> tuple[Any, Any]:
        """Where points of the image lie in the flat plane; numbers or arrays that broadcast, px."""
        if self.is_straight:
            return row_px, column_px
        if self.terms != _NO_TERMS:
            return self._flat_by_search(row_px, column_px)
        down, across = row_px - self.middle_px[0], column_px - self.middle_px[1]
        square = (down**2 + across**2) / self.half_diagonal_px**2
        factor = _flattening(np.atleast_1d(np.asarray(self.distortion * square, dtype=float)).ravel())
        factor = factor.reshape(np.shape(square)) if np.ndim(square) else float(factor[0])
        return self.middle_px[0] + down * factor, self.middle_px[1] + across * factor

    def _flat_by_search(self, row_px: Any, column_px: Any) -> tuple[Any, Any]:
        unit = self.half_diagonal_px
        down, across, distortion = (
            np.asarray(one, dtype=float)
            for one in np.broadcast_arrays(
                (row_px - self.middle_px[0]) / unit,
                (column_px - self.middle_px[1]) / unit,
                self.distortion,
            )
        )
        y, x = _flat_points(
            down.ravel(), across.ravel(), distortion.ravel(), self.coefficients._replace(distortion=0.0)
        )
        if down.ndim == 0:
            return self.middle_px[0] + unit * float(y[0]), self.middle_px[1] + unit * float(x[0])
        return self.middle_px[0] + unit * y.reshape(down.shape), self.middle_px[1] + unit * x.reshape(down.shape)

    @property
    def coefficients(self) -> Coefficients:
        """Of the polynomials of `bent`."""
        terms = self.terms
        return Coefficients(
            distortion=self.distortion,
            quartic=terms.quartic,
            sextic=terms.sextic,
            tangential_row=terms.tangential_row,
            tangential_column=terms.tangential_column,
            row_stretch=terms.row_stretch,
        )


@register_jitable
def bent(place: Place, of: Coefficients) -> Place:
    """(y_d, x_d) of a point (y, x) of the flat plane, half diagonals, with the rows' stretch."""
    y, x = place
    square = y * y + x * x
    factor = 1 + square * (of.distortion + square * (of.quartic + square * of.sextic))
    first, second = of.tangential_row, of.tangential_column
    return (
        (y * factor + first * (square + 2 * y * y) + 2 * second * y * x) * of.row_stretch,
        x * factor + 2 * first * y * x + second * (square + 2 * x * x),
    )


@njit(cache=True, nogil=True)
def _slopes(place: Place, of: Coefficients) -> Any:
    """Derivatives of y_d to y and x, then of x_d to y and x; half diagonals."""
    y, x = place
    square, first, second = y * y + x * x, of.tangential_row, of.tangential_column
    factor = 1 + square * (of.distortion + square * (of.quartic + square * of.sextic))
    growth = 2 * (of.distortion + square * (2 * of.quartic + 3 * square * of.sextic))
    yy = factor + y * y * growth + 6 * first * y + 2 * second * x
    xx = factor + x * x * growth + 2 * first * y + 6 * second * x
    mixed = y * x * growth + 2 * first * x + 2 * second * y
    return yy * of.row_stretch, mixed * of.row_stretch, mixed, xx


@njit(cache=True, nogil=True)
def magnified(place: Place, of: Coefficients) -> Any:
    """Least magnification of any direction and that of areas at a point of the flat plane, half diagonals."""
    yy, yx, xy, xx = _slopes(place, of)
    area = yy * xx - yx * xy
    whole = yy * yy + yx * yx + xy * xy + xx * xx
    largest = math.sqrt((whole + math.sqrt(max(whole * whole - 4 * area * area, 0.0))) / 2)
    return abs(area) / largest, area


@njit(cache=True, nogil=True)
def _flat_points(down: Array, across: Array, distortion: Array, other: Coefficients) -> Any:
    """Newton's method for the point (y, x) that appears at (down, across), shapes (n,); half diagonals."""
    out = np.empty((2, down.size))
    for k in range(down.size):
        of = Coefficients(
            distortion[k], other.quartic, other.sextic, other.tangential_row, other.tangential_column, other.row_stretch
        )
        y, x = down[k], across[k]
        for _ in range(_MOST_STEPS):
            seen_y, seen_x = bent((y, x), of)
            off_y, off_x = seen_y - down[k], seen_x - across[k]
            yy, yx, xy, xx = _slopes((y, x), of)
            whole = yy * xx - yx * xy
            if whole < 0.05:  # beyond the turning point there is no such point
                break
            step_y, step_x = (xx * off_y - yx * off_x) / whole, (yy * off_x - xy * off_y) / whole
            y, x = y - step_y, x - step_x
            if abs(step_y) + abs(step_x) < 1e-12:
                break
        out[0, k], out[1, k] = y, x
    return out


@njit(cache=True, nogil=True)
def _flattening(bend: Array) -> Any:
    """r_u / r_d = g for k r_d^2 = bend, shape (n,): Newton's method for g (1 + bend g^2) = 1."""
    out = np.empty(bend.size)
    for k in range(bend.size):
        if bend[k] <= _TURNING:
            out[k] = _FARTHEST
            continue
        g = 1.0 - bend[k] if bend[k] < 0 else 1 / (1 + bend[k])
        for _ in range(_MOST_STEPS):
            square = bend[k] * g * g
            step = (g * (1 + square) - 1) / (1 + 3 * square)
            g -= step
            if abs(step) < 1e-12:
                break
        out[k] = g
    return out
