r"""A tilted camera's view of the wheel's plane: from places about the axle to the image and back.

A place p in the wheel's plane, in px from the axle (downwards, rightwards; there as large as in the image), appears undistorted
at

.. math:: u = \frac{R p + u_0}{1 + h \cdot p}

from the lens centre: a pinhole x = f X / Z with the axle at u_0. h = t / f is the keystone, the share by which a length shrinks
per px, t the first two parts of the plane's normal in the camera (the tilt, to a sine), and R = 1 - t t^T / (1 + sqrt(1 - t^2))
what turning by t leaves of the plane; a roll of the camera is in the direction of the mask. Then the lens distorts
(`physics.lens`).

Polar angles about the axle are those of (R - u_0 h^T) p: the keystone by itself moves no angle, but where the axle is off the
lens centre it does, and foreshortening does, as the square of the tilt. What is taken for the place of an image point may be a
little aside (`physics.warp`).
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, NamedTuple, TypeAlias, final

import numpy as np
from numba import njit
from numba.extending import register_jitable

from irtiming.physics.lens import Coefficients, Lens, Place, bent, magnified
from irtiming.physics.warp import WARP_NUMBERS, Warp, displaced, enlarged
from irtiming.records.arrays import Array
from irtiming.records.row_timing import SectorShape

_Matrix: TypeAlias = tuple[tuple[Any, Any], tuple[Any, Any]]

_NO_WARP = Warp(amounts_px=(0.0,) * len(WARP_NUMBERS), unit_px=1.0)
_UNWARPED = 4  # rounds, each of which leaves a hundredth or so of what the one before left
_STEEPEST = 0.9  # square of the largest tilt's sine


@final
@dataclass(frozen=True, kw_only=True)
class Projection:
    """Axle in the image (row, column, px), keystone (rows, columns; 1/px), focal length (px), lens and warp.

    ``axis_px`` is by how much the pinhole's axis lies below and right of the distortion's centre.
    Keystone, focal length, axis and what the lens has may be arrays that broadcast against places: many cameras at once.
    """

    axle_px: tuple[float, float]
    keystone_per_px: tuple[Any, Any]
    focal_length_px: Any
    lens: Lens
    warp: Warp = _NO_WARP
    axis_px: tuple[Any, Any] = (0.0, 0.0)

    def seen(self, down_px: Any, right_px: Any) -> tuple[Any, Any]:
        """Row and column in the image of places from the axle."""
        eye = self.eye
        return _in_image(eye, _undistorted(eye, _unwarped(eye, (down_px, right_px))))

    def flat(self, row_px: Any, column_px: Any) -> tuple[Any, Any]:
        """Places from the axle, down and right, of points of the image; numbers or arrays that broadcast."""
        down, right = self._flat(row_px, column_px)
        if self.warp.is_none:
            return down, right
        below, beside = self.warp.moved(down, right)
        return down + below, right + beside

    def _flat(self, row_px: Any, column_px: Any) -> tuple[Any, Any]:
        row, column = self.lens.flat(row_px, column_px)
        down, right = row - self._middle[0], column - self._middle[1]
        off_down, off_right = row - self._axle[0], column - self._axle[1]
        if not np.any(self.keystone_per_px):
            return off_down, off_right
        (a, b), (c, d) = self._turned
        along_row, along_column = self.keystone_per_px
        a, b = a - down * along_row, b - down * along_column
        c, d = c - right * along_row, d - right * along_column
        whole = a * d - b * c
        return (d * off_down - b * off_right) / whole, (a * off_right - c * off_down) / whole

    def magnification(self, down_px: Any, right_px: Any) -> tuple[Any, Any]:
        """Of the image of one camera over the wheel's plane: least of any direction, or a little less, and that of areas.

        A warp is too slight to matter to the least one.
        """
        down, right = np.broadcast_arrays(np.asarray(down_px, dtype=float), np.asarray(right_px, dtype=float))
        least, area = _magnifications(self.eye, down.ravel(), right.ravel())
        return least.reshape(down.shape), area.reshape(down.shape)

    @property
    def tilt(self) -> tuple[Any, Any]:
        """First two parts of the plane's unit normal in the camera."""
        down, right = (self.focal_length_px * h for h in self.keystone_per_px)
        shorter = np.minimum(1.0, np.sqrt(_STEEPEST / np.maximum(down * down + right * right, 1e-300)))
        return down * shorter, right * shorter

    @cached_property
    def _turned(self) -> _Matrix:
        """R."""
        t, s = self.tilt
        part = 1 / (1 + np.sqrt(1 - t * t - s * s))
        return (1 - t * t * part, -t * s * part), (-t * s * part, 1 - s * s * part)

    @cached_property
    def _axle(self) -> tuple[Any, Any]:
        """Undistorted row and column of the axle."""
        return self.lens.flat(*self.axle_px)

    @cached_property
    def _middle(self) -> tuple[Any, Any]:
        (row, column), (below, beside) = self.lens.middle_px, self.axis_px
        return row + below, column + beside

    @cached_property
    def _about_axle(self) -> _Matrix:
        """What the projection does beside the axle."""
        (a, b), (c, d) = self._turned
        below, beside = (axle - middle for axle, middle in zip(self._axle, self._middle, strict=True))
        along_row, along_column = self.keystone_per_px
        return (a - below * along_row, b - below * along_column), (c - beside * along_row, d - beside * along_column)

    @cached_property
    def eye(self) -> "Eye":
        """The same as numbers alone: compiled code takes those of one camera."""
        return Eye(
            axle_px=self._axle,
            keystone_per_px=self.keystone_per_px,
            about_axle=self._about_axle,
            middle_px=self.lens.middle_px,
            unit_px=self.lens.half_diagonal_px or 1.0,
            coefficients=self.lens.coefficients,
            warp=tuple(one / self.warp.unit_px for one in self.warp.amounts_px),
            rounds=0 if self.warp.is_none else _UNWARPED,
        )


@final
class Eye(NamedTuple):
    """A camera's view as numbers, as of `Projection`.

    ``axle_px`` is the undistorted place of the axle, ``unit_px`` half the diagonal, in which the ``warp`` is; ``rounds`` how
    often what it does is taken back.
    """

    axle_px: tuple[Any, Any]
    keystone_per_px: tuple[Any, Any]
    about_axle: _Matrix
    middle_px: tuple[Any, Any]
    unit_px: float
    coefficients: Coefficients
    warp: tuple[float, ...]
    rounds: int


@register_jitable
def _shrunk(place: Place, keystone: tuple[Any, Any]) -> Any:
    """Denominator of the projection."""
    return 1 + keystone[0] * place[0] + keystone[1] * place[1]


@register_jitable
def _whole(matrix: _Matrix) -> Any:
    """Determinant."""
    return matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0]


@register_jitable
def _unwarped(eye: Eye, place_px: Place) -> Place:
    """Where a place down and right from the axle would be taken to lie without the warp, px."""
    unit = eye.unit_px
    place = place_px
    for _ in range(eye.rounds):
        below, beside = displaced((place[0] / unit, place[1] / unit), eye.warp)
        place = (place_px[0] - unit * below, place_px[1] - unit * beside)
    return place


@register_jitable
def _undistorted(eye: Eye, place_px: Place) -> Place:
    """Where such a place appears without distortion, half diagonals from the lens centre."""
    (down, right), ((a, b), (c, d)) = place_px, eye.about_axle
    smaller = _shrunk(place_px, eye.keystone_per_px)
    below, beside = (a * down + b * right) / smaller, (c * down + d * right) / smaller
    return (
        (eye.axle_px[0] + below - eye.middle_px[0]) / eye.unit_px,
        (eye.axle_px[1] + beside - eye.middle_px[1]) / eye.unit_px,
    )


@register_jitable
def _in_image(eye: Eye, flat: Place) -> Place:
    """Row and column of the image where such a point appears."""
    row, column = bent(flat, eye.coefficients)
    return eye.middle_px[0] + eye.unit_px * row, eye.middle_px[1] + eye.unit_px * column


@njit(cache=True, nogil=True)
def seen_by(eye: Eye, place_px: tuple[float, float]) -> tuple[float, float, float, float]:
    """Row and column in the image of a place down and right from the axle, and the magnification there: least, and of areas."""
    place = _unwarped(eye, place_px)
    flat = _undistorted(eye, place)
    least, area = magnified(flat, eye.coefficients)
    smaller, whole = _shrunk(place, eye.keystone_per_px), _whole(eye.about_axle)
    least, area = least * min(1.0, whole) / max(smaller, 1.0) ** 2, area * whole / smaller**3
    if eye.rounds:
        area /= enlarged((place[0] / eye.unit_px, place[1] / eye.unit_px), eye.warp)
    row, column = _in_image(eye, flat)
    return row, column, least, area


@njit(cache=True, nogil=True)
def _magnifications(eye: Eye, down_px: Array, right_px: Array) -> Any:
    """See seen_by; places of shapes (n,), magnifications of shape (2, n)."""
    out = np.empty((2, down_px.size))
    for k in range(down_px.size):
        _, _, out[0, k], out[1, k] = seen_by(eye, (down_px[k], right_px[k]))
    return out


@lru_cache(maxsize=64)
def projection_of(shape: SectorShape) -> Projection:
    """How the sector appears; a search asks for the same one several times in a row."""
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
        warp=Warp(amounts_px=tuple(getattr(shape, name) for name in WARP_NUMBERS), unit_px=unit),
    )
