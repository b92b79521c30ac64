"""Schatz 2023, section 3.2.4: the microbolometer camera, its settings and its three parameters."""

import numpy as np
import pytest

from irtiming.estimate.published import lag_simulation, row_delay_and_lag, slope_distance
from irtiming.physics.wheel import wheel_model
from irtiming.records.lag_estimate import LagTiming, WheelInImage

TURN = 2 * np.pi
GATE, EDGES, GAMMA = float(np.pi / 2 + 0.2682), (0.0, 1.5718, 3.1421, 4.7125), 5 / 12 * np.pi
MODEL = wheel_model(EDGES, GATE - np.pi / 2, opening_angle_rad=GAMMA, centre_angle_rad=-np.pi / 2)
TIMING_S = (3.872e-3, 38.76e-6, 4.819e-3)
INITIAL_ROW_DELAY_S = 1 / 60 / 480
CENTRE_PX = (249.0, 320.0)


@pytest.fixture(scope="module")
def published(lagging_rows):
    """The camera of the paper: 640 x 480 pixels, wheel fills the image, 1000 angles, noise of 21 runs."""
    row, column = np.mgrid[:480, :640]
    phi = np.arctan2(row - CENTRE_PX[0], column - CENTRE_PX[1])
    radius = np.hypot(row - CENTRE_PX[0], column - CENTRE_PX[1])
    mask = (np.abs(phi + np.pi / 2) < GAMMA / 2) & (radius > 46) & (radius < 230)
    data = lagging_rows(mask, CENTRE_PX, timing_s=TIMING_S, gate_rad=GATE, edges_rad=EDGES, noise=0.01)
    wheel = WheelInImage(row_px=CENTRE_PX[0], column_px=CENTRE_PX[1], roll_rad=0.0)
    return row_delay_and_lag.fit(data, MODEL, wheel=wheel, initial_row_delay_s=INITIAL_ROW_DELAY_S)


def test_settings_of_the_simulation_are_the_published_ones():
    """Oracle: "ten simulation steps", "initialised to 0.5", two turns run-in and a third: Runge and Kutta written out.

    A third of a turn is a long time constant, so that the start is still seen in the third turn.
    """
    mask = np.zeros((480, 640), bool)
    mask[100, 250:390] = True
    wheel = WheelInImage(row_px=CENTRE_PX[0], column_px=CENTRE_PX[1], roll_rad=0.0)
    pixels = lag_simulation.crossings(mask, MODEL, wheel=wheel)
    omega, tau, samples = TURN * 3, 0.1, 120
    timing = LagTiming(trigger_delay_s=0.0, row_delay_s=0.0, time_constant_s=tau)
    found = lag_simulation.simulate(pixels, timing, samples=samples, angular_frequency_rad_per_s=omega)
    phi = np.arctan2(100 - CENTRE_PX[0], np.arange(250, 390) - CENTRE_PX[1])

    def open_share(theta):
        alpha = np.mod(GATE + theta - phi, TURN)
        return np.mean(((alpha >= EDGES[1]) & (alpha < EDGES[2])) | (alpha >= EDGES[3]))

    step_s, value, seen = TURN / omega / samples / 10, 0.5, []
    for k in range(3 * samples * 10):
        if k >= 2 * samples * 10 and k % 10 == 0:
            seen.append(value)
        at = [open_share(omega * (k + part) * step_s) for part in (0, 0.5, 1)]
        k1 = (at[0] - value) / tau
        k2 = (at[1] - value - step_s / 2 * k1) / tau
        k3 = (at[1] - value - step_s / 2 * k2) / tau
        k4 = (at[2] - value - step_s * k3) / tau
        value += step_s / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    curve = np.array(seen)
    expected = np.polyval(np.polyfit(curve, found.row_fraction[0], 1), curve)  # normalised by its plateaus
    np.testing.assert_allclose(found.row_fraction[0], expected, atol=1e-9)


def test_fractions_between_0_2_and_0_8_are_compared_and_no_others():
    """Oracle: "between 0.2 and 0.8"; a curve 2 mrad late outside of them changes nothing, one within is 2 mrad late."""
    theta, late = TURN * (np.arange(1000) + 0.5) / 1000, 2e-3

    def curve(angle):
        return 0.5 - 0.75 * np.cos(2 * angle)

    values, moved = curve(theta), curve(theta - late)
    is_far = (values < 0.19) | (values > 0.81)
    here, far, near = (
        slope_distance.slope_distances(
            curve(TURN * np.arange(1000) / 1000)[None], measured[None], wheel_angle_rad=theta
        )[0][0]
        for measured in (values, np.where(is_far, moved, values), np.where(is_far, values, moved))
    )
    assert here == pytest.approx(0, abs=1e-5)
    assert far == pytest.approx(here, abs=1e-9)
    assert near == pytest.approx(-late, rel=0.02)


def test_every_row_of_the_mask_is_simulated(published):
    """Oracle: "193 sets for the individual pixel rows within the cutout", a thousand angles each."""
    assert published.row_px.size == 193
    assert published.simulated_row_fraction.shape == (193, 1000)
    assert np.all(np.diff(published.row_px) == 1)
    assert row_delay_and_lag.ROUNDS == 3  # "three times"


def test_search_starts_at_no_trigger_delay_and_the_shortest_row_delay(published):
    """Oracle: "initial trigger delay was set to zero, and the initial row delay, 1 / f_max / 480 was chosen"."""
    assert published.initial_timing.trigger_delay_s == 0
    assert published.initial_timing.row_delay_s == INITIAL_ROW_DELAY_S


def test_the_three_parameters_come_back(published):
    """Oracle: the printed 3.872 ms, 38.76 us and 4.819 ms, put into data in closed form."""
    timing = published.timing
    assert timing.time_constant_s == pytest.approx(TIMING_S[2], abs=30e-6)
    assert timing.trigger_delay_s == pytest.approx(TIMING_S[0], abs=30e-6)
    assert timing.row_delay_s == pytest.approx(TIMING_S[1], abs=0.1e-6)
    assert published.deviation_rms < 2e-3


def test_uncertainty_of_the_time_constant_is_an_underestimation(published):
    """Oracle: the paper says so of its own; noise alone was put into these data, and the result is off by more."""
    error = published.timing.time_constant_s - TIMING_S[2]
    assert 0 < published.u_timing.time_constant_s < 10e-6
    assert abs(error) > published.u_timing.time_constant_s


def test_parabola_has_its_minimum_at_the_time_constant(published):
    """Oracle: its coefficients; the minimum of p0 + p1 x + p2 x^2 is at -p1 / 2 p2."""
    p0, p1, p2 = published.parabola
    assert -p1 / (2 * p2) == pytest.approx(published.timing.time_constant_s, rel=1e-6)
    tau = published.time_constants_s
    np.testing.assert_allclose(np.diff(tau), tau[1] - tau[0], rtol=1e-9)
    np.testing.assert_allclose(p0 + p1 * tau + p2 * tau**2, published.rms, atol=1e-4)
