"""Schatz 2023, sections 2.4 and 2.5: the model of the wheel and its numbers."""

from math import floor, pi, radians

import numpy as np
import pytest

from irtiming.physics.wheel import corner_angles_rad, exposed_fraction, slope_centres_rad, wheel_model

GAMMA = 5 / 12 * pi
EDGES = (0.0, 1.5718, 3.1421, 4.7125)


@pytest.fixture(scope="module")
def model():
    """Return the wheel of figure 4 with its mask at the top of the image."""
    return wheel_model(EDGES, 0.27, opening_angle_rad=GAMMA, centre_angle_rad=radians(-90))


def test_mask_cutout_angle_is_five_twelfths_of_pi():
    """Oracle: sections 2.1 and 2.5; a 75 deg section, gamma = 5/12 pi."""
    assert pytest.approx(radians(75), abs=1e-15) == GAMMA


def test_figure_4b_has_four_slopes_of_75_deg_and_four_plateaus_of_15(model):
    """Oracle: section 3.1.3; 75 of 90 deg leave 15 deg wholly open or covered, twice each."""
    ideal = wheel_model(tuple(np.arange(4) * pi / 2), 0.27, opening_angle_rad=GAMMA, centre_angle_rad=-pi / 2)
    corners = np.degrees(np.sort(corner_angles_rad(ideal), axis=0))
    np.testing.assert_allclose(corners[:, 1] - corners[:, 0], 75)
    np.testing.assert_allclose(np.diff(np.append(corners[:, 0], corners[0, 0] + 360)) - 75, 15)
    theta = np.radians(np.arange(0, 360, 0.1) + 0.05)
    fraction = exposed_fraction(theta, ideal)
    assert np.mean(fraction > 1 - 1e-9) == pytest.approx(30 / 360, abs=1e-3)
    assert np.mean(fraction < 1e-9) == pytest.approx(30 / 360, abs=1e-3)


def test_slopes_are_linear_with_inclination_one_over_gamma(model):
    """Oracle: section 3.1.4; the slopes are linear due to the design of the cutout, 1/2 + m (x - c), m = +-1/gamma."""
    for i, centre in enumerate(slope_centres_rad(model)):
        x = centre + np.linspace(-0.45, 0.45, 50) * GAMMA
        m = (-1 if i % 2 == 0 else 1) / GAMMA
        np.testing.assert_allclose(exposed_fraction(x, model), 0.5 + m * (x - centre), atol=1e-12)


def test_delay_of_the_next_control_slot_resolves_the_gates():
    """Oracle: section 2.5 with the order of the gates taken from the geometry (conventions.md).

    With the control gate first on an edge's way, slot j passes it at theta = j pi/50 - dbeta, so the next one after
    the reference edge comes (floor(dbeta 50/pi) + 1) pi/50 - dbeta later, not dbeta - floor(...) pi/50.
    """
    dbeta = 0.5697
    passages = np.arange(0, 100) * pi / 50 - dbeta
    first = passages[passages > 0].min()
    whole = floor(dbeta * 50 / pi)
    assert whole == 9
    assert first == pytest.approx((whole + 1) * pi / 50 - dbeta)
    assert first != pytest.approx(dbeta - whole * pi / 50, abs=1e-3)


def test_oscilloscope_irregularity_as_an_angle():
    """Oracle: section 4; 26 us between half turns at 3 Hz are 0.49 mrad, 28 mdeg."""
    assert 26e-6 * 2 * pi * 3 == pytest.approx(0.49e-3, rel=0.01)
