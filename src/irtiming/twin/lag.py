"""Pixels that follow what they see with a lag: stepped in time for one point, summed over all light of a pixel.

The lag is linear (Schatz 2023, eq. 2), so the mean over a pixel's rays may be taken after it. Each ray goes
through the same periodic response as the wheel passes, only at another time; that response is stepped once,
with steps that end at the wheel's edges, and looked up for every node into which rays are gathered.
"""

import math
from dataclasses import dataclass
from typing import TypeAlias, final

import numpy as np
import numpy.typing as npt
from numba import njit

from irtiming.records.arrays import Array
from irtiming.twin.nodes import Counts, Nodes, trace_nodes
from irtiming.twin.noise import Values
from irtiming.twin.pixels import Weights, solid_wheel
from irtiming.twin.rays import Indices, Offsets
from irtiming.twin.scene import ChopperWheel, Scene

Level: TypeAlias = npt.NDArray[np.float64]

_CELLS_PER_LAG = 400
_FEWEST_CELLS, _MOST_CELLS = 2**14, 2**20
_LONGEST_STEP = 0.05  # in time constants
_MOST_TURNS = 2000
_SPEED_CHANGE = 1e-3
_FADED = 40.0  # time constants after which nothing is left
_BINS_PER_LAG = 32


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Response:
    """What a lagging pixel sees of one point of the rig plane, 0 solid wheel for ever .. 1 cutout for ever.

    Shapes (n_cell + 1,): level, at equally spaced phi_A + theta - phi from 0 to 2 pi; per_speed, what the
    level gains per relative change of the wheel's speed.
    """

    level: Level
    per_speed: Level


def response(wheel: ChopperWheel, lag_rad: float) -> Response:
    """Periodic response to the wheel, stepped until it repeats itself.

    Parameters
    ----------
    wheel
        Its cutouts' own edges count.
    lag_rad
        Angle by which the wheel turns in one time constant of the pixel, rad.
    """
    edges = np.mod(np.array(wheel.cutout_edges_rad), 2 * math.pi)
    order = np.argsort(edges)
    behind = np.array([0.0, 1.0, 0.0, 1.0])[order]  # a point sees through the wheel after edges 1 and 3
    cells = min(max(math.ceil(2 * math.pi * _CELLS_PER_LAG / lag_rad), _FEWEST_CELLS), _MOST_CELLS)

    def at_speed(relative: float) -> Level:
        return _periodic(edges[order], behind, lag_rad * relative, cells)

    change = at_speed(1 + _SPEED_CHANGE) - at_speed(1 - _SPEED_CHANGE)
    return Response(level=at_speed(1.0), per_speed=change / (2 * _SPEED_CHANGE))


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


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LaggingPicture:
    """A scene ready to be read row by row.

    gain_dn (n_node,), DN, is what its pixel gains when a node sees past the wheel; closed_dn (row, column), DN,
    what pixels give behind solid wheel.
    """

    response: Response
    nodes: Nodes
    gain_dn: Weights
    closed_dn: Values
    gate_rad: float


def lagging_picture(scene: Scene, lag_rad: float) -> LaggingPicture:
    """Trace the scene and give everything in it its brightness; rays within 1/32 of the lag are gathered.

    Parameters
    ----------
    scene
        The rig as it truly is.
    lag_rad
        Angle by which the wheel turns in one time constant of the pixel, rad.
    """
    nodes, radiance = trace_nodes(scene, lag_rad / _BINS_PER_LAG), scene.radiance
    closed = solid_wheel(scene)
    levels = np.array([radiance.level_dn(radiance.blackbody_k), radiance.level_dn(radiance.mask_k)])
    hidden = np.repeat(closed.ravel()[nodes.pixel], np.diff(nodes.first_node))
    return LaggingPicture(
        response=response(scene.wheel, lag_rad),
        nodes=nodes,
        gain_dn=(nodes.share * (levels[nodes.behind] - hidden)).astype(np.float32),
        closed_dn=closed,
        gate_rad=math.pi / 2 + scene.beams.beta_1_rad,
    )


def read_rows(shot: LaggingPicture, wheel_angle_rad: Array, *, speed: float, out: Values) -> None:
    """Signal of one frame, written into ``out``.

    Parameters
    ----------
    shot
        The scene.
    wheel_angle_rad
        Shape (row,): wheel angle when each row is read.
    speed
        By how much the wheel was faster than nominal while the pixels followed it, relative.
    out
        Shape (row, column), DN of a mean pixel.
    """
    out[...] = shot.closed_dn
    nodes = shot.nodes
    level = (shot.response.level + speed * shot.response.per_speed).astype(np.float32)
    _add_nodes_past_wheel(
        out.reshape(-1),
        (np.asarray(wheel_angle_rad, dtype=np.float64) + shot.gate_rad, level),
        (nodes.pixel, nodes.reference_rad, nodes.first_node, nodes.offset_rad, shot.gain_dn),
        out.shape[1],
    )


@njit(cache=True, nogil=True)
def _add_nodes_past_wheel(
    flat: Weights,
    wheel: tuple[Array, Weights],
    table: tuple[Indices, Array, Counts, Offsets, Weights],
    columns: int,
) -> None:
    """Add to each live pixel what its nodes bring at the angle of its row."""
    angle, level = wheel
    pixel, reference, first_node, offset, gain = table
    cells = level.size - 1
    per_rad = cells / (2 * math.pi)
    for live in range(pixel.size):
        middle = (angle[pixel[live] // columns] - reference[live]) * per_rad
        middle -= math.floor(middle / cells) * cells
        total = 0.0
        for node in range(first_node[live], first_node[live + 1]):
            place = middle - offset[node] * per_rad
            if place < 0:
                place += cells
            elif place >= cells:
                place -= cells
            cell = min(int(place), cells - 1)
            total += gain[node] * (level[cell] + (place - cell) * (level[cell + 1] - level[cell]))
        flat[pixel[live]] += total
