"""What a window leaves of harmonics against numerical integration of equation (1) and differences."""

import numpy as np
import pytest
from scipy.integrate import quad

from irtiming.physics.response.integration_window import tail_delay_s, tail_variance_s2, tails, transfer, transfer_slope
from irtiming.physics.wheel import wheel_model
from irtiming.physics.wheel_harmonics import at_angles, later, open_harmonics
from irtiming.records.rig import Measured, WindowTail

TURN = 2 * np.pi
OMEGA = 3 * TURN
MODEL = wheel_model((0.0, 1.61, 3.13, 4.75), 0.27, opening_angle_rad=1.3, centre_angle_rad=float(np.radians(-91)))


@pytest.mark.parametrize("window", [1e-6, 250e-6, 8e-3, 0.1])
def test_any_periodic_scene_is_integrated_over_the_window(window):
    """Oracle: eq. 1 by scipy.integrate.quad, from the start of the window; a middle is half a window later."""
    rng = np.random.default_rng(4)
    scene = (rng.normal(size=8) + 1j * rng.normal(size=8)) / np.arange(1, 9)
    delay = 2e-3
    start_phase = OMEGA * (delay + window / 2)
    seen = scene * transfer(OMEGA, window, n_harmonics=7) * later(start_phase, n_harmonics=7)
    for trigger in (0.0, 0.07, 0.31):
        integral, _ = quad(
            lambda t: at_angles(scene, np.array([OMEGA * t]))[0],
            trigger + delay,
            trigger + delay + window,
            epsabs=1e-14,
        )
        assert at_angles(seen, np.array([OMEGA * trigger]))[0] == pytest.approx(integral / window, abs=1e-9)


def test_the_wheels_edges_become_ramps_as_long_as_the_window():
    """Oracle: eq. 1 of a step that passes the opening's centre: the part of the window after it, counted by hand."""
    window, n = 20e-3, 20_000
    seen = open_harmonics(MODEL, n).sum(axis=0) * transfer(OMEGA, window, n_harmonics=n)
    opens_rad = 1.61 - MODEL.opening_coordinate_rad
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        angle = opens_rad + OMEGA * window * (share - 0.5)
        assert at_angles(seen, np.array([angle]))[0] == pytest.approx(share, abs=2e-3)


def test_a_window_of_no_length_changes_nothing():
    """Oracle: the limit T -> 0 of eq. 1's mean is the scene itself; its slope there is 0, for the factor is even in T."""
    assert np.all(transfer(OMEGA, 0.0, n_harmonics=9) == 1)
    assert np.all(transfer_slope(OMEGA, 0.0, n_harmonics=9) == 0)


@pytest.mark.parametrize("window", [0.0, 1e-7, 1e-6, 1e-5, 250e-6, 8e-3, 0.1])
def test_slope_is_that_of_differences(window):
    """Oracle: central differences in T, on both sides of where the series takes over."""
    ahead, behind = (transfer(OMEGA, window + sign * 1e-6, n_harmonics=200) for sign in (1, -1))
    np.testing.assert_allclose(transfer_slope(OMEGA, window, n_harmonics=200), (ahead - behind) / 2e-6, atol=2e-4)


def test_slope_is_smooth_where_the_series_takes_over():
    """Oracle: x / 3 times the wave number to second order."""
    half = OMEGA / 2
    for x in (0.99e-3, 1.01e-3):
        assert transfer_slope(OMEGA, x / half, n_harmonics=1)[1].real == pytest.approx(-half * x / 3, rel=1e-6)


@pytest.mark.parametrize(("window", "fading"), [(250e-6, 0.2e-3), (8e-3, 1e-3)])
def test_what_comes_after_the_window_makes_it_later_and_longer(window, fading):
    """Oracle: moments of instants drawn evenly over the window and from an exponential after it, mixed by a small share."""
    evenly = (np.arange(100_000) + 0.5) / 100_000
    within, after = window * (evenly - 0.5), window / 2 - fading * np.log1p(-evenly)
    share = 1e-6
    mean = (1 - share) * within.mean() + share * after.mean()
    variance = (1 - share) * np.mean(within**2) + share * np.mean(after**2) - mean**2
    assert tail_delay_s(window, fading) == pytest.approx(mean / share, rel=1e-3)
    assert tail_variance_s2(window, fading) == pytest.approx((variance - within.var()) / share, rel=1e-3)


def test_parts_of_a_tail_make_up_the_whole():
    """Oracle: independent errors of the parts add up in squares to that of the whole, shares add up to its share."""
    whole = WindowTail(share=Measured(0.02, 0.004), time_constant_s=0.2e-3)
    parts = tails(whole).values()
    assert sum(one.share.value for one in parts) == pytest.approx(0.02)
    assert sum(one.share.standard_uncertainty**2 for one in parts) ** 0.5 == pytest.approx(0.004)
