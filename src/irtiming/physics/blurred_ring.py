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


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class EvenLight:
    """Where the light lies that pixels see of what is even; shapes (roi rows, roi columns).

    ``angle_rad`` is its mean polar angle from the bisector, ``reach_rad`` the standard deviation of that; ``radius_px`` its mean
    distance from the axle, ``along_px`` the blur along it; ``askew_px_rad`` as `blurred_sector` has it.
    """

    angle_rad: Array
    reach_rad: Array
    radius_px: Array
    along_px: Array
    askew_px_rad: Array


def even_light(shape: SectorShape, *, roi: tuple[int, int, int, int]) -> EvenLight:
    """That of a region of interest: what a blur moves across the radius lies farther from the axle."""
    angle, radius = blurred_sector.pixel_places(shape, roi=roi)
    reach = blurred_sector.angular_reach(shape, roi=roi)
    return EvenLight(
        angle_rad=angle + blurred_sector.even_angle_rad(shape, roi=roi),
        reach_rad=reach,
        radius_px=radius * (1 + reach**2 / 2),
        along_px=blurred_sector.blur_across_px(shape, roi=roi, along=True),
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


def seen(shape: SectorShape, arcs_px: tuple[float, float], *, even: EvenLight) -> Ring:
    r"""Ring between two arcs as pixels see it.

    Of a share s of the ring, smeared by a Gaussian along the radius r, light lies beside its even place by
    :math:`c\, s'(r) / s`, where c is the covariance of distance and angle.

    Parameters
    ----------
    shape
        Its glare counts.
    arcs_px
        Radii of the inner and of the outer arc.
    even
        Of the pixels.
    """
    stays, slope = _between_arcs(even.radius_px, even.along_px, blurred_sector.PIXEL_PX2, arcs_px)
    astray, _ = _between_arcs(even.radius_px, even.along_px, blurred_sector.PIXEL_PX2 + shape.glare_px**2, arcs_px)
    return Ring(
        stays=(1 - shape.glare) * stays,
        astray=shape.glare * astray,
        moment_rad=(1 - shape.glare) * even.askew_px_rad * slope,
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
