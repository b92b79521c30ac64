"""In-band radiance against adaptive quadrature, a series, Stefan and Boltzmann's law, Wien's and differences."""

from itertools import pairwise
from math import log, pi

import numpy as np
import pytest
from scipy import constants
from scipy.integrate import quad

from irtiming.physics.radiance import in_band_radiance, radiance_slope, slope_ratio, straight_line

LONG_WAVE = (7.5e-6, 14e-6)
BANDS = [LONG_WAVE, (3e-6, 5e-6), (1e-6, 100e-6), (9.9e-6, 10.1e-6)]


def _planck(wavelength_m, temperature_k):
    x = constants.h * constants.c / (wavelength_m * constants.k * temperature_k)
    return 2 * constants.h * constants.c**2 / (wavelength_m**5 * np.expm1(x))


def _beyond(wavelength_m, temperature_k):
    """Radiance of all longer photon energies, by the series of 1 / (e^x - 1) in powers of e^-x, each term integrated."""
    x = constants.h * constants.c / (wavelength_m * constants.k * temperature_k)
    n = np.arange(1, int(45 / x) + 2)
    total = np.sum(np.exp(-n * x) * (x**3 / n + 3 * x**2 / n**2 + 6 * x / n**3 + 6 / n**4))
    return 2 * (constants.k * temperature_k) ** 4 / (constants.h**3 * constants.c**2) * total


@pytest.mark.parametrize("band", BANDS)
@pytest.mark.parametrize("temperature", [77.0, 288.0, 323.0, 1500.0])
def test_radiance_agrees_with_adaptive_quadrature(band, temperature):
    """Oracle: scipy's quad over the wavelength, in pieces of equal ratio."""
    ends = np.geomspace(*band, 9)
    pieces = [quad(_planck, a, b, args=(temperature,), epsabs=0, epsrel=1e-12)[0] for a, b in pairwise(ends)]
    assert in_band_radiance(temperature, band_m=band) == pytest.approx(sum(pieces), rel=1e-11)


@pytest.mark.parametrize("band", BANDS[:3])
@pytest.mark.parametrize("temperature", [20.0, 50.0, 288.0, 3000.0])
def test_radiance_agrees_with_the_series_of_exponentials(band, temperature):
    """Oracle: the polylogarithm series above each end of the band, and their difference."""
    expected = _beyond(band[1], temperature) - _beyond(band[0], temperature)
    assert in_band_radiance(temperature, band_m=band) == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("temperature", [200.0, 300.0, 1000.0])
def test_all_wavelengths_together_obey_stefan_and_boltzmann(temperature):
    """Oracle: sigma T^4 / pi, and 4 sigma T^3 / pi for the slope; 1e-7 m to 1 m leaves out less than 1e-13."""
    everything = (1e-7, 1.0)
    expected = constants.sigma * temperature**4 / pi
    assert in_band_radiance(temperature, band_m=everything) == pytest.approx(expected, rel=1e-11)
    assert radiance_slope(temperature, band_m=everything) == pytest.approx(4 * expected / temperature, rel=1e-11)


def test_long_waves_obey_rayleigh_and_jeans():
    """Oracle: 2 c k T / lambda^4 integrated, for photons of a ten-thousandth of k T; the first correction is x / 2."""
    short, long = 0.5, 1.0
    expected = 2 * constants.c * constants.k * 300.0 * (short**-3 - long**-3) / 3
    assert in_band_radiance(300.0, band_m=(short, long)) == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("band", BANDS)
@pytest.mark.parametrize("temperature", [150.0, 273.0, 323.0])
def test_slope_is_the_difference_of_radiances(band, temperature):
    """Oracle: a fourth-order central difference."""
    step = 1e-3 * temperature
    below, above = (in_band_radiance(temperature + np.array([-n, n]) * step, band_m=band) for n in (2, 1))
    difference = (8 * (above[1] - above[0]) - (below[1] - below[0])) / (12 * step)
    assert radiance_slope(temperature, band_m=band) == pytest.approx(difference, rel=1e-7)


def test_slope_ratio_of_a_narrow_band_at_short_waves_follows_wien():
    """Oracle: Wien's law, ln(dL/dT) = const - 2 ln T - c2 / (lambda T), with c2 = h c / k."""
    second = constants.h * constants.c / constants.k
    expected = -2 * log(300 / 250) + second / 1e-6 * (1 / 250 - 1 / 300)
    assert log(slope_ratio(300, 250, band_m=(1e-6 * (1 - 1e-7), 1e-6 * (1 + 1e-7)))) == pytest.approx(
        expected, abs=1e-9
    )


def test_shapes_are_kept():
    """Oracle: one temperature at a time."""
    temperature = np.linspace(200, 400, 12).reshape(3, 2, 2)
    for quantity in (in_band_radiance, radiance_slope):
        values = quantity(temperature)
        assert values.shape == temperature.shape
        np.testing.assert_array_equal(values.ravel(), [quantity(one) for one in temperature.ravel()])
    assert in_band_radiance(300).shape == ()


def test_hardly_any_radiance_is_left_near_absolute_zero():
    """Oracle: exp(-x) with x beyond a thousand; neither overflow nor not-a-number."""
    assert in_band_radiance(1.0) == 0
    assert radiance_slope(1.0) == 0


@pytest.mark.parametrize(("lowest", "highest", "count"), [(288, 298, 11), (273, 323, 101), (200.0, 400.0, 3)])
def test_straight_line_is_that_of_numpy(lowest, highest, count):
    """Oracle: numpy's polyfit of degree 1, and its residuals."""
    temperature = np.linspace(lowest, highest, count)
    radiance = in_band_radiance(temperature)
    slope, intercept = np.polyfit(temperature, radiance, 1)
    line = straight_line(lowest, highest, n_points=count)
    assert line.slope_w_per_m2_sr_k == pytest.approx(slope, rel=1e-9)
    assert line.intercept_w_per_m2_sr == pytest.approx(intercept, rel=1e-9)
    distance = radiance - np.polyval((slope, intercept), temperature)
    assert line.rms_w_per_m2_sr == pytest.approx(np.sqrt(np.mean(distance**2)), rel=1e-7)


def test_straight_line_of_a_narrow_range_is_the_tangent():
    """Oracle: the slope in the middle; over 0.1 K the bend is nothing."""
    line = straight_line(292.95, 293.05)
    assert line.slope_w_per_m2_sr_k == pytest.approx(float(radiance_slope(293.0)), rel=1e-6)
    assert line.rms_w_per_m2_sr < 1e-5
