r"""Radial distortion of a lens, in closed form where there is one.

A point at the undistorted distance r_u from the middle of the image appears at

    r_d = r_u (1 + k r_u^2)

both in half diagonals of the image, the middle being ((rows - 1) / 2, (columns - 1) / 2) and the half diagonal
hypot(rows, columns) / 2 px. k is negative for a barrel, positive for a pincushion. Straight lines, circles and angles of the rig
are straight, round and right in the undistorted plane, called flat here; blur and pixels act in the image.
"""

import math
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numba import njit

from irtiming.records.arrays import Array

LOWEST, HIGHEST = -0.14, 0.5
"""Distortions between which every point of the image has one point in the flat plane; below -4/27 its corners have none."""

_TURNING, _FARTHEST = -4 / 27, 1.5  # k r_d^2 where r_d stops growing with r_u, and r_u / r_d there
_MOST_STEPS = 40


@final
@dataclass(frozen=True, kw_only=True)
class Lens:
    """Distortion k and size of the image; an image without a size is for k = 0 only."""

    distortion: float
    rows: int
    columns: int

    @property
    def middle_px(self) -> tuple[float, float]:
        """Row and column of the point that stays."""
        return (self.rows - 1) / 2, (self.columns - 1) / 2

    @property
    def half_diagonal_px(self) -> float:
        """Unit of the distances."""
        return math.hypot(self.rows, self.columns) / 2

    def seen(self, row_px: Any, column_px: Any) -> tuple[Any, Any]:
        """Where points of the flat plane appear; numbers or arrays that broadcast, px."""
        if self.distortion == 0:
            return row_px, column_px
        down, across, square = self._from_middle(row_px, column_px)
        factor = 1 + self.distortion * square
        return self.middle_px[0] + down * factor, self.middle_px[1] + across * factor

    def flat(self, row_px: Any, column_px: Any) -> tuple[Any, Any]:
        """Where points of the image lie in the flat plane; numbers or arrays that broadcast, px."""
        if self.distortion == 0:
            return row_px, column_px
        down, across, square = self._from_middle(row_px, column_px)
        factor = _flattening(np.atleast_1d(np.asarray(self.distortion * square, dtype=float)).ravel())
        factor = factor.reshape(np.shape(square)) if np.ndim(square) else float(factor[0])
        return self.middle_px[0] + down * factor, self.middle_px[1] + across * factor

    def magnification(self, row_px: Any, column_px: Any) -> tuple[Any, Any]:
        """Of the image over the flat plane, along and across the radius, at points of the flat plane; product: that of areas."""
        if self.distortion == 0:
            return 1.0, 1.0
        _, _, square = self._from_middle(row_px, column_px)
        return 1 + 3 * self.distortion * square, 1 + self.distortion * square

    def _from_middle(self, row_px: Any, column_px: Any) -> tuple[Any, Any, Any]:
        """Distances down and across, px, and the square of the whole distance in half diagonals."""
        down, across = row_px - self.middle_px[0], column_px - self.middle_px[1]
        return down, across, (down**2 + across**2) / self.half_diagonal_px**2


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
