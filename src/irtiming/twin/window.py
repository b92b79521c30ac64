"""What pixels that average over a window make of the passing wheel, counted instant by instant for one point."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numba import njit

from irtiming.records.arrays import Array
from irtiming.twin.node_picture import CUTOUTS, SPEED_CHANGE, Level, Response, cells_of
from irtiming.twin.scene import FADED_TAILS, CameraTiming, ChopperWheel


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Weighing:
    """A window as a table: weight (n,), adding up to 1, of the instants time_s (n,) after its start."""

    time_s: Array
    weight: Array


_WEIGHTS = 400_000
_FEWEST_SHAPED = 160


def weights(timing: CameraTiming) -> Weighing:
    """How much each instant counts, tabulated: rise, plateau, fall and tail.

    Parameters
    ----------
    timing
        Of a photon camera.
    """
    begin_s = -timing.rise_s / 2
    span_s = timing.integration_time_s + timing.after_s - begin_s
    time_s = begin_s + (np.arange(_WEIGHTS) + 0.5) / _WEIGHTS * span_s
    weight = _ramp(time_s, timing.rise_s) * (1 - _ramp(time_s - timing.integration_time_s, timing.fall_s))
    if timing.tail_share > 0:
        late_s = time_s - timing.integration_time_s
        tail = np.where((late_s > 0) & (late_s < FADED_TAILS * timing.tail_s), np.exp(-late_s / timing.tail_s), 0.0)
        weight = (1 - timing.tail_share) * weight / weight.sum() + timing.tail_share * tail / tail.sum()
    return Weighing(time_s=time_s, weight=weight / weight.sum())


def instants_s(timing: CameraTiming) -> Array:
    """Instants that stand for equal parts of what an integration window counts, in order, shape (n_instant,), s.

    Parameters
    ----------
    timing
        Of a photon camera; the instants are counted from the start of its window.
    """
    if timing.is_rectangular:
        return (np.arange(timing.substeps) + 0.5) / timing.substeps * timing.integration_time_s
    table, n = weights(timing), max(timing.substeps, _FEWEST_SHAPED)
    below = np.cumsum(table.weight) - 0.5 * table.weight
    parts = np.interp((np.arange(8 * n) + 0.5) / (8 * n), below, table.time_s)
    return parts.reshape(n, 8).mean(axis=1)


def centre_s(timing: CameraTiming) -> float:
    """Centre of gravity of an integration window, s after its start.

    Parameters
    ----------
    timing
        Of a photon camera.
    """
    if timing.is_rectangular:
        return timing.integration_time_s / 2
    table = weights(timing)
    return float(table.weight @ table.time_s)


def _ramp(time_s: Array, long_s: float) -> Array:
    """From 0 to 1 on a straight line about time 0."""
    if long_s == 0:
        return np.asarray(time_s >= 0, dtype=np.float64)
    return np.clip(time_s / long_s + 0.5, 0, 1)


def response(
    wheel: ChopperWheel, window_rad: float, *, instants: Array, seen: Sequence[float] = CUTOUTS
) -> Response:  # fmt: skip
    """Share of a window's instants in which a point sees through the wheel, by where the wheel is when it begins.

    Parameters
    ----------
    wheel
        Its cutouts' own edges count.
    window_rad
        Angle by which the wheel turns in a window, rad.
    instants
        Shape (n_instant,), in windows from its beginning: each stands for an equal part of what counts.
    seen
        What a point sees after each of the four edges: through the wheel after edges 1 and 3.
    """
    edges, cells = np.array(wheel.cutout_edges_rad), cells_of(window_rad)
    behind = np.array(seen, dtype=np.float64)

    def at_speed(relative: float) -> Level:
        return _counted(edges, behind, instants * (window_rad * relative), cells)

    change = at_speed(1 + SPEED_CHANGE) - at_speed(1 - SPEED_CHANGE)
    return Response(level=at_speed(1.0), per_speed=change / (2 * SPEED_CHANGE))


@njit(cache=True, nogil=True)
def _counted(edges: Array, behind: Array, instants_rad: Array, cells: int) -> Level:
    """Share of instants at which a cutout is there, for windows that begin at each cell's border."""
    level = np.empty(cells + 1)
    for cell in range(cells + 1):
        count = 0.0
        for instant in instants_rad:
            turned = cell * 2 * math.pi / cells + instant - edges[0]
            turned += edges[0] - 2 * math.pi * math.floor(turned / (2 * math.pi))  # from edge 0 on
            after = 0
            while after < 3 and turned >= edges[after + 1]:
                after += 1
            count += behind[after]
        level[cell] = count / instants_rad.size
    return level
