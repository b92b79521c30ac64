"""Over the wheel's angle, what summed pixels see beside the opening's light, and what of that goes astray.

Beside it there are the mask plate, all around, and what an uneven wheel reflects; glare carries light from the opening's ends out
of the summed pixels; pixels that stand in for dead ones see an edge a little before or after these would, and some answer more.
"""

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.special import ndtr

from irtiming.physics import blurred_sector, sector_points
from irtiming.records.arrays import Array, Mask
from irtiming.records.row_timing import SectorFit

_PIXEL_PX = 12**-0.5  # standard deviation of a place within a pixel
_STEP_RAD = float(np.radians(1.5))
_FINE_RAD = 0.08  # within the opening's ends
_N_COARSE = 4  # farther in, where little changes
_REACH = 3.0  # standard deviations of the spread
_MOST_PARTS = 64  # of what single pixels show, each of which is about as wide as the least of their spreads
_INSIDE = 0.98  # of a pixel in the light
_SMOOTH = 3  # powers of the angle, from none on, that light may follow along the opening
_HARDLY = 1e-3  # of the largest part
_N_LOST, _FINE_GLARE = 16, 200  # parts of the opening, and the order of waves for which its nodes are close enough


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LightBeside:
    """What comes from between two of ``ends_rad`` (k + 1,), as shares of the whole sum.

    ``plate`` (k,) is that of a plate that shows as much as the opening does, ``uneven`` (k,) that of the uneven wheel as it is.
    """

    ends_rad: Array
    plate: Array
    uneven: Array


def beside(sector: SectorFit, summed: Mask, *, shift_rad: float) -> LightBeside | None:
    """Mask plate and uneven wheel as the summed pixels see them; None where the cutouts sweep over none of those.

    Parameters
    ----------
    sector
        Fitted to the contrast image.
    summed
        Pixels that are summed, shape (row, column).
    shift_rad
        Mean angle of the light from the bisector, in the wheel's sense: from there angles are counted.

    Notes
    -----
    Wheel coordinates grow against polar angles of a clockwise wheel.
    """
    row0, row1, column0, column1 = sector.roi
    lit = summed[row0:row1, column0:column1] & (sector.swept > 0)
    if not np.any(lit):
        return None
    _, radius = blurred_sector.pixel_places(sector.shape, roi=sector.roi)
    place = shift_rad - sector.ring_angle_rad[lit]
    shape, away = sector.shape, np.maximum(radius[lit], 1.0)
    sigma = np.hypot(shape.blur_px, _PIXEL_PX) / away
    astray = np.hypot(sigma, shape.glare_px / away)
    ends = _ends(shape.opening_angle_rad, float(np.max(np.abs(place) + _REACH * sigma)))
    before = np.array([
        (1 - shape.glare) * ndtr((end - place) / sigma) + shape.glare * ndtr((end - place) / astray) for end in ends
    ])  # fmt: skip
    seen = sector.swept, sector.ring - sector.plate * sector.swept
    whole = np.sum(sector.contrast[summed[row0:row1, column0:column1]])
    plate, uneven = (np.diff(before @ one[lit]) / whole for one in seen)
    return LightBeside(ends_rad=ends, plate=plate, uneven=uneven)


def lost(sector: SectorFit, summed: Mask, *, shift_rad: float) -> tuple[Array, Array]:
    """Ends (k + 1,), rad, and what part of the opening's light each part (k,) loses from the summed pixels, were all of it glare.

    Parameters
    ----------
    sector
        Fitted to the contrast image; its glare's width counts.
    summed, shift_rad
        As for `beside`.
    """
    row0, row1, column0, column1 = sector.roi
    shape = sector.shape
    points = sector_points.glare_points(shape, n_harmonics=_FINE_GLARE)
    kept = blurred_sector.glare_kept(points, summed[row0:row1, column0:column1], shape=shape, roi=sector.roi).sum(
        axis=1
    )
    gone = points.area_px2 * (1 - kept) / points.area_px2.sum()
    half = shape.opening_angle_rad / 2
    ends = np.linspace(-half, half, _N_LOST + 1)
    place = shift_rad - points.angle_rad
    inside = np.array([gone @ ndtr((end - place) / points.gap_rad) for end in ends[1:-1]])
    return ends, np.diff(inside, prepend=0.0, append=gone.sum())


def of_single_pixels(sector: SectorFit, summed: Mask, *, weight: Array, shift_rad: float) -> tuple[Array, Array]:
    """Ends (k + 1,), rad, and what each part (k,) shows more than even, live pixels do, over the whole sum; both may be empty.

    Parameters
    ----------
    sector
        Fitted to the contrast image.
    summed, shift_rad
        As for `beside`.
    weight
        How often each pixel counts in the sum, shape (row, column).
    """
    row0, row1, column0, column1 = sector.roi
    plain, counted = (one[row0:row1, column0:column1] for one in (summed, weight))
    light = (1 - sector.plate) * sector.model_contrast + sector.ring
    more = (counted - plain) * light + counted * _fine(sector)
    changed = more != 0
    if not np.any(changed):
        return np.zeros(0), np.zeros(0)
    spread = blurred_sector.angular_reach(sector.shape, roi=sector.roi)[changed]
    place = shift_rad - sector.borrowed_angle_rad[changed]
    farthest = float(np.max(np.abs(place) + _REACH * spread))
    n_parts = min(_MOST_PARTS, int(np.ceil(2 * farthest / float(np.min(spread)))))
    ends = np.linspace(-farthest, farthest, n_parts + 1)
    before = np.array([ndtr((end - place) / spread) @ more[changed] for end in ends])
    share = np.diff(before) / np.sum(sector.contrast[plain])
    return _only_where_some(ends, share)


def _fine(sector: SectorFit) -> Array:
    """What pixels show beyond the model, without what is smooth along the opening, shape (roi rows, roi columns).

    As much of it as is not noise; the sum's fit knows of light that is brighter at one end, or at both.
    """
    light, angle = sector.model_contrast, sector.borrowed_angle_rad
    inside = light > _INSIDE
    scatter = float(np.mean(sector.excess[inside] ** 2)) if inside.any() else 0.0
    if scatter <= 0:
        return np.zeros_like(light)
    powers = np.stack([light * angle**k for k in range(_SMOOTH)])
    moments = np.stack([angle**k for k in range(_SMOOTH)])
    normal = np.einsum("kij,lij->kl", moments, powers)
    smooth = np.linalg.solve(normal, np.einsum("kij,ij->k", moments, sector.excess))
    return np.asarray(min(1.0, sector.gain_scatter**2 / scatter) * (sector.excess - np.tensordot(smooth, powers, 1)))


def _only_where_some(ends_rad: Array, share: Array) -> tuple[Array, Array]:
    """The same with parts of which hardly anything comes taken together."""
    some = np.abs(share) > _HARDLY * np.max(np.abs(share))
    kept = np.concatenate([[True], some[1:] | some[:-1], [True]])
    places = np.flatnonzero(kept)
    return ends_rad[places], np.add.reduceat(np.where(some, share, 0.0), places[:-1])


def _ends(opening_angle_rad: float, farthest_rad: float) -> Array:
    """Fine steps about both ends of the opening and as far as the plate shows, coarse ones within."""
    inner = max(opening_angle_rad / 2 - _FINE_RAD, opening_angle_rad / 4)
    farthest = max(farthest_rad, opening_angle_rad / 2)
    outer = np.linspace(inner, farthest, max(2, 1 + round((farthest - inner) / _STEP_RAD)))
    return np.concatenate([-outer[::-1], np.linspace(-inner, inner, _N_COARSE + 1)[1:-1], outer])
