r"""The mask opening in the image: an annular sector of even light, blurred by the optics and by the pixels.

Definitions
-----------
=====================  =======================================================================================
name                   meaning
=====================  =======================================================================================
axle                   where the wheel's axle appears, row and column in px: polar angles are taken about it
offset                 centre of the mask's own arcs minus the axle, rows and columns, px
inner, outer radius    of the arcs about the mask's own centre, px
bisector               direction of the mask's bisector, polar angle in the image
opening angle          gamma, between the two radial edges
blur                   standard deviation of the Gaussian that smears light along rows and columns, px
=====================  =======================================================================================

Blur moves light, it does not lose any: the light that leaves the opening in one row is seen by its neighbours. And it mixes
polar angles before a row is read. So each pixel, and each row as a whole, sees the opening through a weight over polar
angle, which the wheel's harmonics see as the weight's own Fourier coefficients.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, final

import numpy as np
from numba import njit

from irtiming.records.arrays import Array, Mask, Ticks
from irtiming.records.rolling import ComplexArray
from irtiming.records.row_timing import SectorShape

_NODES_PER_BLUR = 1.2  # of the widest gaps of the quadrature: its error is exp(-2 pi^2 / 1.2^2), a millionth
_REACH = 5.0  # blurs beyond which no light comes


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LightPoints:
    """Nodes and weights of a quadrature over the sector.

    Shapes (n,): place in the image (px), polar angle about the axle minus the bisector (rad), area (px^2).
    """

    row_px: Array
    column_px: Array
    angle_rad: Array
    area_px2: Array


def light_points(shape: SectorShape) -> LightPoints:
    """Gauss-Legendre nodes in radius and angle, close enough for the blur."""
    gap = _NODES_PER_BLUR * shape.blur_px * 2 / np.pi
    half_width = (shape.outer_radius_px - shape.inner_radius_px) / 2
    half_angle = shape.opening_angle_rad / 2
    radial, radial_weight = _gauss_legendre(max(8, math.ceil(2 * half_width / gap)))
    around, around_weight = _gauss_legendre(max(8, math.ceil(2 * half_angle * shape.outer_radius_px / gap)))
    radius = shape.inner_radius_px + half_width * (1 + radial)
    polar = shape.bisector_rad + half_angle * around
    down = shape.offset_row_px + np.multiply.outer(radius, np.sin(polar)).ravel()
    across = shape.offset_column_px + np.multiply.outer(radius, np.cos(polar)).ravel()
    area = np.multiply.outer(radius * radial_weight * half_width, around_weight * half_angle).ravel()
    sense = -1.0 if shape.mirrored else 1.0
    angle = np.arctan2(down, across) - shape.bisector_rad
    return LightPoints(
        row_px=shape.axle_row_px + down,
        column_px=shape.axle_column_px + sense * across,
        angle_rad=np.mod(angle + np.pi, 2 * np.pi) - np.pi,
        area_px2=area,
    )


@lru_cache(maxsize=256)
def _gauss_legendre(n: int) -> tuple[Array, Array]:
    """Nodes and weights; a search asks for the same few numbers of them hundreds of times."""
    return np.polynomial.legendre.leggauss(n)


def border_points(shape: SectorShape) -> LightPoints:
    """Those of the light points that reach a pixel which is not `well_inside`: a fraction of all where the opening is large."""
    points = light_points(shape)
    depth = _depth_px(shape, points.row_px, points.column_px)
    near = depth < 2 * (_REACH * shape.blur_px + 1)
    return LightPoints(
        row_px=points.row_px[near],
        column_px=points.column_px[near],
        angle_rad=points.angle_rad[near],
        area_px2=points.area_px2[near],
    )


def well_inside(shape: SectorShape, *, roi: tuple[int, int, int, int]) -> Mask:
    """Pixels that the blur of the border does not reach, shape (roi rows, roi columns)."""
    rows, columns = np.arange(roi[0], roi[1], dtype=float)[:, None], np.arange(roi[2], roi[3], dtype=float)[None, :]
    return np.asarray(_depth_px(shape, rows, columns) > _REACH * shape.blur_px + 1)


def _depth_px(shape: SectorShape, row_px: Array, column_px: Array) -> Array:
    """Distance to the nearest border of the sector, px; negative outside."""
    down = row_px - shape.axle_row_px - shape.offset_row_px
    across = (-1.0 if shape.mirrored else 1.0) * (column_px - shape.axle_column_px) - shape.offset_column_px
    radius = np.hypot(down, across)
    off = np.abs(np.mod(np.arctan2(down, across) - shape.bisector_rad + np.pi, 2 * np.pi) - np.pi)
    beside = radius * np.sin(np.clip(shape.opening_angle_rad / 2 - off, -np.pi / 2, np.pi / 2))
    return np.minimum(np.minimum(radius - shape.inner_radius_px, shape.outer_radius_px - radius), beside)


def pixel_places(shape: SectorShape, *, roi: tuple[int, int, int, int]) -> tuple[Array, Array]:
    """Polar angle from the bisector (rad) and distance from the axle (px) of each pixel's centre, (roi rows, roi columns)."""
    down = np.arange(roi[0], roi[1])[:, None] - shape.axle_row_px
    across = (-1.0 if shape.mirrored else 1.0) * (np.arange(roi[2], roi[3])[None, :] - shape.axle_column_px)
    angle = np.arctan2(down + 0.0 * across, across + 0.0 * down) - shape.bisector_rad
    return np.mod(angle + np.pi, 2 * np.pi) - np.pi, np.hypot(down, across)


def image(points: LightPoints, value: ComplexArray, *, blur_px: float, roi: tuple[int, int, int, int]) -> ComplexArray:
    """Blurred image of points of light of complex brightness ``value`` per px^2, shape (roi rows, roi columns)."""
    return _deposit(
        points.row_px - roi[0], points.column_px - roi[2], value * points.area_px2, blur_px,
        (roi[1] - roi[0], roi[3] - roi[2]),
    )  # fmt: skip


def row_harmonics(points: LightPoints, rows: Ticks, *, blur_px: float, n_harmonics: int) -> ComplexArray:
    """Fourier coefficients over polar angle of the light that each row sees, px^2, shape (n_row, M + 1).

    Parameters
    ----------
    points
        Of the sector.
    rows
        Image rows, shape (n_row,).
    blur_px
        Standard deviation of the blur; across the columns it moves light within the row and plays no part.
    n_harmonics
        Highest order M.

    Returns
    -------
    sum over the light of exp(-i m (phi - bisector)) times the share that falls into the row. m = 0 is the row's light.
    """
    ascending = np.argsort(rows)
    found = _row_harmonics(points.row_px, points.angle_rad, points.area_px2, blur_px, (rows[ascending], n_harmonics))
    return np.asarray(found[np.argsort(ascending)])


@njit(cache=True, nogil=True)
def _share(low: float, high: float, blur: float) -> float:
    """Part of a Gaussian about zero between two ends."""
    scale = 1 / (blur * math.sqrt(2.0))
    return 0.5 * (math.erf(high * scale) - math.erf(low * scale))


@njit(cache=True, nogil=True)
def _deposit(row: Array, column: Array, value: ComplexArray, blur: float, size: tuple[int, int]) -> Any:
    """Light of each point spread over the pixels around it."""
    n_row, n_column = size
    out = np.zeros((n_row, n_column), np.complex128)
    across = np.empty(n_column)
    reach = _REACH * blur + 0.5
    for k in range(row.size):
        first_row, last_row = max(0, math.ceil(row[k] - reach)), min(n_row - 1, math.floor(row[k] + reach))
        first, last = max(0, math.ceil(column[k] - reach)), min(n_column - 1, math.floor(column[k] + reach))
        for j in range(first, last + 1):
            across[j] = _share(j - 0.5 - column[k], j + 0.5 - column[k], blur)
        for i in range(first_row, last_row + 1):
            light = value[k] * _share(i - 0.5 - row[k], i + 0.5 - row[k], blur)
            for j in range(first, last + 1):
                out[i, j] += light * across[j]
    return out


@njit(cache=True, nogil=True)
def _row_harmonics(row: Array, angle: Array, area: Array, blur: float, wanted: tuple[Ticks, int]) -> Any:
    """See row_harmonics; rows ascend."""
    rows, n_harmonics = wanted
    real = np.zeros((rows.size, n_harmonics + 1))
    imaginary = np.zeros((rows.size, n_harmonics + 1))
    cosine, sine = np.empty(n_harmonics + 1), np.empty(n_harmonics + 1)
    reach = _REACH * blur + 0.5
    for k in range(row.size):
        turn = complex(math.cos(angle[k]), -math.sin(angle[k]))
        wave = complex(area[k], 0.0)
        for m in range(n_harmonics + 1):
            cosine[m], sine[m] = wave.real, wave.imag
            wave *= turn
        for i in range(np.searchsorted(rows, row[k] - reach), np.searchsorted(rows, row[k] + reach, side="right")):
            share = _share(rows[i] - 0.5 - row[k], rows[i] + 0.5 - row[k], blur)
            for m in range(n_harmonics + 1):
                real[i, m] += share * cosine[m]
                imaginary[i, m] += share * sine[m]
    return real + 1j * imaginary
