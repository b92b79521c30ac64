r"""The sum over the mask opening as the wheel covers and uncovers it, averaged over the integration window (eq. 1, figure 4b).

.. math:: f = F + \mathrm{skew}\, S + \mathrm{plate}\, P + \mathrm{blades}\, B + \mathrm{beside}\, B'

F is the exposed fraction (`physics.wheel`), averaged over the window, of a wheel whose edge i comes ``edges_early_rad[i]``
earlier than drawn. S is the trace of an opening that is brighter towards one end, P that of a mask plate as warm as neither wheel
nor blackbody: what the summed border sees, less the opening. B is half the share that the second blade covers (edges 2 to 3) less
half of what the first does: the two are not equally warm. B' is the same for the summed border alone: the wheel turns before the
mask plate too. Blur moves light but keeps its sum, so it has no place here.

A lens with distortion, or a mask beside the axle, shows the opening brighter at both ends than in its middle: F grows by bow U,
the same in all recordings of one camera in one place.

A wheel that reflects the camera unevenly shows that wherever its cutouts pass. With R what of it the open part of the summed
pixels adds, as the image shows it, and r what all of it does, F grows by R - r F. So it does by pixels that stand in for dead
ones, less these, and by gains that differ.

Glare reaches farther than the pixels that are summed: from the opening's ends it takes more light out of the sum than from its
middle. With R what the open part loses, were all light astray, and r what the whole opening does, F is less by g (R - r F).

What comes after the window, a share s that fades with the time constant tau, sees the wheel further on. With the centre of all
that counts kept, F grows by s D, D = E - F - (T/2 + tau) omega dF/dtheta, where E is the exposed fraction averaged from the
window's end on with the fading weight.

The window rounds the corners of F over the angle that the wheel sweeps. A radial edge of the mask that misses the axle rounds its
corners too, over an angle that does not depend on the wheel's speed: at the radius r it stands ``lean`` (r_0 / r - mean) beside
its mean angle. F is the mean over some radii, each with its area. All derivatives are continuous.
"""

from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import final

import numpy as np

from irtiming.physics.light import summed_region
from irtiming.physics.light.bright_ends import BrightEnds, bright_ends
from irtiming.physics.light.summed_region import SeenRegion, SummedRegion
from irtiming.physics.wheel import (
    EDGE_SIGNS,
    TURN,
    PointAverage,
    at_point,
    edge_in_opening,
    exposed_fraction,
    fading_fraction,
)
from irtiming.records.arrays import Array, Ticks
from irtiming.records.wheel_geometry import WheelModel

SMALL = ("skew", "plate", "blades", "beside")
"""What the sum holds beside F, a little of each."""

_NARROWEST_RAD = 1e-3
_SHORTEST_RAD = 1e-5  # a window that sweeps less looks like one that sweeps this: no derivative of a sum has a step
_RADII = 4  # Gauss-Legendre nodes over the opening's radii
_OF_A_SPAN = 12.0  # its square over the variance of what lies evenly in it


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Radii:
    """Over which radii F is averaged: shares of the area and places r_0 / r - mean, shapes (k,)."""

    share: Array = field(default_factory=lambda: np.ones(1))
    place: Array = field(default_factory=lambda: np.zeros(1))


def radii(inner_px: float, outer_px: float) -> Radii:
    """Gauss-Legendre nodes between two radii."""
    node, weight = np.polynomial.legendre.leggauss(_RADII)
    radius = (inner_px + outer_px) / 2 + (outer_px - inner_px) / 2 * node
    share = weight * radius / np.sum(weight * radius)
    place = (outer_px + inner_px) / 2 / radius
    return Radii(share=share, place=place - float(share @ place))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Passing:
    """What passes the opening during the window, and the opening itself.

    Parameters
    ----------
    wheel
        As drawn; of its opening only the centre counts.
    middle_rad
        Shape (n,); wheel angle at the middle of the window.
    edges_early_rad
        Shape (4,); by how much edge 0..3 comes earlier than drawn.
    opening_angle_rad
        Of the mask.
    swept_rad
        Angle by which the wheel turns during the window; its sign does not matter.
    lean_low_rad, lean_high_rad
        By how much the radial mask edges at the low and the high wheel coordinate miss the axle, at the mean radius.
    border_rad
        Angle by which the summed region exceeds the opening at either end.
    radii
        Of the opening.
    plate
        Where the summed pixels see the mask plate, whole; None takes all that is wider than the opening by ``border_rad``.
    uneven
        What uneven wheel, dead and uneven pixels add, over the whole sum; None: nothing.
    glare, lost
        Share of the light that goes astray, and where the opening loses it to pixels that are not summed; None: nowhere.
    tails
        Shares that come after the window's end, and the angles by which the wheel turns in their time constants.
    corner_variance_rad2
        By how much more than the window something rounds the corners by an angle, as the variance of that angle.
    bow
        By how much the opening is brighter at both ends than in its middle.
    """

    wheel: WheelModel
    middle_rad: Array
    edges_early_rad: Array
    opening_angle_rad: float
    swept_rad: float
    lean_low_rad: float = 0.0
    lean_high_rad: float = 0.0
    border_rad: float = summed_region.USUAL_BORDER_RAD
    radii: Radii = field(default_factory=Radii)
    plate: SummedRegion | None = None
    uneven: SummedRegion | None = None
    glare: float = 0.0
    lost: SummedRegion | None = None
    tails: tuple[tuple[float, float], ...] = ()
    corner_variance_rad2: float = 0.0
    bow: float = 0.0

    @cached_property
    def sweep_rad(self) -> float:
        """Of a window that rounds the corners as much as all does, never zero: smooth and even in the angle swept."""
        square = self.swept_rad**2 + _OF_A_SPAN * self.corner_variance_rad2
        return float(np.hypot(np.sqrt(max(square, 0.0)), _SHORTEST_RAD))

    @cached_property
    def start_rad(self) -> Array:
        """Wheel angle at the start of the window, shape (n,)."""
        return np.asarray(self.middle_rad - self.sweep_rad / 2)

    @cached_property
    def centre_rad(self) -> Array:
        """Wheel coordinate of the opening's centre then, within one turn, shape (n,)."""
        return np.asarray(np.mod(self.actual.opening_coordinate_rad + self.start_rad, TURN))

    @cached_property
    def opening(self) -> "_Rings":
        """As it is."""
        return _rings(self)

    @cached_property
    def sector(self) -> "_Rings":
        """The opening without leans, alike at all radii."""
        return _rings(self, is_even=True)

    @cached_property
    def wide_sector(self) -> "_Rings":
        """The same, wider by the border."""
        return _rings(self, border_rad=self.border_rad, is_even=True)

    @cached_property
    def ends(self) -> BrightEnds:
        """S and U."""
        return bright_ends(self.start_rad, self.actual, sweep_rad=self.sweep_rad)

    @cached_property
    def of_plate(self) -> SeenRegion | None:
        """What shows of the plate."""
        return self._seen(self.plate)

    @cached_property
    def of_uneven(self) -> SeenRegion | None:
        """What shows of uneven wheel, and of dead and uneven pixels."""
        return self._seen(self.uneven)

    @cached_property
    def of_lost(self) -> SeenRegion | None:
        """What the open part loses, were all light astray."""
        return self._seen(self.lost)

    @cached_property
    def late(self) -> list[Array]:
        """D of each tail, shapes (n,)."""
        return _tails(self)

    def _seen(self, region: SummedRegion | None) -> SeenRegion | None:
        if region is None:
            return None
        edges = self.actual.cutout_edges_rad
        return summed_region.seen(region, self.centre_rad, edges=edges, sweep_rad=self.sweep_rad)

    @cached_property
    def actual(self) -> WheelModel:
        """The wheel with its edges and opening as given."""
        a, b, c, d = (float(e - d) for e, d in zip(self.wheel.cutout_edges_rad, self.edges_early_rad, strict=True))
        return replace(
            self.wheel, cutout_edges_rad=(a, b, c, d), opening_angle_rad=max(self.opening_angle_rad, _NARROWEST_RAD)
        )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Shapes:
    """F with all that belongs to it, S, U, P, B and B'; shapes (n,)."""

    fraction: Array
    skew: Array
    bow: Array
    plate: Array
    blades: Array
    beside: Array

    @property
    def small(self) -> Array:
        """What stands beside F, shape (n, 4)."""
        return np.stack([getattr(self, name) for name in SMALL], axis=1)

    def at(self, frames: Ticks) -> "Shapes":
        """Those of these frames, by their numbers, shape (k,)."""
        return Shapes(**{one.name: getattr(self, one.name)[frames] for one in fields(self)})


def shapes(passing: Passing) -> Shapes:
    """What the sum is made of, each at amount 1.

    Parameters
    ----------
    passing
        Wheel, window and opening.
    """
    opening = passing.opening.fraction
    fraction = opening + _beyond(passing.of_uneven, opening) - passing.glare * _beyond(passing.of_lost, opening)
    for (share, _), late in zip(passing.tails, passing.late, strict=True):
        fraction = fraction + share * late
    return Shapes(
        fraction=fraction + passing.bow * passing.ends.bow,
        skew=passing.ends.skew,
        bow=passing.ends.bow,
        plate=_plate(passing),
        blades=passing.opening.blades,
        beside=_beside(passing),
    )


def remembered(now: Shapes, before: Shapes, *, share: float) -> Shapes:
    """Shapes as a frame shows them that holds a share of the frame before.

    Parameters
    ----------
    now, before
        At the time of each frame, and at that of the frame before it.
    share
        s of `physics.response.pixel_memory`.
    """
    mixed = {
        one.name: (1 - share) * getattr(now, one.name) + share * getattr(before, one.name) for one in fields(Shapes)
    }
    return Shapes(**mixed)


def slopes(
    passing: Passing,
    *,
    skew: float = 0.0,
    plate: float = 0.0,
    blades: float = 0.0,
    beside: float = 0.0,
) -> dict[str, Array]:
    """Derivatives of f by name, each of shape (n,).

    Parameters
    ----------
    passing
        Wheel, window and opening.
    skew, plate, blades, beside
        Amounts of S, P, B and B'.

    Returns
    -------
    By ``edge_0`` .. ``edge_3`` (per rad by which the edge comes earlier; their sum is the derivative to the wheel angle),
    ``opening_angle`` (per rad), ``swept`` (per rad, the middle of the window kept), ``lean_low`` and ``lean_high`` (per rad),
    ``glare`` and ``bow`` (per unit), ``corner_variance`` (per rad^2), ``tail_0``, .. (per unit of each share).
    """
    plain, astray = passing.opening.fraction_slopes, _beyond(passing.of_lost, passing.opening.fraction)
    out = plain + _beyond_slopes(passing.of_uneven, plain) - passing.glare * _beyond_slopes(passing.of_lost, plain)
    out += blades * passing.opening.blades_slopes
    out[:6] += plate * _plate_slopes(passing)
    out[4:6] += (
        skew * passing.ends.skew_slopes + passing.bow * passing.ends.bow_slopes
    )  # to the edges 0, being smaller yet
    out[:6] += beside * _beside_slopes(passing)
    corners = out[5] * _OF_A_SPAN / (2 * passing.sweep_rad)
    out[5] *= passing.swept_rad / passing.sweep_rad
    names = ("edge_0", "edge_1", "edge_2", "edge_3", "opening_angle", "swept", "lean_low", "lean_high")
    others = {"corner_variance": corners, "glare": -astray, "bow": passing.ends.bow}
    return dict(zip(names, out, strict=True)) | others | {f"tail_{k}": late for k, late in enumerate(passing.late)}


def _tails(passing: Passing) -> list[Array]:
    """D of each tail, shape (n,)."""
    if not passing.tails:
        return []
    window, wheel = abs(passing.swept_rad), passing.actual
    first, last = passing.middle_rad - window / 2, passing.middle_rad + window / 2
    fraction = exposed_fraction(first, wheel, sweep_rad=window)
    crossing = edge_in_opening(first, wheel, sweep_rad=window)
    turning = np.tensordot(EDGE_SIGNS, crossing, 1) / wheel.opening_angle_rad
    return [
        fading_fraction(last, wheel, fades_rad=fades) - fraction - (window / 2 + fades) * turning
        for _, fades in passing.tails
    ]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Rings:
    """An opening at k radii: shares of the area and places r_0 / r - mean, (k,); the wheel at low and high ends, (2, k, n)."""

    share: Array
    place: Array
    ends: PointAverage
    opening_rad: float
    sweep_rad: float

    @cached_property
    def fraction(self) -> Array:
        """F, shape (n,)."""
        return np.asarray(self._grown(self.ends.arc_rad) / self.opening_rad)

    @cached_property
    def covered(self) -> Array:
        """Share of the opening that the second blade covers, shape (n,)."""
        return np.asarray(self._grown(self.ends.blade_arc_rad) / self.opening_rad)

    @property
    def blades(self) -> Array:
        """B, shape (n,)."""
        return self.covered - (1 - self.fraction) / 2

    @cached_property
    def fraction_slopes(self) -> Array:
        """Derivatives of F to the angles by which edges come earlier, opening angle, sweep and both leans, (8, n), per rad."""
        crossing = self._grown(self.ends.passed)
        edges = [sign * one for sign, one in zip(EDGE_SIGNS, crossing, strict=True)]
        return self._slopes(edges, self.fraction, ends=self.ends.ends_rad, at=self.ends.openness)

    @cached_property
    def blades_slopes(self) -> Array:
        """The same of B."""
        crossing, none = self._grown(self.ends.passed[2:]), np.zeros_like(self.covered)
        edges = [none, none, crossing[0], -crossing[1]]
        covered = self._slopes(edges, self.covered, ends=self.ends.blade_ends_rad, at=self.ends.behind_second_blade)
        return covered + self.fraction_slopes / 2

    def _slopes(self, edges: list[Array], value: Array, *, ends: Array, at: Array) -> Array:
        gamma, by_place = self.opening_rad, self.share * self.place
        out = np.stack([
            *edges,
            self.share @ (at[0] + at[1]) / 2 - value,
            self._grown(ends) / self.sweep_rad,
            -by_place @ at[0],
            by_place @ at[1],
        ]) / gamma  # fmt: skip
        out[5] -= value / self.sweep_rad
        return np.asarray(out)

    def _grown(self, of_ends: Array) -> Array:
        """Mean over the radii of what a quantity of points, shape (..., 2, k, n), grows by over the opening; (..., n)."""
        return np.asarray(self.share @ (of_ends[..., 1, :, :] - of_ends[..., 0, :, :]))


def _rings(passing: Passing, *, border_rad: float = 0.0, is_even: bool = False) -> _Rings:
    """The opening, wider by a border; or a plain sector, if it is to be even."""
    wheel, over = passing.actual, Radii() if is_even else passing.radii
    leans = np.array([0.0, 0.0] if is_even else [passing.lean_low_rad, passing.lean_high_rad])
    opening_rad = wheel.opening_angle_rad + 2 * border_rad
    from_centre = np.array([-opening_rad / 2, opening_rad / 2])[:, None] + np.multiply.outer(leans, over.place)
    ends = at_point(passing.centre_rad + from_centre[..., None], wheel.cutout_edges_rad, sweep_rad=passing.sweep_rad)
    return _Rings(
        share=over.share, place=over.place, ends=ends, opening_rad=opening_rad, sweep_rad=passing.sweep_rad
    )  # fmt: skip


def _plate(passing: Passing) -> Array:
    """P: the plate as the image shows it, or a border all around, less the opening."""
    narrow = passing.sector.fraction
    return passing.wide_sector.fraction - narrow if passing.of_plate is None else _beyond(passing.of_plate, narrow)


def _plate_slopes(passing: Passing) -> Array:
    """Derivatives of P, as the first six of F."""
    narrow = passing.sector.fraction_slopes[:6]
    if passing.of_plate is None:
        return passing.wide_sector.fraction_slopes[:6] - narrow
    return _beyond_slopes(passing.of_plate, narrow)


def _beside(passing: Passing) -> Array:
    """B': where the plate is, too, less the opening."""
    narrow, seen = passing.sector.blades, passing.of_plate
    return passing.wide_sector.blades - narrow if seen is None else summed_region.blades(seen) - seen.total * narrow


def _beside_slopes(passing: Passing) -> Array:
    """Derivatives of B', as the first six of F."""
    narrow, seen = passing.sector.blades_slopes[:6], passing.of_plate
    if seen is None:
        return passing.wide_sector.blades_slopes[:6] - narrow
    return summed_region.blades_slopes(seen) - seen.total * narrow


def _beyond(seen: SeenRegion | None, fraction: Array) -> Array:
    """R - r F, shape (n,): what a region adds beyond what an opening of the same sum would."""
    if seen is None:
        return np.zeros_like(fraction)
    return seen.exposed - seen.total * fraction


def _beyond_slopes(seen: SeenRegion | None, of_fraction: Array) -> Array:
    """Derivatives of it, as those of F, which are given; the region stays where it is when the opening's ends move."""
    out = np.zeros_like(of_fraction)
    if seen is not None:
        out -= seen.total * of_fraction
        out[:6] += summed_region.slopes(seen)
    return out
