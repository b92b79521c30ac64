"""Schatz 2023, sections 3.2.2 and 4: the in-band radiance that makes the lag of a microbolometer linear."""

from math import sqrt

import pytest

from irtiming.physics.radiance import in_band_radiance, slope_ratio, straight_line


def test_radiance_from_288_to_298_k_is_that_printed():
    """Oracle: section 3.2.2, 7.5 to 14 um; the paper prints 48.8 to 57.5 W m^-2 and means W m^-2 sr^-1."""
    assert [f"{value:.1f}" for value in in_band_radiance([288, 298])] == ["48.8", "57.5"]


def test_straight_line_is_off_by_what_is_printed():
    """Oracle: section 3.2.2, 0.038 W m^-2 (sr^-1); a point per half kelvin, over n - 2 as gnuplot's "rms of residuals" is.

    The paper gives no number of points. It fits with gnuplot elsewhere, and this is the only round step that gives 0.038.
    """
    rms = straight_line(288, 298, n_points=21).rms_w_per_m2_sr
    assert f"{rms * sqrt(21 / 19):.3f}" == "0.038"


@pytest.mark.parametrize(("n_points", "expected"), [(11, "0.0388"), (10_001, "0.0327")])
def test_straight_line_is_off_by_about_as_much_with_other_points(n_points, expected):
    """Oracle: a parabola's RMS about its line, 0.03270 times sqrt((n + 1) (n + 2) (n - 2) / (n - 1)^3); 0.038 within 0.006."""
    rms = straight_line(288, 298, n_points=n_points).rms_w_per_m2_sr
    n = n_points
    assert rms == pytest.approx(0.03270 * sqrt((n + 1) * (n + 2) * (n - 2) / (n - 1) ** 3), rel=1e-3)
    assert f"{rms:.4f}" == expected
    assert rms == pytest.approx(0.038, abs=0.006)


def test_slope_rises_by_a_factor_of_1_6_from_273_to_323_k():
    """Oracle: section 4, "a factor 1.6 from 273 K to 323 K"; 1.63 with one digit more."""
    assert f"{slope_ratio(323, 273):.1f}" == "1.6"
    assert slope_ratio(323, 273) == pytest.approx(1.63, abs=0.005)
