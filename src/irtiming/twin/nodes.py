"""Directions from which light comes to each pixel of a lagging camera, gathered from many rays into few nodes.

The pixels of a lagging camera change nearly all the time, so each of their frames costs a look-up for every
direction; but neighbouring directions tell nearly the same, and a few that keep mean and variance do. Where a
pixel's light comes over the edge of the mask's opening, thousands of rays say how much; elsewhere 144 in a large image,
and up to 2304 in a small one, whose rows have few pixels to make up for each other.
"""

import math
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numba import njit

from irtiming.records.arrays import Array
from irtiming.twin.glare import stray_places
from irtiming.twin.kernels import View, grade, kind_of_pixel, to_rig, trace_pixel, variant
from irtiming.twin.rays import Counts, Indices, in_parallel, view_of
from irtiming.twin.scene import Scene
from irtiming.twin.spread import VARIANTS, Offsets, edge_rays, graded_spread, reach_px

_EVEN_RAY_BUDGET = 2.2e7
_FEWEST_EVEN_RAYS, _MOST_EVEN_RAYS = 144, 2304  # few pixels must each be true: the sum of many is
_STRAY_RAYS, _STRAY_WIDER = (
    600,
    6.0,
)  # rays of the tail that glare makes, and how much wider than others they are gathered
_MOST_BINS = 128


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
    optics = scene.optics
    n_even = optics.rays_along_pixel**2 or int(
        np.clip(_EVEN_RAY_BUDGET / (rows * columns), _FEWEST_EVEN_RAYS, _MOST_EVEN_RAYS)
    )
    even = graded_spread(n_even, optics, variants=1)
    edge = graded_spread(edge_rays(rows, columns), optics, variants=VARIANTS)
    reach = (reach_px(optics), width_rad, optics.glare_share)
    stray = stray_places(optics, _STRAY_RAYS if optics.glare_share else 1, variants=VARIANTS)

    def one_row(row: int) -> Any:
        return _row_nodes(row, columns, view, (even, edge, stray), reach)

    pixel, reference, n_node, offset, share, behind = in_parallel(one_row, rows)
    return Nodes(
        pixel=pixel,
        reference_rad=reference,
        first_node=np.concatenate([[0], np.cumsum(n_node)]),
        offset_rad=offset,
        share=share,
        behind=behind,
    )


@njit(cache=True, nogil=True)
def _row_nodes(
    row: int, columns: int, view: View, spreads: tuple[Offsets, Offsets, Offsets], how: tuple[float, float, float]
) -> Any:
    """Live pixels of one row: index, reference, number of nodes; and of all their nodes offset, share, behind."""
    reach, width, astray = how
    most = spreads[1].shape[2] + spreads[0].shape[2] + spreads[2].shape[1]
    pixel, reference = np.empty(columns, np.int32), np.empty(columns, np.float64)
    n_node = np.zeros(columns, np.int64)
    room = columns * min(8 * _MOST_BINS, 2 * most)
    offset, share, behind = np.empty(room, np.float32), np.empty(room, np.float32), np.empty(room, np.int32)
    rays = np.empty((2, most), np.float32)
    live, used = 0, 0
    for column in range(columns):
        kind = kind_of_pixel(row, column, view, reach)
        if kind == 2 and astray == 0:  # nothing but solid wheel
            continue
        x, y = to_rig(float(row), float(column), view)
        centre = math.atan2(y, view.mirror * x)
        copies = spreads[1] if kind == 3 else spreads[0]  # the edge of the opening has more
        spread = copies[grade(row, column, view, copies.shape[0]), variant(row, column, copies.shape[1])]
        before = used
        for tail in range(2 if astray > 0 else 1):
            gathered, light = width, (1.0 - astray) / spread.shape[0]
            if tail == 1:
                spread = spreads[2][variant(row, column, spreads[2].shape[0])]
                gathered, light = width * _STRAY_WIDER, astray / spread.shape[0]
            found = trace_pixel(rays, (row, column, centre), view, spread)
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
