r"""The wheel and the mask opening behind it: wheel angle in, exposed fraction out (Schatz 2023, 2.5, figure 4).

Definitions
-----------
===================  =======  ==============================================================================
name                 symbol   definition
===================  =======  ==============================================================================
wheel angle          theta    grows with rotation; 0 when the reference edge passes the application gate
cutout edge angles   alpha_i  wheel angle at which edge i passes the application gate; alpha_0 = 0
gate angle           phi_A    polar angle of the application gate, 90 deg + beta_1
opening angle        gamma    angle of the mask opening about the axle
centre angle         phi_M    polar angle of the bisector of the mask opening
===================  =======  ==============================================================================

Polar angles are taken about the axle, 0 at 3 o'clock, and grow *clockwise*, as image rows grow downwards. The wheel
turns clockwise as the camera sees it; for a counterclockwise wheel the whole drawing is mirrored about the vertical
through the axle, which turns phi into pi - phi and leaves every formula below as it is.

A point at polar angle phi has the wheel coordinate alpha = phi_A + theta - phi. It sees the blackbody where alpha lies
in [alpha_1, alpha_2) or [alpha_3, 2 pi + alpha_0). Edge i has passed the point n_i = floor((alpha - alpha_i) / 2 pi)
times, so the point is open when 1 + n_1 + n_3 - n_0 - n_2 is 1 and closed when it is 0.

The exposed fraction is the mean of that number over the opening, and the value of a snapshot frame is in turn its mean
over the integration window (eq. 1). So only the first and second integrals of the floor function are needed.
"""

from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numba import njit

from irtiming.errors import GeometryError
from irtiming.records.arrays import Array
from irtiming.records.rig import Rotation
from irtiming.records.wheel_geometry import EdgeAngles, WheelModel

TURN = 2 * np.pi
_PER_RAD = 1 / TURN
EDGE_SIGNS = (-1.0, 1.0, -1.0, 1.0)
"""What edge 0..3 does to a point that it passes: +1 uncovers it, -1 covers it."""


def wheel_model(
    cutout_edges_rad: EdgeAngles,
    gate_offset_rad: float,
    *,
    opening_angle_rad: float,
    centre_angle_rad: float,
    rotation: Rotation = "clockwise",
) -> WheelModel:
    """Model of the rig, mirrored to a clockwise one where the wheel turns the other way.

    Parameters
    ----------
    cutout_edges_rad
        alpha_0 .. alpha_3, ascending, rad.
    gate_offset_rad
        beta_1, angle of the application gate from the downward vertical, rad.
    opening_angle_rad, centre_angle_rad
        gamma and phi_M, rad.
    rotation
        As the camera sees it.

    Raises
    ------
    GeometryError
        If the opening is at least as wide as a cutout or a blade: there is no plateau to normalise on.
    """
    edges = np.asarray(cutout_edges_rad)
    arcs = steps_around(edges)
    if not np.all(arcs > opening_angle_rad):
        raise GeometryError(
            f"opening_angle_deg = {np.degrees(opening_angle_rad):.3f} is not narrower than each cutout and blade "
            f"(narrowest {np.degrees(arcs.min()):.3f} deg), so the opening is never wholly open or covered; "
            "use a narrower mask or correct [mask] opening_angle_deg and [wheel] cutout_edges_rad"
        )
    centre = centre_angle_rad if rotation == "clockwise" else np.pi - centre_angle_rad
    return WheelModel(
        cutout_edges_rad=cutout_edges_rad,
        gate_angle_rad=np.pi / 2 + gate_offset_rad,
        opening_angle_rad=opening_angle_rad,
        centre_angle_rad=centre,
    )


def steps_around(angle_rad: Array) -> Array:
    """From each of some angles, in order, to the next, and from the last to the first a turn on, rad; both of shape (n,)."""
    return np.diff(np.append(angle_rad, angle_rad[0] + TURN))


@njit(cache=True, nogil=True)
def _passing(alpha: float, edge: float, sweep: float) -> tuple[float, float, float]:
    """How often the edge has passed, and the integral of that over alpha, both averaged while alpha grows by the sweep.

    Third is the sum of that integral at both ends of the sweep.

    Nothing is a difference of large numbers, which a short sweep would show.
    """
    first, last = (alpha - edge) * _PER_RAD, (alpha + sweep - edge) * _PER_RAD
    before, after = np.floor(first), np.floor(last)
    passed, swept = before, before * (first + last) / 2 - before * (before + 1) / 2
    ends = before * first + after * last - (before * (before + 1) + after * (after + 1)) / 2
    while before < after:  # the turns that are completed on the way
        before += 1.0
        share = (last - before) / (last - first)
        passed, swept = passed + share, swept + share * (last - before) / 2
    return passed, TURN * swept, TURN * ends


def _opening_ends(wheel_angle_rad: Array, model: WheelModel) -> tuple[Array, Array]:
    # within one turn: the integrals grow with the cube of the turns, and their differences would lose digits
    centre = np.mod(model.opening_coordinate_rad + np.asarray(wheel_angle_rad, dtype=float), TURN)
    return centre - model.opening_angle_rad / 2, centre + model.opening_angle_rad / 2


def exposed_fraction(wheel_angle_rad: Array, model: WheelModel, *, sweep_rad: float = 0.0) -> Array:
    """Fraction of the mask opening that the wheel leaves uncovered, averaged over the integration window.

    Parameters
    ----------
    wheel_angle_rad
        Any shape, any real; wheel angle at the *start* of the window, rad.
    model
        Geometry.
    sweep_rad
        Angle by which the wheel turns during the window, rad; 0 for an instantaneous sample.

    Returns
    -------
    Same shape, within [0, 1]; 0 covered, 1 open. Piecewise linear for ``sweep_rad`` = 0, with parabolic corners else.

    Notes
    -----
    Schatz 2023, eq. (1) and figure 4(b). Assumes straight radial edges of wheel and mask; section 4 doubts one of them.
    """
    low, high = _opening_ends(wheel_angle_rad, model)
    edges = np.array(model.cutout_edges_rad)
    arcs = _open_arcs(high.ravel(), edges, sweep_rad) - _open_arcs(low.ravel(), edges, sweep_rad)
    return np.asarray((arcs / model.opening_angle_rad).reshape(low.shape))


@njit(cache=True, nogil=True)
def _open_arcs(alpha: Array, edges: Array, sweep: float) -> Any:
    """Open part of the arcs from 0 to alpha, averaged while these grow by the sweep, up to a constant; rad, shape (n,)."""
    out = np.empty(alpha.size)
    for k in range(alpha.size):
        arc, sign = alpha[k] + sweep / 2, -1.0
        for i in range(4):
            arc, sign = arc + sign * _passing(alpha[k], edges[i], sweep)[1], -sign
        out[k] = arc
    return out


def fading_fraction(wheel_angle_rad: Array, model: WheelModel, *, fades_rad: float) -> Array:
    """Exposed fraction averaged with a weight that fades from the wheel angle on: exp(-x / b) / b.

    Parameters
    ----------
    wheel_angle_rad
        Any shape, any real; wheel angle where the weight begins, rad.
    model
        Geometry.
    fades_rad
        Positive; b, by which the wheel turns in one time constant; short against a turn.
    """
    low, high = _opening_ends(wheel_angle_rad, model)
    edges = np.array(model.cutout_edges_rad)
    arcs = _fading_arcs(high.ravel(), edges, fades_rad) - _fading_arcs(low.ravel(), edges, fades_rad)
    return np.asarray((arcs / model.opening_angle_rad).reshape(low.shape))


@njit(cache=True, nogil=True)
def _fading_arcs(alpha: Array, edges: Array, fades: float) -> Any:
    """What `_open_arcs` averages, averaged with such a weight: at each whole turn ahead it bends by one; rad, shape (n,)."""
    out, scale = np.empty(alpha.size), 1 / (1 - np.exp(-TURN / fades))
    for k in range(alpha.size):
        arc, sign = alpha[k], -1.0
        for i in range(4):
            turns = (alpha[k] - edges[i]) * _PER_RAD
            whole = np.floor(turns)
            bends = scale * np.exp(-TURN * (whole + 1 - turns) / fades)
            arc += sign * (TURN * (whole * turns - whole * (whole + 1) / 2) + fades * (whole + bends))
            sign = -sign
        out[k] = arc
    return out


def edge_in_opening(wheel_angle_rad: Array, model: WheelModel, *, sweep_rad: float = 0.0) -> Array:
    """Share of the integration window during which each edge crosses the opening.

    Parameters
    ----------
    wheel_angle_rad, model, sweep_rad
        As for :func:`exposed_fraction`; wheel_angle_rad of shape (n,).

    Returns
    -------
    Shape (4, n), within [0, 1]. The exposed fraction changes by EDGE_SIGNS[i] / gamma times this per rad by which
    edge i comes earlier, that is for a smaller alpha_i.
    """
    low, high = _opening_ends(wheel_angle_rad, model)
    edges = np.array(model.cutout_edges_rad)
    return np.asarray(_all_passed(high, edges, sweep_rad) - _all_passed(low, edges, sweep_rad))


@njit(cache=True, nogil=True)
def _all_passed(alpha: Array, edges: Array, sweep: float) -> Any:
    """How often each edge has passed, averaged over the sweep, shape (4, n)."""
    out = np.empty((4, alpha.size))
    for k in range(alpha.size):
        for i in range(4):
            out[i, k] = _passing(alpha[k], edges[i], sweep)[0]
    return out


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PointAverage:
    """Single points of the opening while the wheel sweeps past them; any shape, that of the points; ``passed`` (4, ...).

    ``arc_rad`` is the open arc up to the point, averaged over the window; ``ends_rad`` the same averaged over the window's two
    ends only; ``blade_arc_rad`` and ``blade_ends_rad`` the like of the arc that the second blade, between edges 2 and 3, covers;
    ``passed`` how often each edge has passed, averaged over the window. All up to constants of the wheel.
    """

    arc_rad: Array
    ends_rad: Array
    blade_arc_rad: Array
    blade_ends_rad: Array
    passed: Array

    @property
    def openness(self) -> Array:
        """How open the point is on average, within [0, 1]."""
        return np.asarray(1 + sum(s * n for s, n in zip(EDGE_SIGNS, self.passed, strict=True)))

    @property
    def behind_second_blade(self) -> Array:
        """How far the second blade covers the point on average, within [0, 1]."""
        return np.asarray(self.passed[2] - self.passed[3])


def at_point(coordinate_rad: Array, edges: EdgeAngles, *, sweep_rad: float) -> PointAverage:
    """What the sums over any opening are made of: two points are the ends of an arc of the opening.

    Parameters
    ----------
    coordinate_rad
        Wheel coordinates alpha of the points at the *start* of the window, any shape, within some turns of 0, rad.
    edges
        alpha_0 .. alpha_3.
    sweep_rad
        Positive; angle by which the wheel turns during the window, rad.

    Notes
    -----
    Between two points, ``arc_rad`` grows by the open part of the arc. Its derivative to the place of the point is the openness;
    to the angle by which edge i comes earlier, EDGE_SIGNS[i] times ``passed[i]``; to the sweep, with the window's middle kept,
    ``ends_rad`` less ``arc_rad`` over the sweep.
    """
    points = np.ascontiguousarray(coordinate_rad, dtype=float)
    averages = _at_points(points.ravel(), np.array(edges), sweep_rad).reshape(8, *points.shape)
    arc, ends, blade_arc, blade_ends, *passed = averages
    return PointAverage(
        arc_rad=arc, ends_rad=ends, blade_arc_rad=blade_arc, blade_ends_rad=blade_ends, passed=np.array(passed)
    )


def summed_points(
    start_rad: Array, offsets_rad: Array, *, weight: Array, edges: EdgeAngles, sweep_rad: float
) -> PointAverage:
    """The same of many points that go round together, summed with weights; shapes (n,), and (4, n) of ``passed``.

    Parameters
    ----------
    start_rad
        Wheel coordinate of the place that they go round with at the start of each window, shape (n,).
    offsets_rad, weight
        By how much each point is ahead of it, and its weight, shapes (k,).
    edges, sweep_rad
        As of `at_point`.
    """
    order = np.argsort(offsets_rad)
    arc, ends, blade_arc, blade_ends, *passed = _summed_points(
        np.ascontiguousarray(start_rad), offsets_rad[order], weight[order], np.array(edges), sweep_rad
    )
    return PointAverage(
        arc_rad=arc, ends_rad=ends, blade_arc_rad=blade_arc, blade_ends_rad=blade_ends, passed=np.array(passed)
    )


@njit(cache=True, nogil=True)
def _at_points(start: Array, edges: Array, sweep: float) -> Any:
    """Open arc, its ends, arc of the second blade, its ends, and passages of the four edges, shape (8, n)."""
    out = np.empty((8, start.size))
    for k in range(start.size):
        arc, ends = start[k] + sweep / 2, 2 * start[k] + sweep
        blade_arc, blade_ends, sign = 0.0, 0.0, -1.0
        for i in range(4):
            passed, swept, both = _passing(start[k], edges[i], sweep)
            arc, ends = arc + sign * swept, ends + sign * both
            if i >= 2:
                blade_arc, blade_ends = blade_arc - sign * swept, blade_ends - sign * both
            out[4 + i, k] = passed
            sign = -sign
        out[0, k], out[1, k], out[2, k], out[3, k] = arc, ends / 2, blade_arc, blade_ends / 2
    return out


@njit(cache=True, nogil=True)
def _summed_points(start: Array, offset: Array, weight: Array, edges: Array, sweep: float) -> Any:
    """The same, summed over points in order (k,) with weights, shape (8, n).

    What an edge does to points that it does not pass during the window follows from the sums of their weights and moments.
    """
    n, out = offset.size, np.zeros((8, start.size))
    total, moment = np.zeros(n + 1), np.zeros(n + 1)  # of the points before each
    for j in range(n):
        total[j + 1], moment[j + 1] = total[j] + weight[j], moment[j] + weight[j] * offset[j]
    for k in range(start.size):
        out[0, k] = out[1, k] = total[n] * (start[k] + sweep / 2) + moment[n]
        for i in range(4):
            turn = np.floor((start[k] + offset[0] - edges[i]) * _PER_RAD)
            first, last = 0, n  # of those that it may pass
            if offset[n - 1] - offset[0] + sweep < TURN:
                ahead = (turn + 1) * TURN - (start[k] - edges[i])
                first, last = np.searchsorted(offset, ahead - sweep), np.searchsorted(offset, ahead)
            later, later_moment = total[n] - total[last], moment[n] - moment[last]
            middle = start[k] + sweep / 2 - edges[i]
            passed = turn * total[first] + (turn + 1) * later
            swept = turn * ((middle - TURN * (turn + 1) / 2) * total[first] + moment[first])
            swept += (turn + 1) * ((middle - TURN * (turn + 2) / 2) * later + later_moment)
            both = swept
            for j in range(first, last):
                one, of_one, of_ends = _passing(start[k] + offset[j], edges[i], sweep)
                passed += weight[j] * one
                swept += weight[j] * of_one
                both += weight[j] * of_ends / 2
            sign = 1.0 if i % 2 else -1.0
            out[0, k] += sign * swept
            out[1, k] += sign * both
            if i >= 2:
                out[2, k] -= sign * swept
                out[3, k] -= sign * both
            out[4 + i, k] = passed
    return out


def slope_centres_rad(model: WheelModel) -> Array:
    """Wheel angles at which edge 0..3 passes the middle of the opening, shape (4,), in [0, 2 pi).

    Slopes 0 and 2 fall, 1 and 3 rise with the wheel angle.
    """
    return np.mod(np.asarray(model.cutout_edges_rad) - model.opening_coordinate_rad, TURN)


def corner_angles_rad(model: WheelModel) -> Array:
    """Start and end of the slopes of edge 0..3, shape (4, 2), start in [0, 2 pi): the corners of figure 4(b)."""
    start = np.mod(slope_centres_rad(model) - model.opening_angle_rad / 2, TURN)
    return np.stack([start, start + model.opening_angle_rad], axis=1)
