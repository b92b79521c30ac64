r"""The pixel sums of one recording as the wheel makes them, with analytic derivatives: what single and joint fits share.

Frame n, whose integration window has its middle ``delay`` after trigger and set delay, at the wheel angle theta_n, has the sum

    covered + step (F(theta_n) + drift t_n + skew S(theta_n) + plate P(theta_n))

F is the exposed fraction averaged over the window (eq. 1), of a wheel whose edge i comes ``edge_i`` earlier than drawn. S is
the trace of an opening that is brighter towards one end, P that of a mask plate as warm as neither wheel nor blackbody: an
opening that is wider by the summed border. Blur moves light but keeps its sum, so it has no place here.

The window rounds the corners of F over the angle omega window. A radial edge of the mask that misses the axle rounds its
corners too, over an angle that does not depend on the wheel's speed: at the radius r it stands ``lean`` (r_0 / r - mean) beside
its mean angle. F is the mean over some radii, each with its area.
"""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.physics.wheel import EDGE_SIGNS, TURN, PointAverage, at_point, exposed_fraction, skewed_fraction
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Array, Mask
from irtiming.records.reduced import ReducedRecording
from irtiming.records.wheel_geometry import WheelModel

NAMES = (
    "delay", "covered", "step", "drift", "skew", "plate", "edge_0", "edge_1", "edge_2", "edge_3", "opening_angle", "window",
    "lean_low", "lean_high",
)  # fmt: skip
"""What the model takes, in this order: s, DN, DN, 1, 1, 1, four times rad, rad, s, twice rad."""

DELAY, COVERED, STEP, DRIFT, SKEW, PLATE, EDGES, OPENING, WINDOW, LEANS = (
    0,
    1,
    2,
    3,
    4,
    5,
    slice(6, 10),
    10,
    11,
    slice(12, 14),
)
_NARROWEST_RAD = 1e-3
_SHORTEST_RAD = 1e-5  # sweep below which the window counts as so long
_BORDER_RAD = 0.1  # where the axle was not found in the image
_RADII = 4  # Gauss-Legendre nodes over the opening's radii
_DIFFERENCE_RAD = 1e-5
_UNSEEN_LEAN_RAD = 0.01
_EXTENT = (0.02, 0.98)  # of the pixels' radii


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PixelSums:
    """One recording before its model.

    ``kept`` (n_frame,) are the frames that count, ``time`` (n_frame,) their triggers over the length of the recording, about 0.
    ``unit_dn`` is a first guess of the step, by which residuals are divided: a fitted one would let them vanish by growing.
    ``ring_share``, ``ring_place`` (k,) are areas and places r_0 / r - mean of the radii over which F is averaged.
    """

    reduced: ReducedRecording
    wheel: WheelModel
    kept: Mask
    time: Array
    unit_dn: float
    border_rad: float
    ring_share: Array
    ring_place: Array

    @property
    def angular_frequency_rad_per_s(self) -> float:
        """Of the wheel."""
        return self.reduced.track.angular_frequency_rad_per_s

    @property
    def sums_dn(self) -> Array:
        """Pixel sums of the kept frames."""
        return self.reduced.pixel_sums.pixel_sum[self.kept]

    def angle(self, delay_s: float) -> Array:
        """Wheel angle of the kept frames this long after the trigger and the delay set, rad."""
        delay = delay_s + self.reduced.trigger_delay_time_set_s
        return wheel_angle_rad(delay, self.reduced.track, at_ticks=self.reduced.trigger_ticks[self.kept])


def pixel_sums(reduced: ReducedRecording, wheel: WheelModel) -> tuple[PixelSums, float]:
    """The recording with all its frames, and a first guess of its sum when covered, DN."""
    low, high = (float(v) for v in np.quantile(reduced.pixel_sums.pixel_sum, [0.03, 0.97]))
    hot = not reduced.opening.blackbody_is_colder
    ticks, (share, place) = reduced.trigger_ticks, _rings(reduced)
    told = PixelSums(
        reduced=reduced,
        wheel=wheel,
        kept=np.ones(ticks.size, bool),
        time=(ticks - ticks.mean()) / max(1.0, float(np.ptp(ticks))),
        unit_dn=high - low if hot else low - high,
        border_rad=_border(reduced),
        ring_share=share,
        ring_place=place,
    )
    return told, low if hot else high


def at_one_radius(told: PixelSums) -> PixelSums:
    """The same for mask edges that point to the axle: all radii are alike."""
    return replace(told, ring_share=np.ones(1), ring_place=np.zeros(1))


def residual(values: Array, told: PixelSums) -> Array:
    """Sums less model, in units of the guessed step, shape (n_kept,); values in the order of NAMES."""
    shape = expected_fraction(values, told)
    return (
        told.sums_dn - values[COVERED] - values[STEP] * (shape + values[DRIFT] * told.time[told.kept])
    ) / told.unit_dn


def at_best_levels(values: Array, told: PixelSums) -> Array:
    """The values with covered level, step, drift, skew and plate at their best for the others, which is a linear problem."""
    passing = _passing(values, told)
    fraction = _fraction(_rings_of(values[LEANS], told, passing), passing)
    columns = np.stack([np.ones(fraction.size), fraction, told.time[told.kept], *_small_parts(passing, told)], axis=1)
    scale = np.linalg.norm(columns, axis=0)
    found = np.linalg.lstsq(columns / scale, told.sums_dn / told.unit_dn, rcond=1e-12)[0] / scale
    out = values.copy()
    out[[COVERED, STEP]] = found[:2] * told.unit_dn
    out[[DRIFT, SKEW, PLATE]] = found[2:] / found[1]
    return out


def expected_fraction(values: Array, told: PixelSums) -> Array:
    """The model without drift, from covered 0 to open 1, shape (n_kept,)."""
    passing = _passing(values, told)
    fraction = _fraction(_rings_of(values[LEANS], told, passing), passing)
    skewed, plate = _small_parts(passing, told)
    return np.asarray(fraction + values[SKEW] * skewed + values[PLATE] * plate)


def slopes(values: Array, told: PixelSums) -> Array:
    """Derivatives of the model over the guessed step, shape (n_kept, 14)."""
    passing = _passing(values, told)
    rings = _rings_of(values[LEANS], told, passing)
    skewed, plate = _small_parts(passing, told)
    by_eight = _fraction_slopes(rings, passing)
    by_eight[:6] += values[PLATE] * _plate_slopes(passing, told) + values[SKEW] * _skew_slopes(passing)
    shape = _fraction(rings, passing) + values[SKEW] * skewed + values[PLATE] * plate
    time, omega, step = told.time[told.kept], told.angular_frequency_rad_per_s, values[STEP]
    columns = [
        step * omega * by_eight[:4].sum(axis=0),
        np.ones(time.size),
        shape + values[DRIFT] * time,
        step * time,
        step * skewed,
        step * plate,
        *(step * by_eight[:5]),
        step * omega * by_eight[5],
        *(step * by_eight[6:]),
    ]
    return np.stack(columns, axis=1) / told.unit_dn


@dataclass(frozen=True, kw_only=True, eq=False)
class _Passing:
    """Wheel with its edges and opening as given, wheel angle at the start of the window (n,), and sweep."""

    wheel: WheelModel
    start_rad: Array
    sweep_rad: float


def _passing(values: Array, told: PixelSums) -> _Passing:
    edges = tuple(float(e - d) for e, d in zip(told.wheel.cutout_edges_rad, values[EDGES], strict=True))
    wheel = replace(
        told.wheel,
        cutout_edges_rad=(edges[0], edges[1], edges[2], edges[3]),
        opening_angle_rad=max(float(values[OPENING]), _NARROWEST_RAD),
    )
    sweep = max(_SHORTEST_RAD, told.angular_frequency_rad_per_s * abs(float(values[WINDOW])))
    return _Passing(wheel=wheel, start_rad=told.angle(float(values[DELAY])) - sweep / 2, sweep_rad=sweep)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Ring:
    """The opening at one radius: its share of the area, place r_0 / r - mean, low and high end."""

    share: float
    place: float
    low: PointAverage
    high: PointAverage


def _rings_of(leans_rad: Array, told: PixelSums, passing: _Passing) -> list[_Ring]:
    wheel, sweep = passing.wheel, passing.sweep_rad
    centre = np.mod(wheel.opening_coordinate_rad + passing.start_rad, TURN)
    half, edges = wheel.opening_angle_rad / 2, wheel.cutout_edges_rad
    return [
        _Ring(
            share=float(share),
            place=float(place),
            low=at_point(centre - half + leans_rad[0] * place, edges, sweep_rad=sweep),
            high=at_point(centre + half + leans_rad[1] * place, edges, sweep_rad=sweep),
        )
        for share, place in zip(told.ring_share, told.ring_place, strict=True)
    ]


def _fraction(rings: list[_Ring], passing: _Passing) -> Array:
    arcs = sum(ring.share * (ring.high.arc_rad - ring.low.arc_rad) for ring in rings)
    return np.asarray(arcs / passing.wheel.opening_angle_rad)


def _fraction_slopes(rings: list[_Ring], passing: _Passing) -> Array:
    """Derivatives of F to the angles by which edges come earlier, opening angle, sweep and both leans, shape (8, n), per rad."""
    gamma, fraction = passing.wheel.opening_angle_rad, _fraction(rings, passing)
    out = np.zeros((8, fraction.size))
    for ring in rings:
        low_open, high_open = ring.low.openness, ring.high.openness
        out[:4] += ring.share * np.array(EDGE_SIGNS)[:, None] * (ring.high.passed - ring.low.passed)
        out[4] += ring.share * (low_open + high_open) / 2
        out[5] += ring.share * (ring.high.ends_rad - ring.low.ends_rad)
        out[6] -= ring.share * ring.place * low_open
        out[7] += ring.share * ring.place * high_open
    out /= gamma
    out[4] -= fraction / gamma
    out[5] = (out[5] - fraction) / passing.sweep_rad
    return out


def _small_parts(passing: _Passing, told: PixelSums) -> tuple[Array, Array]:
    """S and P."""
    narrow, wide = (
        exposed_fraction(passing.start_rad, one, sweep_rad=passing.sweep_rad) for one in _widths(passing, told)
    )
    return skewed_fraction(passing.start_rad, passing.wheel, sweep_rad=passing.sweep_rad), wide - narrow


def _widths(passing: _Passing, told: PixelSums) -> tuple[WheelModel, WheelModel]:
    """The opening, and the wider one through which the mask plate shows."""
    gamma = passing.wheel.opening_angle_rad
    return passing.wheel, replace(passing.wheel, opening_angle_rad=gamma + 2 * told.border_rad)


def _plate_slopes(passing: _Passing, told: PixelSums) -> Array:
    """Derivatives of P to the edges, opening angle and sweep, shape (6, n), per rad."""
    even, pair = at_one_radius(told), []
    for wheel in _widths(passing, told):
        one = replace(passing, wheel=wheel)
        pair.append(_fraction_slopes(_rings_of(np.zeros(2), even, one), one)[:6])
    return np.asarray(pair[1] - pair[0])


def _skew_slopes(passing: _Passing) -> Array:
    """The same of S: to opening angle and sweep by differences, since both are small; to the edges 0, being smaller yet."""
    start, wheel, sweep, h = passing.start_rad, passing.wheel, passing.sweep_rad, _DIFFERENCE_RAD
    out = np.zeros((6, start.size))
    by_gamma = [
        skewed_fraction(start, replace(wheel, opening_angle_rad=wheel.opening_angle_rad + k * h), sweep_rad=sweep)
        for k in (1, -1)
    ]
    out[4] = (by_gamma[0] - by_gamma[1]) / (2 * h)
    if sweep > 2 * h:
        by_sweep = [skewed_fraction(start - k * h / 2, wheel, sweep_rad=sweep + k * h) for k in (1, -1)]
        out[5] = (by_sweep[0] - by_sweep[1]) / (2 * h)
    return out


def _radii_px(reduced: ReducedRecording) -> Array | None:
    """Distance of the opening's pixels from the axle, shape (n,); None where the axle was not found."""
    if reduced.axle is None:
        return None
    rows, columns = np.nonzero(reduced.opening.mask)
    return np.hypot(rows - reduced.axle.row_px, columns - reduced.axle.column_px)


def _border(reduced: ReducedRecording) -> float:
    """Angle about the axle of the border by which the summed region exceeds the opening, rad."""
    radii = _radii_px(reduced)
    return _BORDER_RAD if radii is None else float(np.clip(reduced.opening.border_px / radii.mean(), 1e-2, 0.3))


def leans_in_image(reduced: ReducedRecording, *, turns_clockwise: bool) -> tuple[Array, float]:
    """Angles by which the ends of the opening lean, low and high wheel coordinate, as the image shows them; and their u, rad.

    Zero, with a wide uncertainty, where the image does not tell.
    """
    radii, axle = _radii_px(reduced), reduced.axle
    if radii is None or axle is None or axle.edge_miss_px is None:
        return np.zeros(2), _UNSEEN_LEAN_RAD
    inner, outer = np.quantile(radii, _EXTENT)
    miss = np.array(axle.edge_miss_px)  # wheel coordinates grow against polar angles, unless the wheel is mirrored
    leans = -miss[::-1] if turns_clockwise else miss
    return 2 * leans / (inner + outer), 2 * axle.u_edge_miss_px / (inner + outer)


def _rings(reduced: ReducedRecording) -> tuple[Array, Array]:
    """Shares of area and places of the radii."""
    radii = _radii_px(reduced)
    if radii is None:
        return np.ones(1), np.zeros(1)
    inner, outer = np.quantile(radii, _EXTENT)
    node, weight = np.polynomial.legendre.leggauss(_RADII)
    radius = (inner + outer) / 2 + (outer - inner) / 2 * node
    share = weight * radius / np.sum(weight * radius)
    place = (outer + inner) / 2 / radius
    return share, place - float(share @ place)
