"""Harmonics of what the wheel uncovers against integrals and the wheel's own steps."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from irtiming.physics.wheel import exposed_fraction, wheel_model
from irtiming.physics.wheel_harmonics import at_angles, later, open_harmonics

TURN = 2 * np.pi
OMEGA = 3 * TURN
EDGES = (0.0, 1.61, 3.13, 4.75)
MODEL = wheel_model(EDGES, 0.27, opening_angle_rad=1.3, centre_angle_rad=float(np.radians(-91)))


def _arcs(theta_of_edge):
    """Wheel angles between which the opening's centre is open, and the level of each arc."""
    a, b, c, d = theta_of_edge
    return ((a, b, 0.0), (b, c, 1.0), (c, d, 0.0), (d, a + TURN, 1.0))


def _angles():
    return [edge - MODEL.opening_coordinate_rad for edge in EDGES]


def _coefficient(function, order, arcs):
    """Harmonic of a function that is smooth on each arc: (1 or 2) / 2 pi times its integral with exp(-i m theta)."""
    total = 0j
    for start, end, level in arcs:
        for part, unit in ((np.cos, 1), (np.sin, -1j)):
            value, _ = quad(
                lambda x, p=part, lv=level, s=start: function(x, lv, s) * p(order * x), start, end, limit=200
            )
            total += unit * value
    return total / np.pi if order else total / TURN


@pytest.mark.parametrize("order", [0, 1, 2, 3, 7, 30])
def test_harmonics_of_the_open_centre_are_its_fourier_integrals(order):
    """Oracle: scipy.integrate.quad over the arcs between the edges."""
    total = open_harmonics(MODEL, 40).sum(axis=0)
    assert total[order] == pytest.approx(
        _coefficient(lambda x, level, start: level, order, _arcs(_angles())), abs=1e-10
    )


def test_an_edge_seen_later_is_an_edge_further_on():
    """Oracle: the wheel cut anew; reading a delay later is an edge at alpha - omega delay, edge by edge."""
    delays = np.array([1e-3, -2e-3, 4e-3, 0.0])
    cut = wheel_model(
        tuple(np.array(EDGES) - OMEGA * delays), 0.27, opening_angle_rad=1.3, centre_angle_rad=float(np.radians(-91))
    )
    moved = open_harmonics(MODEL, 50) * later(OMEGA * delays, n_harmonics=50)
    np.testing.assert_allclose(moved[:, 1:], open_harmonics(cut, 50)[:, 1:], atol=1e-15)


def test_without_lag_an_even_opening_shows_the_exposed_fraction():
    """Oracle: `physics.wheel`, whose integrals know no harmonic; the mean over gamma divides harmonic m by its sinc."""
    n = 4096
    order = np.arange(n + 1)
    even = open_harmonics(MODEL, n).sum(axis=0) * np.sinc(order * MODEL.opening_angle_rad / TURN)
    theta = np.linspace(-3, 4, 500)
    np.testing.assert_allclose(at_angles(even, theta), exposed_fraction(theta, MODEL), atol=2e-4)


def test_reading_later_is_the_same_at_a_later_angle():
    """Oracle: the values at angles that much further on."""
    harmonics = open_harmonics(MODEL, 30)
    theta = np.linspace(0, 7, 40)
    turned = harmonics[:, None] * later(np.array([0.3, -2.0]), n_harmonics=30)
    assert turned.shape == (4, 2, 31)
    for k, phase in enumerate((0.3, -2.0)):
        np.testing.assert_allclose(at_angles(turned[:, k], theta), at_angles(harmonics, theta + phase), atol=1e-12)


def test_values_are_the_real_parts_of_the_sum():
    """Oracle: the definition, term by term."""
    rng = np.random.default_rng(1)
    harmonics = rng.normal(size=(2, 3, 7)) + 1j * rng.normal(size=(2, 3, 7))
    theta = rng.uniform(-9, 9, 11)
    expected = sum((harmonics[..., m, None] * np.exp(1j * m * theta)).real for m in range(7))
    np.testing.assert_allclose(at_angles(harmonics, theta), expected, atol=1e-12)


def test_the_width_of_the_opening_plays_no_part():
    """Oracle: another mask before the same wheel; its light is the business of the rows."""
    other = replace(MODEL, opening_angle_rad=0.2)
    np.testing.assert_array_equal(open_harmonics(MODEL, 9), open_harmonics(other, 9))


def test_no_delay_changes_nothing():
    """Oracle: the limit; all factors are one."""
    assert np.all(later(0.0, n_harmonics=9) == 1)
