r"""What a whole region of pixels sees of the passing wheel: more than the mask opening, whose plate shows around it.

.. math:: R(\theta) = \sum_k s_k \frac{1}{a_{k+1} - a_k} \int_{a_k}^{a_{k+1}} \mathrm{open}(\theta + a)\, da

The region has the share s_k of its light between the angles a_k and a_{k+1} from the opening's centre; a border that is some
pixels wide spans the smaller an angle the farther it lies from the axle, so it is no wider sector.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from irtiming.physics.wheel import EDGE_SIGNS, summed_points
from irtiming.records.arrays import Array
from irtiming.records.reduced import AxleView, Opening
from irtiming.records.wheel_geometry import EdgeAngles

USUAL_BORDER_RAD = 0.1
"""By how much summed pixels exceed an opening at either end, where the image does not tell."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SummedRegion:
    """How a region's light spreads over the wheel coordinate: ``ends_rad`` (k + 1,) from the opening's centre, ``share`` (k,)."""

    ends_rad: Array
    share: Array

    @property
    def total(self) -> float:
        """Sum of the shares: 1 of light that is everywhere of one sign."""
        return float(np.sum(self.share))

    @cached_property
    def weight(self) -> Array:
        """What each end's open arc counts for in the mean, 1/rad, shape (k + 1,): density before it less that behind it."""
        return np.asarray(-np.diff(self.share / np.diff(self.ends_rad), prepend=0.0, append=0.0))


def radii_px(opening: Opening, axle: AxleView | None) -> Array | None:
    """Distance of the opening's pixels from the axle, shape (n,); None where either was not found."""
    if axle is None or not opening.mask.any():
        return None
    rows, columns = np.nonzero(opening.mask)
    return np.hypot(rows - axle.row_px, columns - axle.column_px)


def border_rad(border_px: float, *, radii_px: Array | float | None) -> float:
    """Angle by which the summed pixels exceed the opening at either end.

    Parameters
    ----------
    border_px
        By how much they exceed it on all sides.
    radii_px
        Shape (n,): distances of the opening's pixels from the axle, or their mean; None where they are not known.
    """
    return USUAL_BORDER_RAD if radii_px is None else float(np.clip(border_px / np.mean(radii_px), 1e-2, 0.3))


def sector(opening_angle_rad: float, border_rad: float) -> SummedRegion:
    """A region that exceeds an opening by the same angle at either end.

    Parameters
    ----------
    opening_angle_rad, border_rad
        Of the opening, and beyond it.
    """
    half = opening_angle_rad / 2 + border_rad
    return SummedRegion(ends_rad=np.array([-half, half]), share=np.ones(1))


def together(*regions: SummedRegion | None) -> SummedRegion | None:
    """What several regions show, as one; None of none.

    Parameters
    ----------
    *regions
        Each may be None, which shows nothing.
    """
    known = [one for one in regions if one is not None]
    if not known:
        return None
    ends = np.unique(np.concatenate([one.ends_rad for one in known]))
    before = np.sum(
        [np.interp(ends, one.ends_rad, np.concatenate([[0.0], np.cumsum(one.share)])) for one in known], axis=0
    )
    return SummedRegion(ends_rad=ends, share=np.diff(before))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SeenRegion:
    """A region while the wheel sweeps past it by ``sweep_rad`` (`physics.wheel.PointAverage`, weighed over the region's ends).

    ``exposed`` (n,) is R, ``at_ends`` (n,) the same averaged over the window's two ends only, ``covered`` and ``covered_at_ends``
    (n,) the like of what the second blade covers, ``passed`` (4, n) how often each edge has passed. ``total`` is R where all is
    open.
    """

    exposed: Array
    at_ends: Array
    covered: Array
    covered_at_ends: Array
    passed: Array
    total: float
    sweep_rad: float


def seen(region: SummedRegion, centre_rad: Array, *, edges: EdgeAngles, sweep_rad: float) -> SeenRegion:
    """What shows of a region while the wheel turns.

    Parameters
    ----------
    region
        Its area.
    centre_rad
        Wheel coordinate of the opening's centre at the start of the window, shape (n,).
    edges
        alpha_0 .. alpha_3.
    sweep_rad
        Angle of the window.
    """
    points = summed_points(centre_rad, region.ends_rad, weight=region.weight, edges=edges, sweep_rad=sweep_rad)
    return SeenRegion(
        exposed=points.arc_rad, at_ends=points.ends_rad, covered=points.blade_arc_rad, covered_at_ends=points.blade_ends_rad,
        passed=points.passed, total=region.total, sweep_rad=sweep_rad,
    )  # fmt: skip


def slopes(region: SeenRegion) -> Array:
    """Derivatives of R per rad, shape (6, n): to the angles by which edges come early, the opening angle (none), and the sweep.

    Parameters
    ----------
    region
        As it is seen.
    """
    out = np.zeros((6, region.exposed.size))
    out[:4] = np.array(EDGE_SIGNS)[:, None] * region.passed
    out[5] = (region.at_ends - region.exposed) / region.sweep_rad
    return out


def blades(region: SeenRegion) -> Array:
    """Half of what the second blade covers less half of what the first does, shape (n,).

    Parameters
    ----------
    region
        As it is seen.
    """
    return region.covered - (region.total - region.exposed) / 2


def blades_slopes(region: SeenRegion) -> Array:
    """Derivatives of `blades` per rad, shape (6, n), as of `slopes`.

    Parameters
    ----------
    region
        As it is seen.
    """
    out = slopes(region) / 2
    out[2] += region.passed[2]
    out[3] -= region.passed[3]
    out[5] += (region.covered_at_ends - region.covered) / region.sweep_rad
    return out
