"""What a lag leaves of harmonics against exponentials, an integrator and differences."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from irtiming.physics.response.first_order_lag import transfer, transfer_slope
from irtiming.physics.wheel import wheel_model
from irtiming.physics.wheel_harmonics import at_angles, open_harmonics

TURN = 2 * np.pi
OMEGA = 3 * TURN
EDGES = (0.0, 1.61, 3.13, 4.75)
MODEL = wheel_model(EDGES, 0.27, opening_angle_rad=1.3, centre_angle_rad=float(np.radians(-91)))


def _arcs():
    """Wheel angles between which the opening's centre is open or not, and the level of each arc."""
    a, b, c, d = (edge - MODEL.opening_coordinate_rad for edge in EDGES)
    return ((a, b, 0.0), (b, c, 1.0), (c, d, 0.0), (d, a + TURN, 1.0))


def _coefficient(function, order):
    """Harmonic of a function that is smooth on each arc: (1 or 2) / 2 pi times its integral with exp(-i m theta)."""
    total = 0j
    for start, end, level in _arcs():
        for part, unit in ((np.cos, 1), (np.sin, -1j)):
            value, _ = quad(
                lambda x, p=part, lv=level, s=start: function(x, lv, s) * p(order * x), start, end, limit=200
            )
            total += unit * value
    return total / np.pi if order else total / TURN


@pytest.mark.parametrize("tau", [1e-4, 5e-3, 0.3])
@pytest.mark.parametrize("order", [0, 1, 2, 5, 20])
def test_lagged_harmonics_are_those_of_the_exponentials(tau, order):
    """Oracle: closed form; from each edge the pixel relaxes exponentially, and its turn ends where it began."""
    arcs, level = _arcs(), np.zeros(5)
    for _ in range(200):
        level[0] = level[4]
        for k, (start, end, target) in enumerate(arcs):
            level[k + 1] = target + (level[k] - target) * np.exp(-(end - start) / (OMEGA * tau))
    begin = {start: level[k] for k, (start, _, _) in enumerate(arcs)}

    def pixel(x, target, start):
        return target + (begin[start] - target) * np.exp(-(x - start) / (OMEGA * tau))

    lagged = open_harmonics(MODEL, 40).sum(axis=0) * transfer(OMEGA, tau, n_harmonics=40)
    assert lagged[order] == pytest.approx(_coefficient(pixel, order), abs=1e-9)


def test_any_periodic_scene_is_followed_as_an_integrator_follows_it():
    """Oracle: scipy.integrate.solve_ivp on tau dx/dt = s - x over twelve time constants and a turn."""
    rng = np.random.default_rng(3)
    tau, scene = 9e-3, (rng.normal(size=6) + 1j * rng.normal(size=6)) / np.arange(1, 7) ** 2
    lagged = scene * transfer(OMEGA, tau, n_harmonics=5)
    times = 12 * 9e-3 + np.linspace(0, 1 / 3, 50)
    found = solve_ivp(
        lambda t, x: (at_angles(scene, np.array([OMEGA * t]))[0] - x) / tau,
        (0, times[-1] + 1e-6), [2.0], t_eval=times, rtol=1e-10, atol=1e-12,
    )  # fmt: skip
    np.testing.assert_allclose(found.y[0], at_angles(lagged, OMEGA * times), atol=3e-5)


def test_no_lag_changes_nothing():
    """Oracle: the limit tau = 0; all factors are one."""
    assert np.all(transfer(OMEGA, 0.0, n_harmonics=9) == 1)
    np.testing.assert_allclose(transfer(OMEGA, 1e-9, n_harmonics=9), 1, atol=2e-7)


@pytest.mark.parametrize("tau", [0.0, 1e-4, 5e-3, 0.3])
def test_slope_is_that_of_differences(tau):
    """Oracle: central differences in tau."""
    ahead, behind = (transfer(OMEGA, tau + sign * 1e-6, n_harmonics=40) for sign in (1, -1))
    np.testing.assert_allclose(transfer_slope(OMEGA, tau, n_harmonics=40), (ahead - behind) / 2e-6, rtol=1e-6)
