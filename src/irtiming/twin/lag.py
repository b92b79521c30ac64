"""What pixels that follow the scene with a lag make of the passing wheel, stepped in time for one point.

The lag is linear (Schatz 2023, eq. 2), so the mean over a pixel's rays may be taken after it. Steps end at the wheel's edges.
"""

import math
from collections.abc import Sequence
from typing import final

import numpy as np
from numba import njit

from irtiming.records.arrays import Array
from irtiming.twin.node_picture import CUTOUTS, SPEED_CHANGE, Level, Response, cells_of
from irtiming.twin.scene import ChopperWheel

_CELLS_PER_LAG = 400
_LONGEST_STEP = 0.05  # in time constants
_MOST_TURNS = 2000
_FADED = 40.0  # time constants after which nothing is left


def response(wheel: ChopperWheel, lag_rad: float, *, seen: Sequence[float] = CUTOUTS) -> Response:
    """Periodic response to the wheel, stepped until it repeats itself.

    Parameters
    ----------
    wheel
        Its cutouts' own edges count.
    lag_rad
        Angle by which the wheel turns in one time constant of the pixel, rad.
    seen
        What a point sees after each of the four edges: through the wheel after edges 1 and 3.
    """
    edges = np.mod(np.array(wheel.cutout_edges_rad), 2 * math.pi)
    order = np.argsort(edges)
    behind = np.array(seen, dtype=np.float64)[order]
    cells = cells_of(lag_rad)

    def at_speed(relative: float) -> Level:
        return _periodic(edges[order], behind, lag_rad * relative, cells)

    change = at_speed(1 + SPEED_CHANGE) - at_speed(1 - SPEED_CHANGE)
    return Response(level=at_speed(1.0), per_speed=change / (2 * SPEED_CHANGE))


@njit(cache=True, nogil=True)
def _periodic(edges: Array, behind: Array, lag_rad: float, cells: int) -> Level:
    """Level at each cell's border after so many turns that one more changes nothing."""
    level = np.empty(cells + 1)
    level[cells] = 0.5
    width = 2 * math.pi / cells
    for _ in range(_MOST_TURNS):
        before = level[cells]
        level[0] = before
        seen, following = behind[edges.size - 1], 0
        for cell in range(cells):
            value, place, end = level[cell], cell * width, (cell + 1) * width
            while following < edges.size and edges[following] < end:
                value = _follow(value, seen, (edges[following] - place) / lag_rad)
                place, seen = edges[following], behind[following]
                following += 1
            level[cell + 1] = _follow(value, seen, (end - place) / lag_rad)
        if abs(level[cells] - before) < 1e-13:
            break
    return level


@njit(cache=True, nogil=True)
def _follow(value: float, seen: float, span: float) -> float:
    """Level after ``span`` time constants of looking at ``seen``: classical Runge-Kutta steps."""
    steps = max(1, math.ceil(span / _LONGEST_STEP))
    step = span / steps
    for _ in range(steps):
        first = seen - value
        second = seen - (value + 0.5 * step * first)
        third = seen - (value + 0.5 * step * second)
        fourth = seen - (value + step * third)
        value += step * (first + 2 * second + 2 * third + fourth) / 6
    return value


@njit(cache=True, nogil=True)
def _fading(cells: int) -> Level:
    """What is left of a departure, one value every 1 / _CELLS_PER_LAG time constants."""
    left = np.empty(cells + 1)
    left[0] = 1.0
    for cell in range(cells):
        left[cell + 1] = _follow(left[cell], 0.0, 1.0 / _CELLS_PER_LAG)
    left[cells] = 0.0
    return left


@final
class Fading:
    """What is left of a pixel's departure from where it is drawn to, stepped in time."""

    def __init__(self, time_constant_s: float) -> None:
        self._left = _fading(int(_FADED * _CELLS_PER_LAG))
        self._cells_per_s = _CELLS_PER_LAG / time_constant_s

    def left_after(self, time_s: Array) -> Array:
        """Share that is left this long afterwards, s, any shape; nothing after 40 time constants."""
        return np.interp(np.asarray(time_s) * self._cells_per_s, np.arange(self._left.size), self._left)
