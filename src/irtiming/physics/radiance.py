r"""In-band radiance of a black surface by Planck's law, and how straight it is over temperature (Schatz 2023, 3.2.2, 4).

Definitions
-----------
===================  =========================================================================================
name                 definition
===================  =========================================================================================
spectral radiance    :math:`L_\lambda(T) = 2 h c^2 \lambda^{-5} / (e^x - 1)` with :math:`x = h c / (\lambda k T)`
in-band radiance     :math:`L(T)`, the integral of :math:`L_\lambda` over the band, W m^-2 sr^-1
radiance slope       :math:`dL/dT`, the integral of :math:`L_\lambda x / (T (1 - e^{-x}))`, W m^-2 sr^-1 K^-1
===================  =========================================================================================

A band is the pair of its shortest and longest wavelength, m; the camera counts as equally sensitive from one to the other
and as blind outside. h, c and k are exact in the SI.

Both integrals are Gauss-Legendre sums over the logarithm of the wavelength, where the integrands are smooth bells. From 20 K
on they are off by less than 1e-11 of their value.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike
from scipy import constants

from irtiming.records.arrays import Array

Band: TypeAlias = tuple[float, float]

MICROBOLOMETER_BAND_M: Band = (7.5e-6, 14e-6)
"""Where the microbolometer camera of the paper is sensitive (3.2.2)."""

_FEWEST_NODES = 32
_NODES_PER_E_FOLD = 7  # of the wavelength; enough from the far ultraviolet to radio waves


@final
@dataclass(frozen=True, kw_only=True)
class StraightLine:
    """Straight line by least squares through the in-band radiance.

    ``slope_w_per_m2_sr_k`` and ``intercept_w_per_m2_sr``, the latter at 0 K; ``rms_w_per_m2_sr`` is the root of the mean squared
    distance of the points from it.
    """

    slope_w_per_m2_sr_k: float
    intercept_w_per_m2_sr: float
    rms_w_per_m2_sr: float


def in_band_radiance(temperature_k: ArrayLike, *, band_m: Band = MICROBOLOMETER_BAND_M) -> Array:
    """Radiance of a black surface within the band.

    Parameters
    ----------
    temperature_k
        Any shape, above 0; K.
    band_m
        Shortest and longest wavelength, m.

    Returns
    -------
    Same shape; W m^-2 sr^-1.

    Notes
    -----
    Schatz 2023, section 3.2.2, which calls it irradiance and prints W m^-2: the steradian is missing.
    """
    temperature = np.asarray(temperature_k, dtype=np.float64)
    total = np.zeros_like(temperature)
    for wavelength_m, width_m in _nodes(band_m):
        total += width_m * _spectral_radiance(wavelength_m, temperature)
    return total


def radiance_slope(temperature_k: ArrayLike, *, band_m: Band = MICROBOLOMETER_BAND_M) -> Array:
    """By how much the in-band radiance grows per kelvin; shapes as above, W m^-2 sr^-1 K^-1."""
    temperature = np.asarray(temperature_k, dtype=np.float64)
    total = np.zeros_like(temperature)
    for wavelength_m, width_m in _nodes(band_m):
        x = _photon_energy(wavelength_m, temperature)
        total += width_m * _spectral_radiance(wavelength_m, temperature) * x / (temperature * -np.expm1(-x))
    return total


def slope_ratio(hot_k: float, cold_k: float, *, band_m: Band = MICROBOLOMETER_BAND_M) -> float:
    """How many times steeper the in-band radiance is at ``hot_k`` than at ``cold_k`` (Schatz 2023, section 4)."""
    hot, cold = radiance_slope([hot_k, cold_k], band_m=band_m)
    return float(hot / cold)


def straight_line(
    lowest_k: float, highest_k: float, *, n_points: int = 101, band_m: Band = MICROBOLOMETER_BAND_M
) -> StraightLine:
    """Straight line through the in-band radiance at equally spaced temperatures, both ends among them.

    Parameters
    ----------
    lowest_k, highest_k
        Ends of the range, K.
    n_points
        At least 3. Ends count for less when the points are closer: the root mean square falls a little with their number.
    band_m
        Shortest and longest wavelength, m.

    Notes
    -----
    Schatz 2023, section 3.2.2, prints a deviation of 0.038 and no number of points. A point per kelvin gives 0.0388, many
    points 0.0327. A point per half kelvin gives 0.0377 with the n - 2 degrees of freedom by which gnuplot divides.
    """
    temperature = np.linspace(lowest_k, highest_k, n_points)
    radiance = in_band_radiance(temperature, band_m=band_m)
    centre = temperature.mean()
    away = temperature - centre
    slope = float(away @ radiance / (away @ away))
    distance = radiance - radiance.mean() - slope * away
    return StraightLine(
        slope_w_per_m2_sr_k=slope,
        intercept_w_per_m2_sr=float(radiance.mean() - slope * centre),
        rms_w_per_m2_sr=float(np.sqrt(np.mean(distance**2))),
    )


@lru_cache(maxsize=8)
def _nodes(band_m: Band) -> tuple[tuple[float, float], ...]:
    """Wavelength and its width in the sum, both in m."""
    half = math.log(band_m[1] / band_m[0]) / 2
    count = max(_FEWEST_NODES, math.ceil(2 * half * _NODES_PER_E_FOLD))
    place, weight = np.polynomial.legendre.leggauss(count)
    wavelength_m = math.sqrt(band_m[0] * band_m[1]) * np.exp(half * place)
    return tuple(zip(wavelength_m.tolist(), (half * weight * wavelength_m).tolist(), strict=True))


def _photon_energy(wavelength_m: float, temperature_k: Array) -> Array:
    """Energy of a photon, h c / lambda, over k T."""
    return np.asarray(constants.h * constants.c / (wavelength_m * constants.k * temperature_k))


def _spectral_radiance(wavelength_m: float, temperature_k: Array) -> Array:
    """Planck's law, W m^-3 sr^-1; written with exp(-x), which cannot overflow."""
    x = _photon_energy(wavelength_m, temperature_k)
    return np.asarray(2 * constants.h * constants.c**2 / wavelength_m**5 * np.exp(-x) / -np.expm1(-x))
