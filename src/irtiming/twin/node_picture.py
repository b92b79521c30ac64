"""Rows read at wheel angles of their own: each node's light looked up in what pixels make of the wheel's passage.

Every ray goes through the same periodic response as the wheel passes, only at another time; so it is found once, by stepping
a lag (`irtiming.twin.lag`) or counting the instants of a window (`irtiming.twin.window`), and looked up for every node into
which rays are gathered.
"""

import math
from dataclasses import dataclass
from typing import TypeAlias, final

import numpy as np
import numpy.typing as npt
from numba import njit

from irtiming.records.arrays import Array
from irtiming.twin.nodes import Nodes, trace_nodes
from irtiming.twin.noise import Values
from irtiming.twin.pixels import Weights, solid_wheel
from irtiming.twin.rays import Counts, Indices
from irtiming.twin.scene import Scene
from irtiming.twin.spread import Offsets

Level: TypeAlias = npt.NDArray[np.float64]

SPEED_CHANGE = 1e-3
"""Relative change of the wheel's speed from which `Response.per_speed` is found."""

CUTOUTS, SECOND_BLADE = (0.0, 1.0, 0.0, 1.0), (0.0, 0.0, 1.0, 0.0)
"""What is there after each of the four edges: whether a cutout, and whether the blade between edges 2 and 3."""

_CELLS_PER_SPAN = 400
_FEWEST_CELLS, _MOST_CELLS = 2**14, 2**20
_BINS_PER_SPAN = 32


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Response:
    """What a pixel makes of one point of the rig plane, 0 solid wheel for ever .. 1 cutout for ever.

    Shapes (n_cell + 1,): level, at equally spaced phi_A + theta - phi from 0 to 2 pi; per_speed, what the
    level gains per relative change of the wheel's speed.
    """

    level: Level
    per_speed: Level


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class NodePicture:
    """A scene ready to be read row by row.

    gains_dn (k, n_node), DN, is what its pixel gains when a node sees past the wheel; closed_dn (row, column), DN,
    what pixels give behind solid wheel. Where the blade between edges 2 and 3 is warmer, blade is the response to it, and
    the second of the gains what a pixel gains when a node sees it.
    """

    response: Response
    nodes: Nodes
    gains_dn: Weights
    closed_dn: Values
    gate_rad: float
    blade: Response | None = None


def cells_of(span_rad: float) -> int:
    """How many cells of a turn tell a response that changes within this angle, rad."""
    return min(max(math.ceil(2 * math.pi * _CELLS_PER_SPAN / span_rad), _FEWEST_CELLS), _MOST_CELLS)


def node_picture(scene: Scene, response: Response, *, span_rad: float, blade: Response | None = None) -> NodePicture:
    """Trace the scene and give everything in it its brightness; rays within 1/32 of the response's span are gathered.

    Parameters
    ----------
    scene
        The rig as it truly is.
    response
        Of its pixels to its wheel.
    span_rad
        Angle by which the wheel turns in one time constant, or in the window, rad.
    blade
        Of its pixels to the blade between edges 2 and 3 alone, where that is warmer.
    """
    nodes, radiance = trace_nodes(scene, span_rad / _BINS_PER_SPAN), scene.radiance
    closed = solid_wheel(scene)
    levels = np.array([radiance.level_dn(radiance.blackbody_k), radiance.level_dn(radiance.mask_k)])
    hidden = np.repeat(closed.ravel()[nodes.pixel], np.diff(nodes.first_node))
    gains: list[Weights] = [(nodes.share * (levels[nodes.behind] - hidden)).astype(np.float32)]
    if blade is not None:
        gains.append((nodes.share * radiance.blade_dn).astype(np.float32))
    return NodePicture(
        response=response,
        nodes=nodes,
        gains_dn=np.stack(gains),
        closed_dn=closed,
        gate_rad=math.pi / 2 + scene.beams.beta_1_rad,
        blade=blade,
    )


def read_rows(shot: NodePicture, wheel_angle_rad: Array, *, speed: float, out: Values) -> None:
    """Signal of one frame, written into ``out``.

    Parameters
    ----------
    shot
        The scene.
    wheel_angle_rad
        Shape (row,): wheel angle when each row is read.
    speed
        By how much the wheel was faster than nominal while the pixels looked, relative.
    out
        Shape (row, column), DN of a mean pixel.
    """
    out[...] = shot.closed_dn
    nodes, angle = shot.nodes, np.asarray(wheel_angle_rad, dtype=np.float64) + shot.gate_rad
    responses = [shot.response] if shot.blade is None else [shot.response, shot.blade]
    level = np.empty((len(responses), shot.response.level.size + 1), np.float32)
    for one, at_speed in zip(responses, level, strict=True):
        _at_speed(one.level, one.per_speed, speed, at_speed)
    _add_nodes_past_wheel(
        out.reshape(-1),
        (angle, level),
        (nodes.pixel, nodes.reference_rad, nodes.first_node, nodes.offset_rad, shot.gains_dn),
        out.shape[1],
    )


@njit(cache=True, nogil=True)
def _at_speed(level: Level, per_speed: Level, speed: float, out: Weights) -> None:
    """Levels of a wheel that was so much faster, relative; one more than there are, for rounding may lead to the turn's end."""
    for cell in range(level.size):
        out[cell] = level[cell] + speed * per_speed[cell]
    out[level.size] = out[level.size - 1]


@njit(cache=True, nogil=True)
def _add_nodes_past_wheel(
    flat: Weights,
    wheel: tuple[Array, Weights],
    table: tuple[Indices, Array, Counts, Offsets, Weights],
    columns: int,
) -> None:
    """Add to each live pixel what its nodes bring at the angle of its row; levels (k, n_cell + 2) and gains (k, n_node)."""
    angle, level = wheel
    pixel, reference, first_node, offset, gain = table
    cells = level.shape[1] - 2
    per_rad = cells / (2 * math.pi)
    for live in range(pixel.size):
        middle = (angle[pixel[live] // columns] - reference[live]) * per_rad
        middle -= math.floor(middle / cells) * cells
        first, end = first_node[live], first_node[live + 1]
        total = 0.0
        for k in range(level.shape[0]):
            total += _looked_up(level[k], (middle, per_rad), offset[first:end], gain[k, first:end])
        flat[pixel[live]] += total


@njit(cache=True, nogil=True, fastmath={"reassoc"})  # the order of the sum is free: several nodes at once
def _looked_up(level: Weights, place: tuple[float, float], offset: Offsets, gain: Weights) -> float:
    """Gains times levels, between two of which it is straight, of one pixel's nodes, which lie off the middle."""
    cells, (middle, per_rad) = level.size - 2, place
    total = 0.0
    for node in range(offset.size):
        at = middle - offset[node] * per_rad
        if at < 0:
            at += cells
        elif at >= cells:
            at -= cells
        cell = int(at)
        total += gain[node] * (level[cell] + (at - cell) * (level[cell + 1] - level[cell]))
    return total
