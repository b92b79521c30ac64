"""The contrast image that a blurred sector would give, and what a measured one says of it.

Fourteen numbers are searched for: the ten of the sector's shape, the row delay in s, the phase of the image, and the radii in
px of the ring that the wheel's cutouts sweep. Others enter linearly and are solved for at each step: the contrast of the
opening; that of the mask plate beside it, seen where the wheel is cut out, for it need not be as warm as the wheel; and a
smooth field over the ring, since the solid wheel mirrors the camera unevenly.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
from scipy import ndimage
from scipy.special import ndtr

from irtiming.estimate.row_light import shape_of
from irtiming.physics import blurred_sector, smooth_field, wheel_harmonics
from irtiming.physics.response import first_order_lag
from irtiming.physics.response.first_order_lag import HARMONICS
from irtiming.physics.wheel import TURN
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Array, ComplexArray, Mask
from irtiming.records.reduced import ReducedRecording
from irtiming.records.wheel_geometry import WheelModel

SCALES = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.05, 0.05, 0.5, 0.02, 1e-5, 0.05, 2.0, 2.0])
BLUR, DISTORTION, ROW_DELAY, PHASE, RING_INNER, RING_OUTER = 8, 9, 10, 11, 12, 13
_TABLE = 8192
_CENTRE_STEPS = 9
_FIRST_BLUR_PX = 0.7
_CUTOUT_MARGIN_PX = 1.5


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class View:
    """Region of interest, good pixels and summed pixels in it, shape (roi rows, roi columns); mirrored or not.

    ``image`` is the number of rows and columns of the whole image, ``field_prior`` how high, roughly, the hills of the smooth
    field may be, as a share of the contrast.
    """

    roi: tuple[int, int, int, int]
    image: tuple[int, ...]
    good: Mask
    summed: Mask
    mirrored: bool
    field_prior: float

    @cached_property
    def field_terms(self) -> Array:
        """Hills over the region, of which a smooth field is made; shape (n, roi rows, roi columns)."""
        return smooth_field.hills(self.rows.ravel(), self.columns.ravel())

    @cached_property
    def stand_ins(self) -> list[tuple[int, int, list[int]]]:
        """Row and column of each dead pixel, and columns of the nearest good ones in its row: the row sums have their mean."""
        found = []
        for row, column in np.argwhere(~self.good).tolist():
            left, right = np.flatnonzero(self.good[row, :column]), np.flatnonzero(self.good[row, column + 1 :])
            found.append((row, column, [*left[-1:].tolist(), *(column + 1 + right[:1]).tolist()]))
        return found

    @property
    def rows(self) -> Array:
        """Image rows of the region, as a column."""
        return np.arange(self.roi[0], self.roi[1], dtype=float)[:, None]

    @property
    def columns(self) -> Array:
        """Image columns of the region, as a row."""
        return np.arange(self.roi[2], self.roi[3], dtype=float)[None, :]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Look:
    """Contrast images of one wheel speed, added up.

    ``table`` (8192,) is the projection of a point of light over its polar angle from the bisector, made with the weights of
    the recordings; ``omega`` the angular frequency, ``full_dn`` the projection of a pixel wholly in the light, roughly.
    ``own_phase`` tells that the image's phase is taken from itself: delay, lag and angle errors shift it at each speed by
    another angle, and the phase among the numbers is that of the first image.
    """

    projection: ComplexArray
    u_dn: float
    table: ComplexArray
    omega: float
    full_dn: float
    own_phase: bool = False

    def values(self, angle_rad: Array) -> ComplexArray:
        """The table at any angle, by linear interpolation; same shape."""
        place = np.mod(angle_rad, TURN) * (_TABLE / TURN)
        below = place.astype(np.int64)
        part = place - below
        return (1 - part) * self.table[below % _TABLE] + part * self.table[(below + 1) % _TABLE]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Fitted:
    """The model at some numbers.

    ``misfit`` (2 n_good + prior,) holds the deviations of the good pixels along and across their phase, and of the field from
    its prior, over their uncertainties; ``left_dn`` (roi rows, roi columns) those along the phase, measured minus model, DN.
    ``full_dn`` is a pixel wholly in the light, ``plate`` the plate's contrast as a share of it, ``field`` (roi rows, roi
    columns) the smooth one and ``unevenness`` its standard deviation over the ring.
    """

    misfit: Array
    left_dn: Array
    full_dn: float
    plate: float
    field: Array
    unevenness: float


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SeenContrast:
    """Contrast in the terms of the sector; arrays of shape (roi rows, roi columns).

    ``light`` is the sector's share in each pixel, ``ring`` that of the ring that the cutouts sweep, ``plate`` the plate's
    contrast as a share of the opening's, ``field`` the smooth one with ``unevenness`` as its standard deviation over the ring,
    ``residual`` what is left of the measured contrast beyond the model, with standard uncertainty ``u``; ``light_angle_rad`` is
    the mean polar angle of the sector's light in a pixel, ``centre_angle_rad`` that of its centre, both from the bisector.
    """

    light: Array
    ring: Array
    plate: float
    field: Array
    unevenness: float
    residual: Array
    u: float
    light_angle_rad: Array
    centre_angle_rad: Array

    @property
    def over_ring(self) -> Array:
        """What plate and field add wherever the cutouts pass."""
        return self.ring * (self.plate + self.field)

    @property
    def model(self) -> Array:
        """All but the residual: the sector's light is what the opening shows beyond the plate."""
        return (1 - self.plate) * self.light + self.over_ring


def looks(recordings: Sequence[ReducedRecording], wheel: WheelModel, *, lag: tuple[Array, float]) -> list[Look]:
    """Contrast images added up by wheel speed; ``lag`` holds edge delays (4,) and time constant, s."""
    found = list[Look]()
    for speed in sorted({round(one.track.angular_frequency_rad_per_s, 2) for one in recordings}):
        group = [one for one in recordings if round(one.track.angular_frequency_rad_per_s, 2) == speed]
        projection = np.sum([one.contrast_image.projection_dn for one in group], axis=0)
        found.append(
            Look(
                projection=projection,
                u_dn=float(np.sqrt(sum(one.contrast_image.u_dn**2 for one in group))),
                table=_point_table(group, wheel, lag),
                omega=float(np.mean([one.track.angular_frequency_rad_per_s for one in group])),
                full_dn=float(np.quantile(np.abs(projection), 0.9)),
                own_phase=bool(found),
            )
        )
    return found


def _point_table(recordings: list[ReducedRecording], wheel: WheelModel, lag: tuple[Array, float]) -> ComplexArray:
    """Projection of a point of light at each polar angle from the bisector, with the weights of the recordings."""
    delays, tau = lag
    order = np.arange(HARMONICS + 1)
    spectrum = np.zeros(_TABLE, complex)
    for one in recordings:
        omega = one.track.angular_frequency_rad_per_s
        by_edge = wheel_harmonics.open_harmonics(wheel, HARMONICS) * wheel_harmonics.later(
            omega * delays, n_harmonics=HARMONICS
        )
        point = by_edge.sum(axis=0) * first_order_lag.transfer(omega, tau, n_harmonics=HARMONICS)
        angle = wheel_angle_rad(one.trigger_delay_time_set_s, one.track, at_ticks=one.trigger_ticks)
        waves = np.exp(1j * np.multiply.outer(order, angle))
        np.add.at(spectrum, -order, point * (waves @ one.contrast_image.frame_weight) / 2)
        np.add.at(spectrum, order, point.conj() * (waves.conj() @ one.contrast_image.frame_weight) / 2)
    return np.fft.ifft(spectrum) * _TABLE


def fitted(look: Look, numbers: Array, *, view: View, u_along_dn: Array) -> Fitted:
    """Model for these numbers, shape (n_number,); what is linear is solved for by weighted least squares over the good pixels."""
    shape, row_turn = shape_of(numbers, view.mirrored, image=view.image), look.omega * numbers[ROW_DELAY]
    points = blurred_sector.border_points(shape)
    value = look.values(points.angle_rad - row_turn * points.row_px) * np.exp(-2j * row_turn * points.row_px)
    border = blurred_sector.image(points, value, blur_px=shape.blur_px, roi=view.roi) * np.exp(
        2j * row_turn * view.rows
    )
    angle, radius = blurred_sector.pixel_places(shape, roi=view.roi)
    point = look.values(angle - row_turn * view.rows)
    point *= blurred_sector.pixel_smear(radius, blur_px=shape.blur_px, order=2)
    sector = np.where(blurred_sector.well_inside(shape, roi=view.roi), point, border)
    size = np.abs(point)
    back = point.conj() / size
    ring = _ring(radius, numbers) * size
    lit = sector * back
    phase = np.angle(np.vdot(sector[view.good], look.projection[view.good])) if look.own_phase else numbers[PHASE]
    seen = look.projection * back * np.exp(-1j * phase)
    along, across = 1 / u_along_dn[view.good], 1 / look.u_dn
    two = np.stack([lit, ring - lit])[:, view.good]
    levels = np.concatenate([two.real * along, two.imag * across], axis=1)
    terms = _about_their_mean(view.field_terms, lit.real)
    hills = (terms * ring)[:, view.good] * along  # they lie along the phase
    target = np.concatenate([seen[view.good].real * along, seen[view.good].imag * across])
    n_good, scale = along.size, float(levels[0] @ target) / float(levels[0] @ levels[0])
    prior = 1 / (view.field_prior * abs(scale))
    mixed = levels[:, :n_good] @ hills.T
    normal = np.block([[levels @ levels.T, mixed], [mixed.T, hills @ hills.T + prior**2 * np.eye(len(hills))]])
    found = np.linalg.solve(normal, np.concatenate([levels @ target, hills @ target[:n_good]]))
    misfit = found[:2] @ levels - target
    misfit[:n_good] += found[2:] @ hills
    model = np.einsum("k,kij->ij", found[2:], terms)
    left = seen.real - (found[0] * lit + found[1] * (ring - lit)).real - model * ring
    return Fitted(
        misfit=np.concatenate([misfit, prior * found[2:]]),
        left_dn=left / size,
        full_dn=float(found[0]),
        plate=float(found[1] / found[0]),
        field=model / found[0],
        unevenness=_unevenness(model / found[0], ring * view.good),
    )


def _about_their_mean(terms: Array, light: Array) -> Array:
    """Terms less their mean over the light: a field that is even is the contrast, which lies where the sector's light does."""
    mean = terms.reshape(len(terms), -1) @ light.ravel() / light.sum()
    return np.asarray(terms - mean[:, None, None])


def _unevenness(field: Array, ring: Array) -> float:
    """Standard deviation of the field over the ring's good pixels."""
    mean = float(np.average(field, weights=ring))
    return float(np.sqrt(np.average((field - mean) ** 2, weights=ring)))


def _ring(radius: Array, numbers: Array) -> Array:
    width = float(np.hypot(numbers[BLUR], np.sqrt(1 / 12)))
    return np.asarray(ndtr((radius - numbers[RING_INNER]) / width) * ndtr((numbers[RING_OUTER] - radius) / width))


def contrast(seen: list[Look], numbers: Array, *, view: View, u_along_dn: list[Array]) -> SeenContrast:
    """What the images say of each pixel beyond the model with these numbers, shape (n_number,)."""
    shape = shape_of(numbers, view.mirrored, image=view.image)
    points = blurred_sector.light_points(shape)
    light = blurred_sector.image(points, np.ones(points.row_px.size, complex), blur_px=shape.blur_px, roi=view.roi).real
    moment = blurred_sector.image(points, points.angle_rad.astype(complex), blur_px=shape.blur_px, roi=view.roi).real
    centre, radius = blurred_sector.pixel_places(shape, roi=view.roi)
    models = [fitted(look, numbers, view=view, u_along_dn=u) for look, u in zip(seen, u_along_dn, strict=True)]
    weights = np.array([
        (model.full_dn * np.abs(look.table).mean() / look.u_dn) ** 2 for model, look in zip(models, seen, strict=True)
    ])  # fmt: skip
    share = weights / weights.sum()
    left = sum(w * model.left_dn / model.full_dn for w, model in zip(share, models, strict=True))
    return SeenContrast(
        light=np.asarray(light),
        ring=_ring(radius, numbers),
        plate=float(share @ [model.plate for model in models]),
        field=np.sum([w * model.field for w, model in zip(share, models, strict=True)], axis=0),
        unevenness=float(share @ [model.unevenness for model in models]),
        residual=_stood_in(np.asarray(left), view),
        u=float(1 / np.sqrt(weights.sum())),
        light_angle_rad=np.asarray(np.where(light > 1e-3, moment / np.maximum(light, 1e-3), centre), dtype=float),
        centre_angle_rad=centre,
    )


def _stood_in(value: Array, view: View) -> Array:
    """A dead pixel has the mean of its stand-ins."""
    out = value.copy()
    for row, column, beside in view.stand_ins:
        out[row, column] = value[row, beside].mean() if beside else 0.0
    return out


def first_guess(look: Look, view: View) -> Array:
    """Numbers of the sector, shape (n_number,), about the centre that makes the phases twice the polar angles.

    It is as large as the pixels of more than half contrast.
    """
    size = ndimage.median_filter(np.where(view.good, np.abs(look.projection), 0.0), 3)
    mask = (size > 0.5 * np.quantile(size, 0.9)) & view.summed & view.good
    row, column = (np.broadcast_to(place, mask.shape)[mask] for place in (view.rows, view.columns))
    sense = -1.0 if view.mirrored else 1.0
    centre = _phase_centre(row, sense * column, -np.angle(look.projection[mask]))
    down, across = row - centre[0], sense * column - centre[1]
    middle = float(np.arctan2(down.mean(), across.mean()))
    radius = np.hypot(down, across)
    inner, outer = (float(r) for r in np.quantile(radius, [0.005, 0.995]))
    angle = min(2 * mask.sum() / max(outer**2 - inner**2, 1.0), 3.0)
    down, across = down / radius, across / radius
    turned = look.projection[mask] * look.values(np.arctan2(down, across) - middle).conj()
    ring = (max(0.0, inner - _CUTOUT_MARGIN_PX), outer + _CUTOUT_MARGIN_PX)
    phase = float(np.angle(np.sum(turned)))
    return np.array([
        centre[0], sense * centre[1], 0, 0, inner, outer, middle, angle, _FIRST_BLUR_PX, 0.0, 0.0, phase, *ring
    ])  # fmt: skip


def _phase_centre(row: Array, column: Array, phase: Array) -> Array:
    """Row and column of the point about which the phases are twice the polar angles, searched finer and finer."""
    centre, reach = np.array([row.mean(), column.mean()]), float(np.ptp(row) + np.ptp(column))
    while reach > 0.1:
        steps = np.linspace(-reach, reach, _CENTRE_STEPS)
        trials = [centre + np.array([a, b]) for a in steps for b in steps]
        match = [abs(np.mean(np.exp(1j * (phase - 2 * np.arctan2(row - r, column - c))))) for r, c in trials]
        centre, reach = trials[int(np.argmax(match))], reach * 0.4
    return centre
