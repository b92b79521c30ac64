"""Where the light of a blurred sector comes from: places in the mask opening, and where they appear in the image.

A quadrature: Gauss-Legendre nodes in radius and in angle, stretched to be more even, close enough for the blur.
`physics.blurred_sector` defines the sector, and makes images of these points.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple, final

import numpy as np
from numba import njit

from irtiming.errors import GeometryError
from irtiming.physics.gaussian_spread import REACH
from irtiming.physics.projection import Eye, projection_of, seen_by
from irtiming.records.arrays import Array
from irtiming.records.blur import Blur
from irtiming.records.row_timing import SectorShape

_NODES_PER_BLUR = 1.2  # of the widest gaps of the quadrature: its error is exp(-2 pi^2 / 1.2^2), a millionth
_MORE_NODES = 20  # than half the radians of a wave: its error is a millionth
_STRETCHED = 1e-8  # error of a quadrature that is stretched to be more even
_MOST_NODES = 5000  # of a quadrature: the sharpest opening that fills 4000 pixels asks for fewer
_DIRECTIONS = 33  # in the sector, among which its sharpest are sought
_LEAST_VARIANCE = 0.05  # of a blur, as a share of that in the middle of the image: no lens is so much sharper beside it
_LOOKS = 9  # along either arc for the least and the largest magnification
_SURELY = 0.8  # of the least that was found: no place between the looks has less


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LightPoints:
    """Nodes and weights of a quadrature over the sector.

    Shapes (n,): place in the image (px), polar angle about the axle minus the bisector (rad), area (px^2), and by how much wider
    the blur is there than in the middle of the image. ``gap_rad`` is the widest between neighbours of one radius.
    """

    row_px: Array
    column_px: Array
    angle_rad: Array
    area_px2: Array
    widening: Array
    gap_rad: float


def light_points(shape: SectorShape, *, n_harmonics: int = 0) -> LightPoints:
    """Nodes in radius and angle, close enough for the blur and for the highest order that is asked for."""
    return _points(shape, n_harmonics=n_harmonics)


def border_points(shape: SectorShape) -> LightPoints:
    """Those of the light points that reach a pixel which is not `well_inside`: a fraction of all where the opening is large."""
    return _points(shape, n_harmonics=0, of_border=True)


def glare_points(shape: SectorShape, *, n_harmonics: int = 0) -> LightPoints:
    """Nodes close enough for the glare, which are few, and for the highest order that is asked for."""
    narrower = min(widths_with_glare(shape))
    even = replace(shape, blur_px=narrower, blur_ellipticity=0.0, blur_correlation=0.0, blur_growth=0.0)
    return light_points(even, n_harmonics=n_harmonics)


def widths_with_glare(shape: SectorShape) -> tuple[float, float]:
    """Standard deviations over rows and over columns of the light that goes astray: blur and glare together.

    Glare is round and so much wider that correlation and growth of the blur are next to nothing in both.
    """
    blur = shape.blur
    return math.hypot(blur.rows_px, shape.glare_px), math.hypot(blur.columns_px, shape.glare_px)


def places(shape: SectorShape, *, n_radial: int, n_around: int) -> tuple[Array, Array, Array]:
    """Places in the sector in the wheel's plane: down and right from the axle (px), and the area of each (px^2).

    ``n_radial`` and ``n_around`` Gauss-Legendre nodes in radius and in angle; three arrays of shape (n_radial n_around,).
    """
    half_width, half_angle = (shape.outer_radius_px - shape.inner_radius_px) / 2, shape.opening_angle_rad / 2
    (radial, radial_weight), (around, around_weight) = _gauss_legendre(n_radial), _gauss_legendre(n_around)
    radius, polar = shape.inner_radius_px + half_width * (1 + radial), shape.bisector_rad + half_angle * around
    return (
        shape.offset_row_px + np.multiply.outer(radius, np.sin(polar)).ravel(),
        shape.sense * (shape.offset_column_px + np.multiply.outer(radius, np.cos(polar)).ravel()),
        np.multiply.outer(radius * radial_weight * half_width, around_weight * half_angle).ravel(),
    )


@final
class Sector(NamedTuple):
    """Its numbers in the wheel's plane, and in which sense columns are counted, for compiled code; as of `SectorShape`."""

    offset_px: tuple[float, float]
    radii_px: tuple[float, float]
    bisector_rad: float
    half_angle_rad: float
    sense: float


def sector_of(shape: SectorShape) -> Sector:
    """The part of a shape that lies in the wheel's plane."""
    return Sector(
        offset_px=(shape.offset_row_px, shape.offset_column_px),
        radii_px=(shape.inner_radius_px, shape.outer_radius_px),
        bisector_rad=shape.bisector_rad,
        half_angle_rad=shape.opening_angle_rad / 2,
        sense=shape.sense,
    )


@njit(cache=True, nogil=True)
def half_turn(angle: float) -> float:
    """The same angle in [-pi, pi)."""
    return angle - 2 * math.pi * math.floor((angle + math.pi) / (2 * math.pi))


def _points(shape: SectorShape, *, n_harmonics: int, of_border: bool = False) -> LightPoints:
    """All nodes, or those alone that lie less than two reaches of the blur below the border, in the image."""
    least, most = _widenings(shape)
    within_px = 2 * (REACH * shape.blur.widest_px * most + 1) if of_border else math.inf
    eye = projection_of(shape).eye
    sector = sector_of(shape)
    narrowest, widest = _magnifications(sector, eye)
    wide = max(1.0, widest)
    along, across = (_NODES_PER_BLUR * blur * 2 / np.pi / wide for blur in _sharpest(shape, least))
    for_waves = math.ceil(sector.half_angle_rad * n_harmonics) + _MORE_NODES
    width, around_px = shape.outer_radius_px - shape.inner_radius_px, shape.opening_angle_rad * shape.outer_radius_px
    n_around = max(for_waves, math.ceil(around_px / across))
    radial, around = _even(max(8, math.ceil(width / along))), _even(n_around)
    row, column, angle, area = _nodes(radial, around, sector, eye, within_px, _SURELY * narrowest)
    return LightPoints(
        row_px=row,
        column_px=column,
        angle_rad=angle,
        area_px2=area,
        widening=widening(shape, row_px=row, column_px=column),
        gap_rad=math.pi * sector.half_angle_rad / n_around,  # in the middle, where the nodes are widest apart
    )


def _sharpest(shape: SectorShape, least: float) -> tuple[float, float]:
    """Least blur along the radius, and across it, of all directions in the sector: there the gaps of a quadrature show.

    ``least`` is by how much wider it is, where it is narrowest, than in the middle of the image.

    A wave across both kinds of gaps meets less blur, by twice the correlation of radius and what is across it, than two waves
    across one kind each.
    """
    polar = shape.bisector_rad + shape.opening_angle_rad * np.linspace(-0.5, 0.5, _DIRECTIONS)
    down, right = np.sin(polar), shape.sense * np.cos(polar)
    along, across, both = radial(shape.blur, down=down, right=right)
    diagonal = np.sqrt(np.minimum(1.0, 2 * (1 - np.abs(both) / np.sqrt(along * across)))).min()
    return least * diagonal * math.sqrt(along.min()), least * diagonal * math.sqrt(across.min())


def widening(shape: SectorShape, *, row_px: Array, column_px: Array) -> Array:
    """By how much wider the blur is at places of the image than in its middle; of the shape to which both broadcast."""
    if shape.blur_growth == 0:
        return np.ones(np.broadcast_shapes(np.shape(row_px), np.shape(column_px)))
    down, right = row_px - (shape.image_rows - 1) / 2, column_px - (shape.image_columns - 1) / 2
    half_diagonals2 = (down**2 + right**2) / ((shape.image_rows**2 + shape.image_columns**2) / 4)
    return np.asarray(np.sqrt(np.maximum(1 + shape.blur_growth * half_diagonals2, _LEAST_VARIANCE)))


def _widenings(shape: SectorShape) -> tuple[float, float]:
    """Least, or a little less, and most in the sector: the middle of the image may lie in it."""
    if shape.blur_growth == 0:
        return 1.0, 1.0
    polar = shape.bisector_rad + shape.opening_angle_rad * np.linspace(-0.5, 0.5, _LOOKS)
    radii = np.array([[shape.inner_radius_px], [shape.outer_radius_px]])
    down = shape.offset_row_px + radii * np.sin(polar)
    right = shape.sense * (shape.offset_column_px + radii * np.cos(polar))
    row, column = projection_of(shape).seen(down.ravel(), right.ravel())
    found = widening(shape, row_px=row, column_px=column)
    return min(1.0, float(found.min())), max(1.0, float(found.max()))


def radial(blur: Blur, *, down: Array, right: Array) -> tuple[Array, Array, Array]:
    """Variance of the blur along a radius and across it, and the covariance of both, px^2; each of the same shape.

    Parameters
    ----------
    blur
        Of the image.
    down, right
        The radius' direction in the image, of length 1; across it is what lies down of a radius that points right.
    """
    rows, columns, both = blur.rows_px**2, blur.columns_px**2, blur.covariance_px2
    twice = 2 * both * down * right
    return (
        rows * down**2 + columns * right**2 + twice,
        rows * right**2 + columns * down**2 - twice,
        (rows - columns) * down * right + both * (right**2 - down**2),
    )


@lru_cache(maxsize=256)
def _even(n: int) -> tuple[Array, Array]:
    """Nodes and weights nowhere farther apart than those of Gauss and Legendre of that number, but up to a third fewer.

    Those crowd at both ends for the sake of polynomials, which are no better at a blur than waves. The arcsine takes most of
    that away (Kosloff and Tal-Ezer 1993; Hale and Trefethen, SIAM J. Numer. Anal. 46 (2008) 930); its own branch points are
    so far from the ends that they do no harm.
    """
    if n > _MOST_NODES:
        raise GeometryError(
            f"a sector that is {n} times as wide as its blur lets through was tried, at most {_MOST_NODES} can be: the image "
            "shows no such opening; check [wheel] rotation, that the image is not mirrored, and that frames have their triggers"
        )
    for fewer in range(n // 2, n):
        apart = _STRETCHED ** (-0.5 / fewer)
        strength = 2 / (apart + 1 / apart)
        widest = math.asin(strength)
        if strength / widest / fewer <= 1 / n:
            place, weight = _gauss_legendre(fewer)
            wider = weight / np.sqrt(1 - (strength * place) ** 2)
            return np.arcsin(strength * place) / widest, 2 * wider / wider.sum()
    return _gauss_legendre(n)


@lru_cache(maxsize=256)
def _gauss_legendre(n: int) -> tuple[Array, Array]:
    """Nodes and weights; a search asks for the same few numbers of them hundreds of times."""
    return np.polynomial.legendre.leggauss(n)


@njit(cache=True, nogil=True)
def _magnifications(sector: Sector, eye: Eye) -> tuple[float, float]:
    """What no place of the sector falls short of, and what none exceeds, or next to none: least one way, largest the other."""
    narrowest, widest = math.inf, 0.0
    for radius in sector.radii_px:
        for k in range(_LOOKS):
            polar = sector.bisector_rad + sector.half_angle_rad * (2 * k / (_LOOKS - 1) - 1)
            down = sector.offset_px[0] + radius * math.sin(polar)
            across = sector.offset_px[1] + radius * math.cos(polar)
            _, _, least, area = seen_by(eye, (down, sector.sense * across))
            narrowest, widest = min(narrowest, least), max(widest, area / least)
    return narrowest, widest


@njit(cache=True, nogil=True)
def _nodes(
    radial: tuple[Array, Array], around: tuple[Array, Array], sector: Sector, eye: Eye, within: float, surely: float
) -> Any:
    """Row, column, polar angle from the bisector and area in the image of each node that is not too deep; shape (4, n).

    Nodes and weights in radius and angle are those between -1 and 1; the depth is the distance to the nearest side. Nodes that
    are too deep even where the image is ``surely`` so large need no projection.
    """
    (place, weight), (turn, turn_weight) = radial, around
    half_width = (sector.radii_px[1] - sector.radii_px[0]) / 2
    sine, cosine, to_edge = np.empty(turn.size), np.empty(turn.size), np.empty(turn.size)
    for j in range(turn.size):
        polar = sector.bisector_rad + sector.half_angle_rad * turn[j]
        sine[j], cosine[j] = math.sin(polar), math.cos(polar)
        to_edge[j] = math.sin(min(sector.half_angle_rad * (1 - abs(turn[j])), math.pi / 2))
    out, used = np.empty((4, place.size * turn.size)), 0
    for i in range(place.size):
        radius, to_arc = sector.radii_px[0] + half_width * (1 + place[i]), half_width * (1 - abs(place[i]))
        for j in range(turn.size):
            depth = min(radius * to_edge[j], to_arc)
            if depth * surely >= within:
                continue
            down, across = sector.offset_px[0] + radius * sine[j], sector.offset_px[1] + radius * cosine[j]
            row, column, least, larger = seen_by(eye, (down, sector.sense * across))
            if depth * least >= within:
                continue
            out[0, used], out[1, used] = row, column
            out[2, used] = half_turn(math.atan2(down, across) - sector.bisector_rad)
            out[3, used] = radius * weight[i] * half_width * turn_weight[j] * sector.half_angle_rad * larger
            used += 1
    return out[:, :used]
