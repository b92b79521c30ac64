"""The ring that the wheel's cutouts sweep, as blurred pixels see it: how much of it, and from which polar angle.

Within the ring a pixel's light comes from all around its place. At an arc it comes from one side alone, and where the blur is
`blurred_sector.askew_px_rad`, what comes from farther out comes from another angle, too.
"""

import math
from dataclasses import dataclass
from typing import final

import numpy as np
from numba import njit

from irtiming.physics import blurred_sector
from irtiming.records.arrays import Array
from irtiming.records.row_timing import SectorShape

_FAR = 8.3  # standard deviations: beyond is less than the last digit
_LEAST_SHARE = 1e-3  # of the ring: of less light no angle is asked for
_PIXEL_PX2 = 1 / 12  # variance of a place within a pixel


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class AlongRadius:
    """Mean distance from the axle of what pixels see, its blur, px, and `askew_px_rad`; shapes (roi rows, roi columns)."""

    radius_px: Array
    blur_px: Array
    askew_px_rad: Array


def along_radius(shape: SectorShape, *, roi: tuple[int, int, int, int]) -> AlongRadius:
    """Those of a region of interest: what a blur moves across the radius lies farther from the axle."""
    _, radius = blurred_sector.pixel_places(shape, roi=roi)
    return AlongRadius(
        radius_px=radius * (1 + blurred_sector.angular_reach(shape, roi=roi) ** 2 / 2),
        blur_px=blurred_sector.blur_across_px(shape, roi=roi, along=True),
        askew_px_rad=blurred_sector.askew_px_rad(shape, roi=roi),
    )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Ring:
    """Share of the ring in each pixel, shape (roi rows, roi columns): what stays where it is, and what glare leads astray.

    ``moment_rad`` is the first, times the mean angle by which its light lies beside even light, in the wheel's sense.
    """

    stays: Array
    astray: Array
    moment_rad: Array

    @property
    def whole(self) -> Array:
        """Both."""
        return self.stays + self.astray

    @property
    def aside_rad(self) -> Array:
        """By how much the mean polar angle of both exceeds that of even light; 0 where there is hardly any."""
        whole = self.whole
        return np.asarray(np.where(whole > _LEAST_SHARE, self.moment_rad / np.maximum(whole, _LEAST_SHARE), 0.0))


def seen(shape: SectorShape, arcs_px: tuple[float, float], *, places: AlongRadius) -> Ring:
    r"""Ring between two arcs as pixels in these places see it.

    Of a share s of the ring, smeared by a Gaussian along the radius r, light lies beside its even place by
    :math:`c\, s'(r) / s`, where c is the covariance of distance and angle.

    Parameters
    ----------
    shape
        Its glare counts.
    arcs_px
        Radii of the inner and of the outer arc.
    places
        Of the pixels.
    """
    stays, slope = _between_arcs(places.radius_px, places.blur_px, _PIXEL_PX2, arcs_px)
    astray, _ = _between_arcs(places.radius_px, places.blur_px, _PIXEL_PX2 + shape.glare_px**2, arcs_px)
    return Ring(
        stays=(1 - shape.glare) * stays,
        astray=shape.glare * astray,
        moment_rad=(1 - shape.glare) * places.askew_px_rad * slope,
    )


@njit(cache=True, nogil=True)
def _between_arcs(radius: Array, blur: Array, variance: float, arcs: tuple[float, float]) -> tuple[Array, Array]:
    """Share of the ring at each radius, smeared by a blur and a further variance, and its slope, 1/px; shapes (row, column)."""
    share, slope = np.empty(radius.shape), np.zeros(radius.shape)
    for row in range(radius.shape[0]):
        for column in range(radius.shape[1]):
            width = math.sqrt(blur[row, column] ** 2 + variance)
            inner = (radius[row, column] - arcs[0]) / width
            outer = (arcs[1] - radius[row, column]) / width
            beyond, within = _normal_below(inner), _normal_below(outer)
            share[row, column] = beyond * within
            if min(abs(inner), abs(outer)) < _FAR:
                slope[row, column] = (_normal(inner) * within - beyond * _normal(outer)) / width
    return share, slope


@njit(cache=True, nogil=True)
def _normal(place: float) -> float:
    """Density of the standard normal distribution."""
    return math.exp(-0.5 * place * place) / math.sqrt(2 * math.pi)


@njit(cache=True, nogil=True)
def _normal_below(place: float) -> float:
    """Part of the standard normal distribution below a place; most places are far from it."""
    if abs(place) > _FAR:
        return 1.0 if place > 0 else 0.0
    return 0.5 * math.erfc(-place / math.sqrt(2.0))
