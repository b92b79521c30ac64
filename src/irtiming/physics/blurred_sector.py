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
distortion             of the lens (`physics.lens`), tilt and lens centre (`physics.projection`); offset, radii and angles
                       are those of the wheel's plane
blur                   of the Gaussian that smears light: standard deviations over rows and columns, px, and their correlation,
                       in the middle of the image; its variance may grow to the corners
glare                  share of the blurred light that a further, round Gaussian spreads
=====================  =======================================================================================

Blur moves light, it does not lose any: the light that leaves the opening in one row is seen by its neighbours. And it mixes
polar angles before a row is read. So each pixel, and each row as a whole, sees the opening through a weight over polar
angle, which the wheel's harmonics see as the weight's own Fourier coefficients.
"""

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numba import njit
from scipy.special import ndtr

from irtiming.physics import gaussian_spread
from irtiming.physics.gaussian_spread import REACH
from irtiming.physics.projection import Projection, projection_of
from irtiming.physics.sector_points import (
    LightPoints,
    Sector,
    glare_points,
    half_turn,
    radial,
    sector_of,
    widening,
    widths_with_glare,
)
from irtiming.physics.wheel_harmonics import later
from irtiming.records.arrays import Array, ComplexArray, Mask, Ticks
from irtiming.records.blur import Blur
from irtiming.records.row_timing import SectorShape

PIXEL_PX2 = 1 / 12  # variance of a place within a pixel
SIDES = ("inner arc", "outer arc", "first radial edge", "second radial edge")
"""Of the sector's border; the wheel's edges come to the first radial edge first."""


@lru_cache(maxsize=16)
def _flat_pixels(projection: Projection, roi: tuple[int, int, int, int]) -> tuple[Array, Array, Array]:
    """Places of the region's pixels in the wheel's plane, down and right from the axle, and the least magnification there.

    A search changes the sector more often than the projection.
    """
    down, right = np.broadcast_arrays(*projection.flat(*_pixels(roi)))
    least, _ = projection.magnification(down, right)
    return down, right, np.broadcast_to(least, down.shape)


def pixel_smear(radius_px: Array, *, blur_px: Array | float, order: int | Ticks) -> Array:
    """What a pixel's width and the blur leave of exp(-i m phi) where its light is even: exp(-m^2 sigma^2 / 2 r^2).

    Parameters
    ----------
    radius_px
        Distance r of the pixel's centre from the axle, any shape; taken as 1 px where it is less.
    blur_px
        Standard deviation of the blur across the radius; sigma^2 is its square and 1/12 for the pixel itself.
    order
        m, one number or an array that broadcasts against ``radius_px``.
    """
    return np.asarray(np.exp(-0.5 * order**2 * (blur_px**2 + PIXEL_PX2) / np.maximum(radius_px, 1.0) ** 2))


def angular_reach(shape: SectorShape, *, roi: tuple[int, int, int, int]) -> Array:
    """Standard deviation of the polar angle of even light that a pixel sees, rad, shape (roi rows, roi columns).

    Blur and the pixel's width are lengths in the image, seen from the axle at the distance that it has there, 1 px at least.
    """
    _, _, away = _directions((shape.axle_row_px, shape.axle_column_px), roi)
    return np.asarray(np.sqrt(blur_across_px(shape, roi=roi) ** 2 + PIXEL_PX2) / np.maximum(away, 1.0))


def astray_reach(shape: SectorShape, *, roi: tuple[int, int, int, int]) -> Array:
    """The same of even light that goes astray, as far as the glare is wide, rad, shape (roi rows, roi columns)."""
    _, _, away = _directions((shape.axle_row_px, shape.axle_column_px), roi)
    return np.asarray(np.hypot(angular_reach(shape, roi=roi), shape.glare_px / np.maximum(away, 1.0)))


def blur_across_px(shape: SectorShape, *, roi: tuple[int, int, int, int], along: bool = False) -> Array:
    """Standard deviation of the blur across each pixel's radius, or ``along`` it, px, shape (roi rows, roi columns)."""
    down, right, _ = _directions((shape.axle_row_px, shape.axle_column_px), roi)
    variances = radial(shape.blur, down=down, right=right)
    return np.asarray(np.sqrt(variances[0 if along else 1]) * _widening(shape, roi))


def _widening(shape: SectorShape, roi: tuple[int, int, int, int]) -> Array:
    """By how much wider the blur is at each pixel than in the middle of the image, shape (roi rows, roi columns)."""
    row, column = _pixels(roi)
    return widening(shape, row_px=row, column_px=column)


def even_angle_rad(shape: SectorShape, *, roi: tuple[int, int, int, int]) -> Array:
    r"""By how much the mean polar angle of even light exceeds that of a pixel's centre, rad, shape (roi rows, roi columns).

    Where a blur is `askew_px_rad`, what lies nearer to the axle turns by more: :math:`-c / r^2`.
    """
    _, _, away = _directions((shape.axle_row_px, shape.axle_column_px), roi)
    return np.asarray(-askew_px_rad(shape, roi=roi) / np.maximum(away, 1.0))


def askew_px_rad(shape: SectorShape, *, roi: tuple[int, int, int, int]) -> Array:
    r"""Covariance of distance from the axle and polar angle of what a pixel sees, px rad, shape (roi rows, roi columns).

    A blur that is not round has a covariance of places along and across the radius, :math:`c = (b_y^2 - b_x^2) \sin\phi
    \cos\phi + b_{xy} (\cos^2\phi - \sin^2\phi)`; this is c / r.
    """
    down, right, away = _directions((shape.axle_row_px, shape.axle_column_px), roi)
    _, _, both = radial(shape.blur, down=down, right=right)
    return np.asarray(shape.sense * both * _widening(shape, roi) ** 2 / np.maximum(away, 1.0))


@lru_cache(maxsize=16)
def _directions(axle_px: tuple[float, float], roi: tuple[int, int, int, int]) -> tuple[Array, Array, Array]:
    """Sine and cosine of the polar angles of the region's pixels in the image, and their distance from the axle, px."""
    row, column = _pixels(roi)
    down, right = row - axle_px[0], column - axle_px[1]
    away = np.hypot(down, right)
    return down / np.maximum(away, 1e-9), right / np.maximum(away, 1e-9), away


def reach_px(blur_px: float) -> float:
    """Standard deviation of the place of the light that a pixel sees along rows and along columns, px: blur and pixel."""
    return math.sqrt(blur_px**2 + PIXEL_PX2)


def well_inside(shape: SectorShape, *, roi: tuple[int, int, int, int]) -> Mask:
    """Pixels that the blur of the border does not reach, shape (roi rows, roi columns)."""
    return np.asarray(_depth_px(shape, roi) > _reach_of_border_px(shape, roi))


def near_border(shape: SectorShape, *, roi: tuple[int, int, int, int]) -> Mask:
    """Pixels that the blur of the border reaches, from either side, shape (roi rows, roi columns)."""
    return np.asarray(np.abs(_depth_px(shape, roi)) <= _reach_of_border_px(shape, roi))


def _reach_of_border_px(shape: SectorShape, roi: tuple[int, int, int, int]) -> Array:
    """How far from the border, at each pixel, its blur shows, shape (roi rows, roi columns)."""
    return REACH * shape.blur.widest_px * _widening(shape, roi) + 1


def _pixels(roi: tuple[int, int, int, int]) -> tuple[Array, Array]:
    """Rows, as a column, and columns, as a row, of the region."""
    return np.arange(roi[0], roi[1], dtype=float)[:, None], np.arange(roi[2], roi[3], dtype=float)[None, :]


def border_sides(shape: SectorShape, *, roi: tuple[int, int, int, int]) -> tuple[Ticks, Array]:
    """Nearest side of the border and depth below it, px, of each pixel; two arrays of shape (roi rows, roi columns).

    Sides are numbered as in ``SIDES``.
    """
    depths = _depths_px(shape, roi)
    return np.asarray(depths.argmin(axis=0)), np.asarray(depths.min(axis=0))


def _depth_px(shape: SectorShape, roi: tuple[int, int, int, int]) -> Array:
    """Distance of pixels in the image to the nearest border of the sector, px, or a little less; negative outside."""
    return np.asarray(_depths_px(shape, roi).min(axis=0))


def _depths_px(shape: SectorShape, roi: tuple[int, int, int, int]) -> Array:
    """The same for each side, shape (4, roi rows, roi columns)."""
    down, right, least = _flat_pixels(projection_of(shape), roi)
    depths = _depths(down.ravel(), right.ravel(), least.ravel(), sector_of(shape))
    return np.asarray(depths.reshape(len(SIDES), *down.shape))


@njit(cache=True, nogil=True)
def _depths(down: Array, right: Array, least: Array, sector: Sector) -> Array:
    """See _depths_px; places from the axle and least magnifications (n,), depths (4, n)."""
    out = np.empty((4, down.size))
    (inner, outer), quarter = sector.radii_px, math.pi / 2
    for k in range(down.size):
        below, across = down[k] - sector.offset_px[0], sector.sense * right[k] - sector.offset_px[1]
        radius = math.hypot(below, across)
        off = half_turn(math.atan2(below, across) - sector.bisector_rad)
        out[0, k], out[1, k] = (radius - inner) * least[k], (outer - radius) * least[k]
        out[2, k] = radius * math.sin(min(max(sector.half_angle_rad + off, -quarter), quarter)) * least[k]
        out[3, k] = radius * math.sin(min(max(sector.half_angle_rad - off, -quarter), quarter)) * least[k]
    return out


def pixel_places(shape: SectorShape, *, roi: tuple[int, int, int, int]) -> tuple[Array, Array]:
    """Polar angle from the bisector (rad) and distance from the axle (flat px) of pixels, shape (roi rows, roi columns)."""
    down, right, _ = _flat_pixels(projection_of(shape), roi)
    angle, radius = _polar(down.ravel(), right.ravel(), sector_of(shape))
    return angle.reshape(down.shape), radius.reshape(down.shape)


@njit(cache=True, nogil=True)
def _polar(down: Array, right: Array, sector: Sector) -> Any:
    """See pixel_places; places from the axle (n,), angles and distances (2, n)."""
    out = np.empty((2, down.size))
    for k in range(down.size):
        out[0, k] = half_turn(math.atan2(down[k], sector.sense * right[k]) - sector.bisector_rad)
        out[1, k] = math.hypot(down[k], right[k])
    return out


def image(points: LightPoints, value: ComplexArray, *, blur: Blur, roi: tuple[int, int, int, int]) -> ComplexArray:
    """Blurred image of points of light of complex brightness ``value`` per px^2, shape (roi rows, roi columns)."""
    return np.asarray(images(points, value[None], blur=blur, roi=roi)[0])


def images(points: LightPoints, values: ComplexArray, *, blur: Blur, roi: tuple[int, int, int, int]) -> ComplexArray:
    """The same of several brightnesses, shape (k, n), at once: shape (k, roi rows, roi columns)."""
    return gaussian_spread.deposit(
        (points.row_px - roi[0], points.column_px - roi[2]),
        values * points.area_px2,
        blur=blur,
        widening=points.widening,
        size=(roi[1] - roi[0], roi[3] - roi[2]),
    )


def row_harmonics(points: LightPoints, rows: Ticks, *, blur_px: float, n_harmonics: int) -> ComplexArray:
    """Fourier coefficients over polar angle of the light that each row sees, px^2, shape (n_row, M + 1).

    Parameters
    ----------
    points
        Of the sector.
    rows
        Image rows, shape (n_row,).
    blur_px
        Standard deviation of the blur over rows, in the middle of the image; over columns it moves light within the row and
        plays no part.
    n_harmonics
        Highest order M.

    Returns
    -------
    sum over the light of exp(-i m (phi - bisector)) times the share that falls into the row. m = 0 is the row's light.
    """
    ascending = np.argsort(rows)
    light = points.row_px, points.angle_rad, points.area_px2
    found = _row_harmonics(light, blur_px * points.widening, rows[ascending], n_harmonics)
    return np.asarray(found[np.argsort(ascending)])


def with_glare(image: ComplexArray, shape: SectorShape) -> ComplexArray:
    """A blurred image of which the glare spreads its share; same shape (row, column).

    Sums over pixels in place of integrals: the light of a pixel is even enough for a Gaussian of 1 px or more.
    """
    if shape.glare == 0:
        return image
    down, across = (_gaussian(n, shape.glare_px) for n in image.shape)
    spread = down @ image.real @ across + 1j * (down @ image.imag @ across)
    return np.asarray((1 - shape.glare) * image + shape.glare * spread)


@lru_cache(maxsize=16)
def _gaussian(n: int, width: float) -> Array:
    """What each of so many pixels has of the light of each, shape (n, n)."""
    apart = np.arange(n)[:, None] - np.arange(n)
    return np.asarray(np.exp(-0.5 * (apart / width) ** 2) / (math.sqrt(2 * np.pi) * width))


def glare_harmonics(
    shape: SectorShape, summed: Mask, *, roi: tuple[int, int, int, int], n_harmonics: int
) -> ComplexArray:
    """Like `row_harmonics`, of the glare alone and per unit of its share, in the rows of the region: shape (roi rows, M + 1).

    ``summed``, of shape (roi rows, roi columns), are the pixels of which each row's sum is made; what falls beside them is lost.
    """
    points = glare_points(shape, n_harmonics=n_harmonics)
    into_sum = glare_kept(points, summed, shape=shape, roi=roi)
    waves = later(-points.angle_rad, n_harmonics=n_harmonics) * points.area_px2[:, None]
    return np.asarray(into_sum.T @ waves.real + 1j * (into_sum.T @ waves.imag))


def glare_kept(points: LightPoints, summed: Mask, *, shape: SectorShape, roi: tuple[int, int, int, int]) -> Array:
    """Part of the glare of each point of light that falls into summed pixels, by their row: shape (n, roi rows)."""
    over_rows, over_columns = widths_with_glare(shape)
    into_row = _shares(points.row_px, roi[:2], over_rows)
    return np.asarray(into_row * (_shares(points.column_px, roi[2:], over_columns) @ summed.T.astype(float)))


def _shares(place: Array, ends: tuple[int, int], blur: float) -> Array:
    """Part of the light at each place that a Gaussian carries into each pixel of a range, shape (place, pixel)."""
    border = np.arange(ends[0], ends[1] + 1) - 0.5
    return np.diff(ndtr((border - place[:, None]) / blur), axis=1)


@njit(cache=True, nogil=True)
def _share(low: float, high: float, blur: float) -> float:
    """Part of a Gaussian about zero between two ends."""
    scale = 1 / (blur * math.sqrt(2.0))
    return 0.5 * (math.erf(high * scale) - math.erf(low * scale))


@njit(cache=True, nogil=True)
def _row_harmonics(light: tuple[Array, Array, Array], blur: Array, rows: Ticks, n_harmonics: int) -> Any:
    """See row_harmonics; row, angle, area and blur of each point, (n,), rows that ascend."""
    row, angle, area = light
    real = np.zeros((rows.size, n_harmonics + 1))
    imaginary = np.zeros((rows.size, n_harmonics + 1))
    cosine, sine = np.empty(n_harmonics + 1), np.empty(n_harmonics + 1)
    for k in range(row.size):
        reach = REACH * blur[k] + 0.5
        turn = complex(math.cos(angle[k]), -math.sin(angle[k]))
        wave = complex(area[k], 0.0)
        for m in range(n_harmonics + 1):
            cosine[m], sine[m] = wave.real, wave.imag
            wave *= turn
        for i in range(np.searchsorted(rows, row[k] - reach), np.searchsorted(rows, row[k] + reach, side="right")):
            share = _share(rows[i] - 0.5 - row[k], rows[i] + 0.5 - row[k], blur[k])
            for m in range(n_harmonics + 1):
                real[i, m] += share * cosine[m]
                imaginary[i, m] += share * sine[m]
    return real + 1j * imaginary
