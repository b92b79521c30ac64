"""Schatz 2023, sections 3.2.2 and 4: the in-band radiance that makes the lag of a microbolometer linear."""

from math import sqrt

import numpy as np
import pytest
from scipy import constants
from scipy.integrate import quad

from irtiming.physics.radiance import in_band_radiance, slope_ratio, straight_line


def _radiance(kelvin):
    """Planck's law over the band, by scipy's quadrature and constants."""

    def spectral(wavelength):
        x = constants.h * constants.c / (wavelength * constants.k * kelvin)
        return 2 * constants.h * constants.c**2 / wavelength**5 / np.expm1(x)

    return quad(spectral, 7.5e-6, 14e-6, epsrel=1e-12)[0]


def test_radiance_from_288_to_298_k_is_that_printed():
    """Oracle: section 3.2.2, 7.5 to 14 um; the paper prints 48.8 to 57.5 W m^-2 and means W m^-2 sr^-1."""
    assert [f"{value:.1f}" for value in in_band_radiance([288, 298])] == ["48.8", "57.5"]


def test_straight_line_is_off_by_what_is_printed():
    """Oracle: section 3.2.2, 0.038 W m^-2 (sr^-1); a point per half kelvin, over n - 2 as gnuplot's "rms of residuals" is.

    The paper gives no number of points. It fits with gnuplot elsewhere, and this is the only round step that gives 0.038.
    """
    rms = straight_line(288, 298, n_points=21).rms_w_per_m2_sr
    assert f"{rms * sqrt(21 / 19):.3f}" == "0.038"


@pytest.mark.parametrize("n_points", [3, 11, 401])
def test_straight_line_is_the_least_squares_line_whatever_the_points(n_points):
    """Oracle: Planck's law integrated by scipy, and NumPy's line through it; 0.038 within 0.006 as printed, from 11 points on."""
    kelvin = np.linspace(288, 298, n_points)
    radiance = np.array([_radiance(value) for value in kelvin])
    line = np.polyfit(kelvin, radiance, 1)
    found = straight_line(288, 298, n_points=n_points)
    assert found.rms_w_per_m2_sr == pytest.approx(
        np.sqrt(np.mean((radiance - np.polyval(line, kelvin)) ** 2)), rel=1e-5
    )
    assert n_points < 11 or found.rms_w_per_m2_sr == pytest.approx(0.038, abs=0.006)


def test_slope_rises_by_a_factor_of_1_6_from_273_to_323_k():
    """Oracle: section 4, "a factor 1.6 from 273 K to 323 K"; the digits after it by differences of Planck's law."""
    assert f"{slope_ratio(323, 273):.1f}" == "1.6"
    hot, cold = (_radiance(kelvin + 0.01) - _radiance(kelvin - 0.01) for kelvin in (323, 273))
    assert slope_ratio(323, 273) == pytest.approx(hot / cold, rel=1e-6)
