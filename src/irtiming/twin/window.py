"""What pixels that average over a window make of the passing wheel, counted instant by instant for one point."""

import math

import numpy as np
from numba import njit

from irtiming.records.arrays import Array
from irtiming.twin.node_picture import SPEED_CHANGE, Level, Response, cells_of
from irtiming.twin.scene import ChopperWheel


def response(wheel: ChopperWheel, window_rad: float, *, n_instants: int) -> Response:
    """Share of a window's instants in which a point sees through the wheel, by where the wheel is when it begins.

    Parameters
    ----------
    wheel
        Its cutouts' own edges count.
    window_rad
        Angle by which the wheel turns in a window, rad.
    n_instants
        Middles of so many equal parts stand for the window.
    """
    edges, cells = np.array(wheel.cutout_edges_rad), cells_of(window_rad)

    def at_speed(relative: float) -> Level:
        return _counted(edges, window_rad * relative, n_instants, cells)

    change = at_speed(1 + SPEED_CHANGE) - at_speed(1 - SPEED_CHANGE)
    return Response(level=at_speed(1.0), per_speed=change / (2 * SPEED_CHANGE))


@njit(cache=True, nogil=True)
def _counted(edges: Array, window_rad: float, n_instants: int, cells: int) -> Level:
    """Share of instants at which a cutout is there, for windows that begin at each cell's border."""
    level = np.empty(cells + 1)
    for cell in range(cells + 1):
        count = 0
        for instant in range(n_instants):
            turned = cell * 2 * math.pi / cells + (instant + 0.5) / n_instants * window_rad - edges[0]
            turned += edges[0] - 2 * math.pi * math.floor(turned / (2 * math.pi))  # from edge 0 on
            count += edges[1] <= turned < edges[2] or turned >= edges[3]
        level[cell] = count / n_instants
    return level
