r"""A tilted camera's view of the wheel's plane: from places about the axle to the image and back.

A place p in the wheel's plane, in px from the axle (downwards, rightwards; there as large as in the image), appears undistorted
at

.. math:: u = \frac{R p + u_0}{1 + h \cdot p}

from the lens centre: a pinhole x = f X / Z with the axle at u_0. h = t / f is the keystone, the share by which a length shrinks
per px, t the first two parts of the plane's normal in the camera (the tilt, to a sine), and R = 1 - t t^T / (1 + sqrt(1 - t^2))
what turning by t leaves of the plane; a roll of the camera is in the direction of the mask. Then the lens distorts
(`physics.lens`).

Polar angles about the axle are those of (R - u_0 h^T) p: the keystone by itself moves no angle, but where the axle is off the
lens centre it does, and foreshortening does, as the square of the tilt.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from irtiming.physics.lens import Lens
from irtiming.records.arrays import Array
from irtiming.records.row_timing import SectorShape

_STEEPEST = 0.9  # square of the largest tilt's sine


@final
@dataclass(frozen=True, kw_only=True)
class Projection:
    """Axle in the image (row, column, px), keystone (rows, columns; 1/px), focal length (px) and lens."""

    axle_px: tuple[float, float]
    keystone_per_px: tuple[float, float]
    focal_length_px: float
    lens: Lens

    def seen(self, down_px: Any, right_px: Any) -> tuple[Any, Any]:
        """Row and column in the image of places from the axle."""
        return self.lens.seen(*self._undistorted(down_px, right_px))

    def flat(self, row_px: Any, column_px: Any) -> tuple[Any, Any]:
        """Places from the axle, down and right, of points of the image; numbers or arrays that broadcast."""
        row, column = self.lens.flat(row_px, column_px)
        down, right = row - self._middle[0], column - self._middle[1]
        off_down, off_right = row - self._axle[0], column - self._axle[1]
        if not any(self.keystone_per_px):
            return off_down, off_right
        (a, b), (c, d) = self._turned
        along_row, along_column = self.keystone_per_px
        a, b = a - down * along_row, b - down * along_column
        c, d = c - right * along_row, d - right * along_column
        whole = a * d - b * c
        return (d * off_down - b * off_right) / whole, (a * off_right - c * off_down) / whole

    def magnification(self, down_px: Any, right_px: Any) -> tuple[Any, Any]:
        """Of the image over the wheel's plane: least of any direction, or a little less, and that of areas."""
        least, area = self.lens.magnification(*self._undistorted(down_px, right_px))
        if not any(self.keystone_per_px):
            return least, area
        shrunk = 1 + self.keystone_per_px[0] * down_px + self.keystone_per_px[1] * right_px
        whole = float(np.linalg.det(self._about_axle))
        return least * min(1.0, whole) / np.maximum(shrunk, 1.0) ** 2, area * whole / (shrunk * shrunk * shrunk)

    @property
    def tilt(self) -> Array:
        """First two parts of the plane's unit normal in the camera, shape (2,)."""
        t = self.focal_length_px * np.array(self.keystone_per_px)
        return np.asarray(t * min(1.0, math.sqrt(_STEEPEST / max(float(t @ t), 1e-300))))

    @cached_property
    def _turned(self) -> Array:
        """R, shape (2, 2)."""
        t = self.tilt
        return np.asarray(np.eye(2) - np.outer(t, t) / (1 + math.sqrt(1 - float(t @ t))))

    @cached_property
    def _axle(self) -> tuple[float, float]:
        """Undistorted row and column of the axle."""
        row, column = self.lens.flat(*self.axle_px)
        return float(row), float(column)

    @cached_property
    def _middle(self) -> tuple[float, float]:
        return self.lens.middle_px

    @cached_property
    def _about_axle(self) -> Array:
        """What the projection does beside the axle, shape (2, 2)."""
        off = np.subtract(self._axle, self._middle)
        return np.asarray(self._turned - np.outer(off, self.keystone_per_px))

    def _undistorted(self, down: Any, right: Any) -> tuple[Any, Any]:
        if not any(self.keystone_per_px):
            return self._axle[0] + down, self._axle[1] + right
        (a, b), (c, d) = self._about_axle
        shrunk = 1 + self.keystone_per_px[0] * down + self.keystone_per_px[1] * right
        return self._axle[0] + (a * down + b * right) / shrunk, self._axle[1] + (c * down + d * right) / shrunk


def projection_of(shape: SectorShape) -> Projection:
    """How the sector is seen."""
    lens = Lens(
        distortion=shape.distortion,
        rows=shape.image_rows,
        columns=shape.image_columns,
        off_row_px=shape.lens_row_px,
        off_column_px=shape.lens_column_px,
        terms=shape.lens_terms,
    )
    unit = lens.half_diagonal_px or 1.0
    return Projection(
        axle_px=(shape.axle_row_px, shape.axle_column_px),
        keystone_per_px=(shape.keystone_row / unit, shape.keystone_column / unit),
        focal_length_px=unit * math.exp(shape.log_focal_length),
        lens=lens,
    )
