"""How the light of every pixel lies over polar angle: the sector of the contrast image, blurred, with what the ring adds."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.physics import blurred_sector, sector_points
from irtiming.records.arrays import Array, ComplexArray, Mask, Ticks
from irtiming.records.row_timing import SectorFit


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LightOfPixels:
    """Of pixels at ``row_px``, ``column_px``, shapes (p,), about their wheel coordinate's zero, the mask's bisector.

    Parameters
    ----------
    harmonics
        Shape (s, p); sum over a pixel's light of exp(-i m phi), 1 at m = 0 for a pixel wholly in the light.
    share
        Shape (p,); how much of a pixel is in the light.
    angle_rad, reach_rad
        Shape (p,); mean polar angle of even light from the bisector, and its standard deviation by blur and pixel.
    is_inside
        Shape (p,); pixels that the blur of the opening's border does not reach.
    """

    harmonics: ComplexArray
    share: Array
    angle_rad: Array
    reach_rad: Array
    is_inside: Mask


def light_of_pixels(sector: SectorFit, orders: Ticks, *, row_px: Ticks, column_px: Ticks) -> LightOfPixels:
    """Light of some pixels of the region of interest.

    Parameters
    ----------
    sector
        Fitted to the contrast image. Beside the border its blur's share is what its shape says.
    orders
        m, shape (s,).
    row_px, column_px
        Shape (p,).
    """
    shape, roi = sector.shape, sector.roi
    at = row_px - roi[0], column_px - roi[2]
    place, _ = blurred_sector.pixel_places(shape, roi=roi)
    angle = place + blurred_sector.even_angle_rad(shape, roi=roi)
    reach = blurred_sector.angular_reach(shape, roi=roi)
    inside = blurred_sector.well_inside(shape, roi=roi)
    every = np.concatenate([[0], orders])
    even = _even(every, angle, reach)
    points = sector_points.border_points(shape)
    waves = np.exp(-1j * np.multiply.outer(every, points.angle_rad))
    border = blurred_sector.images(points, waves, blur=shape.blur, roi=roi)
    lit = [blurred_sector.with_glare(one, shape) for one in np.where(inside, even, border)]
    astray = blurred_sector.astray_reach(shape, roi=roi)
    ring = sector.ring * (
        (1 - shape.glare) * _even(every, sector.ring_angle_rad, reach)
        + shape.glare * _even(every, sector.ring_angle_rad, astray)
    )
    light = ((1 - sector.plate) * np.array(lit) + ring)[:, *at]
    return LightOfPixels(
        harmonics=light[1:], share=light[0].real, angle_rad=angle[at], reach_rad=reach[at], is_inside=inside[at]
    )


def _even(orders: Ticks, angle_rad: Array, reach_rad: Array) -> ComplexArray:
    """Even light about these angles, smeared by so much, shape (k, rows, columns)."""
    m = orders[:, None, None]
    return np.asarray(np.exp(-1j * m * angle_rad - 0.5 * (m * reach_rad) ** 2))
