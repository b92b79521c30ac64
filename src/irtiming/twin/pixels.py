"""Light on each pixel while the wheel turns: rays that get past the wheel are counted, instant by instant."""

import math
from dataclasses import dataclass
from typing import TypeAlias, final

import numpy as np
import numpy.typing as npt
from numba import njit

from irtiming.records.arrays import Array
from irtiming.twin.glare import Veil, veil_of
from irtiming.twin.kernels import wrapped
from irtiming.twin.noise import Values
from irtiming.twin.rays import Counts, Indices, RayTable, trace
from irtiming.twin.scene import Scene
from irtiming.twin.spread import Offsets

Weights: TypeAlias = npt.NDArray[np.float32]
"""DN that a pixel gains when all its rays get past the wheel; shape (n_live,)."""

_GROUP = 16
_CLOSED, _OPEN, _TOUCHED = 0, 1, 2


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Picture:
    """A scene ready to be exposed at any wheel angle.

    ``closed_dn`` (row, column) is the signal behind solid wheel; ``opening_dn`` and ``plate_dn`` (n_live,)
    are what a pixel of the table gains where it sees the blackbody or the mask plate instead. ``open_rad``
    (3, 2) are the intervals of phi_A + theta - phi in [0, 2 pi) at which a cutout lies over phi. ``span_rad`` (n_live, 2)
    are the smallest and largest offset of a pixel's rays, ``group_span_rad`` (n_group, 2) those of the rays of each
    16 pixels in a row of the table, from the angle of the first of them. ``blade_rad`` (2, 2) are the intervals at which the
    blade between edges 2 and 3 lies over phi, which is ``blade_dn`` warmer; ``veil``, where light goes astray.
    """

    table: RayTable
    closed_dn: Values
    opening_dn: Weights
    plate_dn: Weights
    open_rad: Array
    gate_rad: float
    span_rad: Offsets
    group_span_rad: Array
    blade_rad: Array
    blade_dn: float = 0.0
    veil: Veil | None = None


def picture(scene: Scene) -> Picture:
    """Trace the scene's rays and give everything in it its brightness."""
    table = trace(scene)
    closed = solid_wheel(scene)
    behind = closed.ravel()[table.pixel]
    radiance = scene.radiance
    edge = scene.wheel.cutout_edges_rad
    turn = 2 * math.pi
    opened = [(edge[3] - turn, edge[0]), (edge[1], edge[2]), (edge[3], edge[0] + turn)]
    span = _spans(table.offset_rad, table.n_opening, table.first_ray)
    return Picture(
        table=table,
        closed_dn=closed,
        opening_dn=np.float32(radiance.level_dn(radiance.blackbody_k)) - behind,
        plate_dn=np.float32(radiance.level_dn(radiance.mask_k)) - behind,
        open_rad=np.array(opened),
        gate_rad=math.pi / 2 + scene.beams.beta_1_rad,
        span_rad=span,
        group_span_rad=_group_spans(table.reference_rad, span),
        blade_rad=np.array([(edge[2] - turn, edge[3] - turn), (edge[2], edge[3])]),
        blade_dn=radiance.blade_dn,
        veil=veil_of(scene.optics, rows_columns=(scene.detector.rows, scene.detector.columns)),
    )


def solid_wheel(scene: Scene) -> Values:
    """Signal of the solid wheel, DN, shape (row, column): its radiation less the cold detector's mirror image in the middle."""
    rows, columns = scene.detector.rows, scene.detector.columns
    row = (np.arange(rows) - (rows - 1) / 2)[:, None]
    column = np.arange(columns) - (columns - 1) / 2
    away = np.hypot(row, column) * scene.optics.pixel_pitch_m / scene.radiance.narcissus_radius_m
    level = scene.radiance.level_dn(scene.radiance.wheel_k)
    return np.asarray(level - scene.radiance.narcissus_dn * np.exp(-0.5 * away**2), dtype=np.float32)


def expose(shot: Picture, wheel_angles_rad: Array, *, out: Values) -> None:
    """Signal of one frame, written into ``out``.

    Parameters
    ----------
    shot
        The scene.
    wheel_angles_rad
        Shape (n_instant,): wheel angle at equally spaced instants of the integration window, in order.
    out
        Shape (row, column), DN of a mean pixel.
    """
    out[...] = shot.closed_dn
    table = shot.table
    angles = np.asarray(wheel_angles_rad, dtype=np.float64)
    rays = (table.pixel, table.reference_rad, table.n_opening, table.first_ray, table.offset_rad)
    spans, share = (shot.span_rad, shot.group_span_rad), (1.0 / (table.n_ray * angles.size)).astype(np.float32)
    opened = (shot.opening_dn, shot.plate_dn, share)
    _add_open_rays(out.reshape(-1), (angles + shot.gate_rad, shot.open_rad), rays, spans, opened)
    if shot.blade_dn != 0:
        warmer = np.full_like(shot.opening_dn, shot.blade_dn)
        blade = (angles + shot.gate_rad, shot.blade_rad)
        _add_open_rays(out.reshape(-1), blade, rays, spans, (warmer, warmer, share))
    if shot.veil is not None:
        shot.veil.cover(out)


@njit(cache=True, nogil=True)
def _add_open_rays(
    flat: Weights,
    wheel: tuple[Array, Array],
    table: tuple[Indices, Array, Indices, Counts, Offsets],
    spans: tuple[Offsets, Array],
    gain: tuple[Weights, Weights, Weights],
) -> None:
    """Add to each live pixel what its rays past the wheel bring, averaged over the instants.

    Most groups of pixels see no edge: they gain all that is behind a cutout, or nothing.
    """
    angles, opened = wheel
    pixel, reference, n_opening, first_ray, offset = table
    opening_dn, plate_dn, share = gain
    middle, swing = 0.5 * (angles[0] + angles[-1]), 0.5 * (angles[-1] - angles[0])
    span, group_span = spans
    for group in range(group_span.shape[0]):
        begin, end = group * _GROUP, min((group + 1) * _GROUP, pixel.size)
        mean = _in_turn(middle - reference[begin])
        seen = _sight(opened, mean - group_span[group, 1], mean - group_span[group, 0], swing)
        if seen == _CLOSED:
            continue
        for live in range(begin, end):
            first, last = first_ray[live], first_ray[live + 1]
            second = first + n_opening[live]
            alone = seen
            if seen == _TOUCHED:
                mean = _in_turn(middle - reference[live])
                alone = _sight(opened, mean - span[live, 1], mean - span[live, 0], swing)
            if alone == _CLOSED:
                continue
            if alone == _OPEN:
                past_opening, past_plate = angles.size * (second - first), angles.size * (last - second)
            else:
                past_opening = _count_open(offset[first:second], opened, angles, reference[live])
                past_plate = _count_open(offset[second:last], opened, angles, reference[live])
            flat[pixel[live]] += share[live] * (past_opening * opening_dn[live] + past_plate * plate_dn[live])


@njit(cache=True, nogil=True)
def _in_turn(angle: float) -> float:
    """The same angle in [0, 2 pi)."""
    turns = angle / (2 * math.pi)
    return (turns - math.floor(turns)) * 2 * math.pi


@njit(cache=True, nogil=True)
def _sight(opened: Array, low: float, high: float, swing: float) -> int:
    """What rays between two values of phi_A + theta - phi see while the wheel swings: cutout, wheel, or perhaps an edge."""
    if not _untouched(opened, low - swing, high + swing):
        return _TOUCHED
    return _OPEN if _is_open(opened, 0.5 * (low + high)) else _CLOSED


@njit(cache=True, nogil=True)
def _group_spans(reference: Array, span: Offsets) -> Array:
    """Smallest and largest angle of the rays of each group, from the reference angle of its first pixel."""
    spans = np.empty((-(-reference.size // _GROUP), 2))
    for group in range(spans.shape[0]):
        low, high = math.inf, -math.inf
        for live in range(group * _GROUP, min((group + 1) * _GROUP, reference.size)):
            away = wrapped(reference[live] - reference[group * _GROUP])
            low, high = min(low, away + span[live, 0]), max(high, away + span[live, 1])
        spans[group, 0], spans[group, 1] = low, high
    return spans


@njit(cache=True, nogil=True)
def _spans(offset: Offsets, n_opening: Indices, first_ray: Counts) -> Offsets:
    """Smallest and largest offset of each pixel's rays: beside each other, so that most frames need no others."""
    spans = np.empty((n_opening.size, 2), np.float32)
    for live in range(n_opening.size):
        first, end = first_ray[live], first_ray[live + 1]
        second = first + n_opening[live]
        low, high = math.inf, -math.inf
        if second > first:
            low, high = offset[first], offset[second - 1]
        if end > second:
            low, high = min(low, offset[second]), max(high, offset[end - 1])
        spans[live, 0], spans[live, 1] = low, high
    return spans


@njit(cache=True, nogil=True)
def _untouched(opened: Array, low: float, high: float) -> bool:
    """Whether no edge passes any ray of a pixel; a span too wide to be sure counts as touched."""
    if high - low > 1.0:
        return False
    for interval in range(opened.shape[0]):
        if low <= opened[interval, 0] <= high or low <= opened[interval, 1] <= high:
            return False
    return True


@njit(cache=True, nogil=True)
def _is_open(opened: Array, seen: float) -> bool:
    """Whether a cutout lies over a point that has this phi_A + theta - phi."""
    inside = False
    for interval in range(opened.shape[0]):
        inside = inside or opened[interval, 0] <= seen < opened[interval, 1]
    return inside


@njit(cache=True, nogil=True)
def _count_open(offset: Offsets, opened: Array, angles: Array, reference: float) -> int:
    """Rays, given in order of angle, that lie within a cutout; summed over the instants."""
    turn = 2 * math.pi
    first = _in_turn(angles[0] - reference)
    laps = int((first + abs(angles[-1] - angles[0])) / turn)
    count = 0
    for lap in range(-1, laps + 2):
        ahead = first - angles[0] - lap * turn
        for cutout in range(1, opened.shape[0]):  # the first is the last, a lap before
            count += _count_passed(offset, angles, ahead - opened[cutout, 0])
            count -= _count_passed(offset, angles, ahead - opened[cutout, 1])
    return count


@njit(cache=True, nogil=True)
def _count_passed(offset: Offsets, angles: Array, ahead: float) -> int:
    """How many sorted values are at most an instant's angle and what is ahead of it; summed over the instants."""
    if offset.size == 0:
        return 0
    if max(angles[0], angles[-1]) + ahead < offset[0]:
        return 0
    if min(angles[0], angles[-1]) + ahead >= offset[-1]:
        return offset.size * angles.size
    width = offset[-1] - offset[0]
    passed = (angles[0] + ahead - offset[0]) / width if width > 0 else 0.0
    count, at = 0, int(offset.size * min(max(passed, 0.0), 1.0))  # where it would be if the rays were even
    for angle in angles:  # from one instant to the next an edge passes few rays
        while at < offset.size and offset[at] <= angle + ahead:
            at += 1
        while at > 0 and offset[at - 1] > angle + ahead:
            at -= 1
        count += at
    return count
