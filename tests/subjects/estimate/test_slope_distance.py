"""Distance of slopes: known shifts, points outside of the limits, and rows without slopes."""

import numpy as np
import pytest

from irtiming.estimate.published.slope_distance import slope_distances

TURN = 2 * np.pi


def _curve(angle):
    """Two trapezoids per turn with slopes of 75 degrees."""
    return np.clip(0.5 + 1.6 * np.arcsin(np.sin(2 * angle)) / np.pi, 0, 1)


@pytest.mark.parametrize("shift", [0.0, 0.01, -0.3, 0.7, -1.2])
@pytest.mark.parametrize("turned", [0.0, 0.4, 3.0])
def test_distance_is_the_shift(shift, turned):
    """Oracle: the same curve, shifted; slopes cross the end of the turn for some starts."""
    grid = TURN * np.arange(500) / 500
    angle = np.sort(np.random.default_rng(3).uniform(0, TURN, 480))
    distance, u = slope_distances(
        _curve(grid + turned)[None], _curve(angle + turned + shift)[None], wheel_angle_rad=angle
    )
    np.testing.assert_allclose(distance, shift, atol=1e-9)
    np.testing.assert_allclose(u, 0, atol=1e-8)


@pytest.mark.parametrize("first", [0.0, 1.0, 2.0])
def test_angles_that_were_lost_move_nothing(first):
    """Oracle: the same curve, shifted, of which an eighth of the turn was not recorded."""
    grid = TURN * np.arange(500) / 500
    angle = np.sort(np.mod(first + np.random.default_rng(3).uniform(0, TURN * 7 / 8, 480), TURN))
    distance, _ = slope_distances(_curve(grid)[None], _curve(angle + 0.5)[None], wheel_angle_rad=angle)
    np.testing.assert_allclose(distance, 0.5, atol=1e-9)


def test_noise_averages_out_as_its_uncertainty_says():
    """Oracle: 400 rows with noise of known size; the scatter of their distances is what each says of itself."""
    rng = np.random.default_rng(4)
    angle = TURN * (np.arange(1000) + 0.5) / 1000
    measured = _curve(angle + 0.05) + 0.01 * rng.standard_normal((400, 1000))
    simulated = np.tile(_curve(TURN * np.arange(1000) / 1000), (400, 1))
    distance, u = slope_distances(simulated, measured, wheel_angle_rad=angle)
    assert distance.mean() == pytest.approx(0.05, abs=4 * u[0] / 20)
    assert distance.std() == pytest.approx(u.mean(), rel=0.15)


def test_a_row_without_points_on_a_slope_has_no_distance():
    """Oracle: a row that stays at its plateaus."""
    grid = TURN * np.arange(200) / 200
    curve = _curve(grid)
    distance, u = slope_distances(
        np.stack([curve, curve]), np.stack([curve, curve > 0.5]).astype(float), wheel_angle_rad=grid
    )
    assert distance[0] == pytest.approx(0, abs=1e-12)
    assert np.isnan(distance[1])
    assert np.isnan(u[1])
