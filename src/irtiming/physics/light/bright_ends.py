r"""What an opening adds to the exposed fraction whose light is brighter towards one end, or at both ends than in its middle.

.. math:: S = \sum_i s_i \left(\frac{1 - u_i^2}{4} - \frac{1}{6}\right), \qquad U = \sum_i s_i \frac{u_i - u_i^3}{4}

u_i is where edge i stands in the opening, -1 at its low end and 1 at its high one; one that stands elsewhere adds nothing. s_i
is +1 of an edge that uncovers and -1 of one that covers (`physics.wheel`).

S belongs to light 1 + s u, whose centre is shifted back by as much as that moves the mean: a skew does not look like a delay. A
mask whose own centre lies beside the axle looks like this to the wheel. U belongs to light 1 + b (3 u^2 - 1) / 2: a lens whose
magnification changes over the image shows the opening's ends larger or smaller than its middle.

During the integration window u_i falls evenly, and both are means over it (eq. 1): of a polynomial, over the part of the window
in which the edge stands in the opening.
"""

import math
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numba import njit

from irtiming.physics.wheel import EDGE_SIGNS, TURN
from irtiming.records.arrays import Array
from irtiming.records.wheel_geometry import WheelModel

_SHORTEST_RAD = 1e-9


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class BrightEnds:
    """S and U, shapes (n,), and their derivatives per rad to the opening angle and to the sweep, shapes (2, n).

    Opening centre and middle of the window are kept by both.
    """

    skew: Array
    skew_slopes: Array
    bow: Array
    bow_slopes: Array


def bright_ends(wheel_angle_rad: Array, model: WheelModel, *, sweep_rad: float = 0.0) -> BrightEnds:
    """Both, averaged over the window.

    Parameters
    ----------
    wheel_angle_rad
        Shape (n,), any real; wheel angle at the *start* of the window, rad.
    model
        Geometry.
    sweep_rad
        Angle by which the wheel turns during the window, rad; with the opening angle less than a turn.
    """
    sweep = max(abs(sweep_rad), _SHORTEST_RAD)
    centre = model.opening_coordinate_rad + np.asarray(wheel_angle_rad, dtype=float) + sweep_rad / 2
    found = _of_edges(centre, np.array(model.cutout_edges_rad), model.opening_angle_rad, sweep)
    return BrightEnds(skew=found[0], skew_slopes=found[1:3], bow=found[3], bow_slopes=found[4:])


@njit(cache=True, nogil=True)
def _of_edges(centre: Array, edges: Array, gamma: float, sweep: float) -> Any:
    """S, its derivatives, U and its derivatives, shape (6, n), from the opening's centre in the middle of the window."""
    out = np.zeros((6, centre.size))
    for k in range(centre.size):
        for i in range(4):
            beside = (edges[i] - centre[k] + math.pi) % TURN - math.pi
            first, last = (beside + sweep / 2) / (gamma / 2), (beside - sweep / 2) / (gamma / 2)
            high, low = min(first, 1.0), max(last, -1.0)
            if low >= high:
                continue
            part = EDGE_SIGNS[i] * (high - low) / (first - last)
            skew = part * (1 / 12 - (high**2 + high * low + low**2) / 12)
            bow = part * (high + low) * (1 - (high**2 + low**2) / 2) / 8
            skew_first, bow_first = _at_instant(first, EDGE_SIGNS[i])
            skew_last, bow_last = _at_instant(last, EDGE_SIGNS[i])
            out[0, k] += skew
            out[1, k] += (skew - (first * skew_first - last * skew_last) / (first - last)) / gamma
            out[2, k] += ((skew_first + skew_last) / 2 - skew) / sweep
            out[3, k] += bow
            out[4, k] += (bow - (first * bow_first - last * bow_last) / (first - last)) / gamma
            out[5, k] += ((bow_first + bow_last) / 2 - bow) / sweep
    return out


@njit(cache=True, nogil=True)
def _at_instant(u: float, sign: float) -> tuple[float, float]:
    """What an edge adds to S and U that stands at u."""
    if abs(u) >= 1:
        return 0.0, 0.0
    return sign * ((1 - u**2) / 4 - 1 / 6), sign * (u - u**3) / 4
