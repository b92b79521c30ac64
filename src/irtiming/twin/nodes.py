"""Directions from which light comes to each pixel of a lagging camera, gathered from many rays into few nodes.

The pixels of a lagging camera change nearly all the time, so each of their frames costs a look-up for every
direction; but neighbouring directions tell nearly the same, and a few that keep mean and variance do. Where a
pixel's light comes over the edge of the mask's opening, thousands of rays say how much; elsewhere a hundred or two.
"""

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from os import cpu_count
from typing import Any, TypeAlias, final

import numpy as np
import numpy.typing as npt
from numba import njit
from scipy.special import ndtr

from irtiming.records.arrays import Array
from irtiming.twin.glare import stray_places
from irtiming.twin.kernels import View, in_opening, in_ring, scatter, to_rig, turned
from irtiming.twin.rays import Indices, Offsets, view_of
from irtiming.twin.scene import Scene

Counts: TypeAlias = npt.NDArray[np.int64]

_RAYS_OF_EVEN_PIXEL = 144
_EDGE_RAY_BUDGET = 3e6
_MOST_EDGE_RAYS = 10_000
_VARIANTS = 16
_REACH = 4.0  # standard deviations of the blur
_STRAY_RAYS, _STRAY_WIDER = (
    600,
    6.0,
)  # rays of the tail that glare makes, and how much wider than others they are gathered
_MOST_BINS = 128
_GOLDEN = (math.sqrt(5) - 1) / 2


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Nodes:
    """The pixels that ever change, with the directions that stand for their light.

    Shapes (n_live,): pixel, flat index; reference_rad, angle of its centre. first_node (n_live + 1,): pixel i
    owns nodes first_node[i] to first_node[i + 1]. Shapes (n_node,): offset_rad, angle minus the reference;
    share, part of the pixel's light; behind, what a cutout shows there: 0 the mask's opening, 1 its plate.
    """

    pixel: Indices
    reference_rad: Array
    first_node: Counts
    offset_rad: Offsets
    share: Offsets
    behind: Indices


def trace_nodes(scene: Scene, width_rad: float) -> Nodes:
    """Follow the rays of every pixel once and gather those of neighbouring angle.

    Parameters
    ----------
    scene
        Mask, wheel, optics and size of the image count.
    width_rad
        Rays within this angle, or within 1/128 of their pixel, become two nodes, one standard deviation to
        either side of their mean, rad.
    """
    rows, columns = scene.detector.rows, scene.detector.columns
    view = view_of(scene.wheel, scene.mask, optics=scene.optics, shape=(rows, columns))
    optics, blur_px = scene.optics, scene.optics.blur_rows_columns_px
    n_even = scene.optics.rays_along_pixel**2 or _RAYS_OF_EVEN_PIXEL
    n_edge = round(min(_EDGE_RAY_BUDGET / math.sqrt(rows * columns), _MOST_EDGE_RAYS))
    even = pixel_spread(n_even, blur_px, variants=1)
    edge = pixel_spread(n_edge, blur_px, variants=_VARIANTS)
    reach = (0.71 + _REACH * max(blur_px), width_rad, optics.glare_share)
    stray = stray_places(optics, _STRAY_RAYS if optics.glare_share else 1, variants=_VARIANTS)

    def one_row(row: int) -> Any:
        return _row_nodes(row, columns, view, (even, edge, stray), reach)

    pixel, reference, n_node, offset, share, behind = _in_parallel(one_row, rows)
    return Nodes(
        pixel=pixel,
        reference_rad=reference,
        first_node=np.concatenate([[0], np.cumsum(n_node)]),
        offset_rad=offset,
        share=share,
        behind=behind,
    )


def _in_parallel(one_row: Callable[[int], Any], rows: int) -> list[Any]:
    """Results of all rows, each kind in one array."""
    with ThreadPoolExecutor(cpu_count()) as pool:
        parts = list(pool.map(one_row, range(rows)))
    return [np.concatenate(part) for part in zip(*parts, strict=True)]


def pixel_spread(n: int, blur_rows_columns_px: tuple[float, float], *, variants: int) -> Offsets:
    """Places, px from a pixel's centre, from which its light comes in equal parts: its own square, blurred.

    Parameters
    ----------
    n
        Places of one variant; they fill the plane evenly.
    blur_rows_columns_px
        Standard deviation of the Gaussian from row to row and from column to column, px.
    variants
        Shifted copies, each with the mean 0, the variance 1/12 + blur^2 along each axis and no covariance.

    Returns
    -------
    Shape (variants, n, 2): row, column.
    """
    order = np.arange(n)
    shift = np.random.Generator(np.random.SFC64(1)).random((variants, 1, 2))
    even = np.stack([(order + 0.5) / n, np.mod(0.5 + order * _GOLDEN, 1.0)], axis=1)
    even = np.mod(even + shift, 1.0)
    place = np.stack([_smeared(even[..., axis], blur_rows_columns_px[axis]) for axis in (0, 1)], axis=-1)
    place = place - place.mean(axis=1, keepdims=True)
    slant = np.mean(place[..., 0] * place[..., 1], axis=1) / np.mean(place[..., 0] ** 2, axis=1)
    place[..., 1] -= slant[:, None] * place[..., 0]
    place *= np.sqrt((1 / 12 + np.square(blur_rows_columns_px)) / np.mean(place**2, axis=1, keepdims=True))
    return place.astype(np.float32)


def _smeared(even: Array, blur_px: float) -> Array:
    """Places along one axis, px, of parts of the light from 0 to 1, any shape."""
    if blur_px == 0:
        return even - 0.5
    grid = np.linspace(-0.5 - 6 * blur_px, 0.5 + 6 * blur_px, 40_001)
    density = ndtr((grid + 0.5) / blur_px) - ndtr((grid - 0.5) / blur_px)
    below = np.cumsum(density) - 0.5 * density
    return np.interp(even, below / density.sum(), grid)


@njit(cache=True, nogil=True)
def _row_nodes(
    row: int, columns: int, view: View, spreads: tuple[Offsets, Offsets, Offsets], how: tuple[float, float, float]
) -> Any:
    """Live pixels of one row: index, reference, number of nodes; and of all their nodes offset, share, behind."""
    reach, width, astray = how
    most = spreads[1].shape[1] + spreads[0].shape[1] + spreads[2].shape[1]
    pixel, reference = np.empty(columns, np.int32), np.empty(columns, np.float64)
    n_node = np.zeros(columns, np.int64)
    room = columns * min(8 * _MOST_BINS, 2 * most)
    offset, share, behind = np.empty(room, np.float32), np.empty(room, np.float32), np.empty(room, np.int32)
    rays = np.empty((2, most), np.float32)
    live, used = 0, 0
    for column in range(columns):
        kind = _kind_of_pixel(row, column, view, reach)
        if kind == 2 and astray == 0:  # nothing but solid wheel
            continue
        x, y = to_rig(float(row), float(column), view)
        centre = math.atan2(y, view.mirror * x)
        spread = spreads[0][0]
        if kind == 3:  # the edge of the opening
            spread = spreads[1][_variant(row, column, spreads[1].shape[0])]
        before = used
        for tail in range(2 if astray > 0 else 1):
            gathered, light = width, (1.0 - astray) / spread.shape[0]
            if tail == 1:
                spread = spreads[2][_variant(row, column, spreads[2].shape[0])]
                gathered, light = width * _STRAY_WIDER, astray / spread.shape[0]
            found = _trace_pixel(rays, (row, column, centre), view, spread)
            for side in range(2):
                part, first = np.sort(rays[side, : found[side]]), used
                used = _add_nodes(part, (gathered, light), (offset, share), used)
                behind[first:used] = side
        n_node[live] = used - before
        if used > before:
            pixel[live], reference[live] = row * columns + column, centre
            live += 1
    return (
        pixel[:live].copy(),
        reference[:live].copy(),
        n_node[:live].copy(),
        offset[:used].copy(),
        share[:used].copy(),
        behind[:used].copy(),
    )


@njit(cache=True, nogil=True)
def _variant(row: int, column: int, variants: int) -> int:
    """Which copy of the spread a pixel takes, as if by chance."""
    return int((scatter(row, column, 0)[0] + 0.5) * variants) % variants


@njit(cache=True, nogil=True)
def _kind_of_place(row: float, column: float, view: View) -> int:
    """What a cutout shows at a place of the image: 0 the opening, 1 the plate; 2 where there is no cutout."""
    x, y = to_rig(row, column, view)
    if not in_ring(x, y, view):
        return 2
    return 0 if in_opening(x, y, view) else 1


@njit(cache=True, nogil=True)
def _kind_of_pixel(row: int, column: int, view: View, reach: float) -> int:
    """What a cutout shows to a pixel: 0 the opening, 1 the plate or its border, 2 nothing, 3 the opening's edge."""
    first = _kind_of_place(float(row), float(column), view)
    same = True
    for ring in range(1, 4):
        for step in range(16):
            angle = step * math.pi / 8
            away = reach * ring / 3
            kind = _kind_of_place(row + away * math.sin(angle), column + away * math.cos(angle), view)
            if (kind == 0) != (first == 0):
                return 3
            same = same and kind == first
    return first if same else 1


@njit(cache=True, nogil=True)
def _trace_pixel(rays: Offsets, place: tuple[int, int, float], view: View, spread: Offsets) -> tuple[int, int]:
    """Angles of a pixel's rays minus that of its centre, those to the opening and those to the plate; how many."""
    row, column, centre = place
    direction = (math.cos(centre), math.sin(centre))
    opening, plate = 0, 0
    for ray in range(spread.shape[0]):
        x, y = to_rig(row + spread[ray, 0], column + spread[ray, 1], view)
        if not in_ring(x, y, view):
            continue
        angle = turned(view.mirror * x, y, direction)
        if in_opening(x, y, view):
            rays[0, opening] = angle
            opening += 1
        else:
            rays[1, plate] = angle
            plate += 1
    return opening, plate


@njit(cache=True, nogil=True)
def _add_nodes(rays: Offsets, how: tuple[float, float], nodes: tuple[Offsets, Offsets], used: int) -> int:
    """Nodes of rays that are given in order, added to those that there are; how many there are now."""
    width, share = how
    if rays.size == 0:
        return used
    width = max(width, 1.0001 * (rays[rays.size - 1] - rays[0]) / _MOST_BINS)
    begin = 0
    while begin < rays.size:
        limit = rays[begin] + width
        end = begin + 1
        while end < rays.size and rays[end] < limit:
            end += 1
        n, mean, square = end - begin, 0.0, 0.0
        for ray in range(begin, end):
            mean += rays[ray] / n
        for ray in range(begin, end):
            square += (rays[ray] - mean) ** 2 / n
        away = math.sqrt(square)
        sides = 1 if n == 1 else 2
        for side in range(sides):
            nodes[0][used] = mean + (2 * side - 1) * away if sides == 2 else mean
            nodes[1][used] = share * n / sides
            used += 1
        begin = end
    return used
