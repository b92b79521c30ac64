"""Schatz 2023, section 3.2.4: the microbolometer camera, its settings and its three parameters."""

import numpy as np
import pytest

from irtiming.estimate.published import lag_simulation, row_delay_and_lag, slope_distance
from irtiming.physics.wheel import wheel_model
from irtiming.records.lag_estimate import WheelInImage

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
    """Oracle: "ten simulation steps", "initialised to 0.5", two turns run-in and a third, "between 0.2 and 0.8", three times."""
    assert lag_simulation.STEPS_PER_SAMPLE == 10
    assert lag_simulation.START == 0.5
    assert lag_simulation.TURNS == 3
    assert slope_distance.LIMITS == (0.2, 0.8)
    assert row_delay_and_lag.ROUNDS == 3


def test_the_mask_has_193_rows(published):
    """Oracle: "193 sets for the individual pixel rows within the cutout"."""
    assert published.row_px.size == 193
    assert published.simulated_row_fraction.shape == (193, 1000)


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
