"""The contrast image that a blurred sector would give, and what a measured one says of it.

The numbers that are searched for go by name: those of the sector's shape, the row delay, the phase of the image, the radii of the
ring that the wheel's cutouts sweep, and how much of the wheel's reflection the mask plate shows too. Others enter linearly and
are solved for at each step: the contrast of the opening; that of the mask plate beside it, seen where the wheel is cut out, for
it need not be as warm as the wheel; and a smooth field over the ring, since the solid wheel reflects the camera unevenly.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar, final

import numpy as np

from irtiming.estimate import sector_linear
from irtiming.estimate.contrast_look import IMAGE_ORDER, Look
from irtiming.estimate.row_light import SHAPE_NUMBERS, shape_of
from irtiming.estimate.sector_linear import Linear, Solved
from irtiming.physics import blurred_ring, blurred_sector, sector_points
from irtiming.physics.blurred_ring import EvenLight, Ring
from irtiming.physics.sector_points import LightPoints
from irtiming.physics.smooth_field import SmoothField
from irtiming.records.arrays import Array, ComplexArray, Mask
from irtiming.records.row_timing import LensTerms, SectorShape

NUMBERS = (*SHAPE_NUMBERS, "row_delay_s", "turn_rad", "ring_inner_px", "ring_outer_px", "plate_reflection")
"""Names of all numbers that are searched for."""

HIGHEST_FIELD = 0.1
"""Of the smooth field, a share of the contrast."""

GLARE_PX = 6.0
"""Width of the glare, roughly, of which an image says nothing."""
_HEIGHTS = np.geomspace(1e-4 * HIGHEST_FIELD, HIGHEST_FIELD, 97)
_PLAIN = LensTerms()

_AnyArray = TypeVar("_AnyArray", Array, ComplexArray)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class View:
    """Region of interest, good pixels and summed pixels in it, shape (roi rows, roi columns); mirrored or not.

    ``image`` is the number of rows and columns of the whole image, ``field_prior`` how high, roughly, the basis functions of the
    smooth field may be, as a share of the contrast; ``lens_terms`` what a calibration says of the lens.
    """

    roi: tuple[int, int, int, int]
    image: tuple[int, ...]
    good: Mask
    summed: Mask
    mirrored: bool
    field_prior: float
    lens_terms: LensTerms = _PLAIN

    def shape(self, numbers: Mapping[str, float]) -> SectorShape:
        """Sector with these numbers, among others, in this view."""
        return shape_of(numbers, self.mirrored, image=self.image, lens_terms=self.lens_terms)

    @cached_property
    def field(self) -> SmoothField:
        """Over the region."""
        return SmoothField.over(self.rows.ravel(), self.columns.ravel())

    @cached_property
    def stand_ins(self) -> list[tuple[int, int, list[int]]]:
        """Row and column of each dead pixel in the sums, and columns of the nearest good ones in its row: their mean counts."""
        found = []
        for row, column in np.argwhere(self.summed & ~self.good).tolist():
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
class Fitted:
    """The model at some numbers.

    ``misfit`` (2 n_good + n_basis,) holds the deviations of the good pixels along and across their phase, and of the field from
    its prior, over their uncertainties; ``left_dn`` (roi rows, roi columns) those along the phase, measured minus model, DN.
    ``full_dn`` is a pixel wholly in the light, ``plate`` the plate's contrast as a share of it, ``field`` (roi rows, roi
    columns) the smooth one where the wheel turns, with its ``coverage``, and ``ring`` the share of each good pixel in the ring.
    ``solved`` is what was linear.
    """

    solved: Solved
    misfit: Array
    left_dn: Array
    full_dn: float
    plate: float
    field: Array
    coverage: Array
    ring: Array

    @property
    def unevenness(self) -> float:
        """Standard deviation of the field over the ring's good pixels."""
        mean = float(np.average(self.field, weights=self.ring))
        return float(np.sqrt(np.average((self.field - mean) ** 2, weights=self.ring)))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SeenContrast:
    """Contrast in the terms of the sector; arrays of shape (roi rows, roi columns).

    ``light`` is the sector's share in each pixel, ``sharp`` the same without glare, ``ring`` that of the ring that the cutouts
    sweep, ``plate`` the plate's contrast as a share of the opening's, ``field`` the smooth one as it shows, with ``unevenness``
    as its standard deviation, ``residual`` what is left of the measured contrast beyond the model, with standard uncertainty
    ``u``; ``light_angle_rad`` and ``ring_angle_rad`` are the mean polar angles of the sector's light in a pixel and of the
    ring's, ``centre_angle_rad`` that of even light, all from the bisector. ``fits`` are those of the images.
    """

    light: Array
    sharp: Array
    ring: Array
    ring_angle_rad: Array
    plate: float
    field: Array
    unevenness: float
    residual: Array
    u: float
    light_angle_rad: Array
    centre_angle_rad: Array
    fits: Sequence[Fitted]

    @cached_property
    def field_height(self) -> float:
        """Root mean square of the heights, shares of the contrast, over all that the images make likely; beforehand any is."""
        likely = np.sum([fit.solved.log_evidence(_HEIGHTS) for fit in self.fits], axis=0)
        weight = _HEIGHTS * np.exp(likely - likely.max())  # they are spaced by their logarithms
        return float(np.sqrt(weight @ _HEIGHTS**2 / weight.sum()))

    @property
    def over_ring(self) -> Array:
        """What plate and field add wherever the cutouts pass."""
        return self.ring * self.plate + self.field

    @property
    def model(self) -> Array:
        """All but the residual: the sector's light is what the opening shows beyond the plate."""
        return (1 - self.plate) * self.light + self.over_ring


APART = ("glare", "glare_px", "ring_inner_px", "ring_outer_px", "plate_reflection")
"""Numbers that leave the sharp image as it is."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Sharp:
    """What the sector shows with a contrast of 1 and no glare, as if read at once, and what a point in each pixel's place does.

    ``read`` (roi rows, 1) is what the row's own time of reading adds; the others have the shape of the region. ``angle_rad`` is
    the mean angle of even light as the wheel has it when it is read, ``even`` where that light lies.
    """

    sector: ComplexArray
    read: ComplexArray
    angle_rad: Array
    point: ComplexArray
    even: EvenLight


@dataclass(frozen=True, kw_only=True, eq=False)
class _Parts:
    """What the sector (complex) and the whole ring would show with a contrast of 1, turned back by each pixel's own phase.

    ``odd`` is what a warmer blade adds in odd orders, alike wherever the cutouts pass. ``covered`` is how much of each pixel
    lies in the ring; ``seen`` is what was measured, turned likewise; ``size`` what a point of light shows, DN over contrast;
    ``swayed`` what numbers that are not known of the camera's levels do, each by its standard uncertainty.
    """

    lit: ComplexArray
    ring: ComplexArray
    odd: ComplexArray
    covered: Array
    seen: ComplexArray
    size: Array
    swayed: tuple[ComplexArray, ...]


@np.errstate(invalid="ignore", divide="ignore")
def fitted(
    look: Look, numbers: Mapping[str, float], *, view: View, u_dn: ComplexArray, known: Sharp | None = None
) -> Fitted:
    """Model for these numbers; what is linear is solved for by weighted least squares over the good pixels.

    A sector without light in the image leaves no finite misfit, by which a search knows that its step was too long.

    ``u_dn``, shape (row, column) of the region, holds the standard uncertainties of each pixel along its phase, real, and
    across, imaginary; ``known`` the `sharp` image, made with numbers that differ only where they are `APART`.
    """
    parts = _parts(look, numbers, view, known=known)
    solved = sector_linear.solved(_linear(parts, numbers, view, u_dn=u_dn), parts.seen, field_prior=view.field_prior)
    found, field = solved.found, solved.linear.field(solved.found)
    return Fitted(
        solved=solved,
        misfit=solved.misfit,
        left_dn=-solved.off.real / parts.size,
        full_dn=float(found[0]),
        plate=float(found[1] / found[0]),
        field=field / found[0],
        coverage=_unmirrored(parts.covered, parts.lit.real / parts.size, numbers),
        ring=np.maximum(parts.ring.real * view.good, 0.0),
    )


def change(
    fit: Fitted, look: Look, *, numbers: Mapping[str, float], view: View, u_dn: ComplexArray, known: Sharp | None = None
) -> Array:
    """By how much the misfit of a fit differs at numbers nearby, to first order, shape as `Fitted` has it; see `fitted`."""
    parts = _parts(look, numbers, view, known=known)
    return fit.solved.change(_linear(parts, numbers, view, u_dn=u_dn), parts.seen)


def _linear(parts: _Parts, numbers: Mapping[str, float], view: View, *, u_dn: ComplexArray) -> Linear:
    return Linear(
        levels=np.array([parts.lit + parts.odd, parts.ring - parts.lit, *parts.swayed]),
        cover=_unmirrored(parts.ring, parts.lit, numbers),
        basis=view.field,
        good=view.good,
        u_dn=u_dn,
    )


def _unmirrored(ring: _AnyArray, lit: _AnyArray, numbers: Mapping[str, float]) -> _AnyArray:
    """How much of the wheel's reflection goes where the wheel is cut out: less of it before a plate that mirrors, too."""
    return ring - numbers["plate_reflection"] * (ring - lit)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Places:
    """Where a sector lies in the region, the same in the images of all wheel speeds; shapes (roi rows, roi columns).

    ``even`` is where the even light lies that pixels see; ``inside`` are pixels that the border's blur does not reach.
    """

    even: EvenLight
    inside: Mask


def _places(shape: SectorShape, view: View) -> _Places:
    return _Places(
        even=blurred_ring.even_light(shape, roi=view.roi), inside=blurred_sector.well_inside(shape, roi=view.roi)
    )


def sharp(looks: Sequence[Look], numbers: Mapping[str, float], *, view: View) -> list[Sharp]:
    """The sector without glare, and what a point in the place of each pixel shows, in each image."""
    shape = view.shape(numbers)
    points = sector_points.border_points(shape)
    borders = blurred_sector.images(points, _lit(points, looks, numbers), blur=shape.blur, roi=view.roi)
    return _sharp(looks, numbers, view, places=_places(shape, view), borders=borders)


def _lit(points: LightPoints, looks: Sequence[Look], numbers: Mapping[str, float]) -> ComplexArray:
    """What points of light show in each image, each as if read in the row in which it is seen, shape (n_look, n)."""
    values = []
    for look in looks:
        turn, row_turn = _turns(look, numbers)
        value = look.point.at_nodes(points.angle_rad - turn - row_turn * points.row_px, gap_rad=points.gap_rad)
        values.append(value * np.exp(-1j * IMAGE_ORDER * row_turn * points.row_px) if row_turn else value)
    return np.array(values)


def _turns(look: Look, numbers: Mapping[str, float]) -> tuple[float, float]:
    """By how much the wheel has turned when row 0 is read, and from row to row, rad."""
    return numbers[look.turn], look.omega * numbers["row_delay_s"]


def _sharp(
    looks: Sequence[Look], numbers: Mapping[str, float], view: View, *, places: _Places, borders: ComplexArray
) -> list[Sharp]:
    """See `sharp`; ``borders`` are the images of points of light, which count near the sector's border."""
    found = []
    for look, border in zip(looks, borders, strict=True):
        turn, row_turn = _turns(look, numbers)
        read = np.exp(1j * IMAGE_ORDER * row_turn * view.rows)
        angle = places.even.angle_rad - turn - row_turn * view.rows
        point = look.point.smeared(angle, width_rad=places.even.reach_rad)
        sector = np.where(places.inside, point / read, border)
        found.append(Sharp(sector=sector, read=read, angle_rad=angle, point=point, even=places.even))
    return found


def _parts(look: Look, numbers: Mapping[str, float], view: View, *, known: Sharp | None = None) -> _Parts:
    shape, made = view.shape(numbers), known or sharp([look], numbers, view=view)[0]
    sector = blurred_sector.with_glare(made.sector, shape) * made.read
    size = np.abs(made.point)
    back = made.point.conj() / size
    ring = blurred_ring.seen(shape, _arcs_px(numbers), even=made.even)
    return _Parts(
        lit=sector * back,
        ring=_shown(look, made, shape, ring=ring, roi=view.roi) * back,
        odd=_odd(look, made, shown=ring.whole) * back,
        covered=ring.whole,
        seen=look.projection * back,
        size=size,
        swayed=tuple(one * back for one in look.swayed),
    )


def met(look: Look, numbers: Mapping[str, float], *, view: View) -> dict[str, float]:
    """The numbers with the turn that this image has, as the mean phase of its light says.

    It goes with the delay that the image is taken to have been made with.
    """
    begin = {look.turn: 0.0, **numbers}
    parts = _parts(look, begin, view)
    beside = float(np.angle(np.vdot(parts.lit[view.good], parts.seen[view.good]))) / IMAGE_ORDER
    return {**begin, look.turn: begin[look.turn] + beside}


def _arcs_px(numbers: Mapping[str, float]) -> tuple[float, float]:
    """Radii of the arcs between which the cutouts sweep."""
    return numbers["ring_inner_px"], numbers["ring_outer_px"]


def _shown(look: Look, made: Sharp, shape: SectorShape, *, ring: Ring, roi: tuple[int, int, int, int]) -> ComplexArray:
    """What a ring of even light shows, of which what goes astray comes from farther round the axle."""
    stays = (ring.stays - 1j * IMAGE_ORDER * ring.moment_rad) * made.point
    if shape.glare == 0:
        return stays
    return stays + ring.astray * look.point.smeared(
        made.angle_rad, width_rad=blurred_sector.astray_reach(shape, roi=roi)
    )


def _odd(look: Look, made: Sharp, *, shown: Array) -> ComplexArray:
    """What a warmer blade takes, in odd orders, of so much of the ring."""
    if not look.odd.table.any():
        return np.zeros(shown.shape, complex)
    return np.asarray(shown * look.odd.smeared(made.angle_rad, width_rad=made.even.reach_rad))


def contrast(seen: list[Look], numbers: Mapping[str, float], *, view: View, u_dn: list[ComplexArray]) -> SeenContrast:
    """What the images say of each pixel beyond the model; ``u_dn`` as of `fitted`, one for each image, shape (row, column)."""
    shape = view.shape(numbers)
    points, places = sector_points.light_points(shape), _places(shape, view)
    values = np.concatenate([(1 + 1j * points.angle_rad)[None], _lit(points, seen, numbers)])
    without, *borders = blurred_sector.images(points, values, blur=shape.blur, roi=view.roi)
    both = blurred_sector.with_glare(without, shape)
    light, moment = both.real, both.imag
    unglared = _sharp(seen, numbers, view, places=places, borders=np.array(borders))
    models = [
        fitted(look, numbers, view=view, u_dn=u, known=known)
        for look, u, known in zip(seen, u_dn, unglared, strict=True)
    ]
    weights = np.array([
        (model.full_dn * np.abs(look.point.table).mean() / look.u_dn) ** 2 for model, look in zip(models, seen, strict=True)
    ])  # fmt: skip
    share = weights / weights.sum()
    ring = blurred_ring.seen(shape, _arcs_px(numbers), even=places.even)
    left = sum(w * model.left_dn / model.full_dn for w, model in zip(share, models, strict=True))
    return SeenContrast(
        light=np.asarray(light),
        sharp=np.asarray(without.real),
        ring=ring.whole,
        ring_angle_rad=places.even.angle_rad + ring.aside_rad,
        plate=float(share @ [model.plate for model in models]),
        field=np.sum([w * model.field * model.coverage for w, model in zip(share, models, strict=True)], axis=0),
        unevenness=float(share @ [model.unevenness for model in models]),
        residual=_stood_in(np.asarray(left), view),
        u=float(1 / np.sqrt(weights.sum())),
        light_angle_rad=np.asarray(
            np.where(light > 1e-3, moment / np.maximum(light, 1e-3), places.even.angle_rad), dtype=float
        ),
        centre_angle_rad=places.even.angle_rad,
        fits=models,
    )


def _stood_in(value: Array, view: View) -> Array:
    """A dead pixel has the mean of its stand-ins, and is as it should be where it has none."""
    out = np.where(view.good, value, 0.0)
    for row, column, beside in view.stand_ins:
        out[row, column] = value[row, beside].mean() if beside else 0.0
    return out
