"""Openings that are brighter at one end, or at both, against counting of their light, instants of a window and differences."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.physics.light.bright_ends import bright_ends
from irtiming.physics.wheel import exposed_fraction, wheel_model

TURN = 2 * np.pi
MODEL = wheel_model((0.0, 1.571, 3.143, 4.711), 0.268, opening_angle_rad=np.radians(75), centre_angle_rad=-1.55)
UNEQUAL = (0.0, 1.62, 3.2, 4.65)
MODELS = [
    MODEL,
    wheel_model(UNEQUAL, -0.1, opening_angle_rad=1.2, centre_angle_rad=2.7),
    wheel_model(UNEQUAL, 0.3, opening_angle_rad=0.2, centre_angle_rad=-3.1, rotation="counterclockwise"),
]
ANGLES = np.radians([3.0, 40.0, 100.0, 170.0, 200.0, 261.0, 333.0])
U = (np.arange(200_000) + 0.5) / 100_000 - 1


def _open(theta, model, *, back_rad=0.0):
    """Which of 200 000 points over the opening are open."""
    edges = np.array(model.cutout_edges_rad)
    beside = np.mod(model.opening_coordinate_rad + theta + model.opening_angle_rad / 2 * U - back_rad, TURN)
    return ((beside >= edges[1]) & (beside < edges[2])) | (beside >= edges[3])


@pytest.mark.parametrize("theta", ANGLES)
def test_skewed_opening_against_counting_its_light(theta):
    """Oracle: brute force; light 1 + s u over 200 000 points, its centre moved back by s gamma / 6, less the even opening."""
    skew = 1e-3
    counted = float(np.mean((1 + skew * U) * _open(theta, MODEL, back_rad=skew * MODEL.opening_angle_rad / 6)))
    added = (counted - float(exposed_fraction(np.array(theta), MODEL))) / skew
    assert bright_ends(np.array([theta]), MODEL).skew == pytest.approx(added, abs=6e-3)


@pytest.mark.parametrize("theta", ANGLES)
def test_bowed_opening_against_counting_its_light(theta):
    """Oracle: brute force; light 1 + b (3 u^2 - 1) / 2 over 200 000 points, less the even opening."""
    counted = float(np.mean((3 * U**2 - 1) / 2 * _open(theta, MODEL)))
    assert bright_ends(np.array([theta]), MODEL).bow == pytest.approx(counted, abs=2e-5)


def test_both_on_a_slope_by_hand():
    """Oracle: by hand; where the falling edge of a cutout stands at u: (u^3 - u) / 4 and 1 / 6 - (1 - u^2) / 4, else 0."""
    u = np.linspace(-0.9, 0.9, 7)
    at_edge_0 = MODEL.cutout_edges_rad[0] - MODEL.opening_coordinate_rad - MODEL.opening_angle_rad / 2 * u
    found = bright_ends(at_edge_0, MODEL)
    np.testing.assert_allclose(found.bow, (u**3 - u) / 4, atol=1e-9)
    np.testing.assert_allclose(found.skew, 1 / 6 - (1 - u**2) / 4, atol=1e-9)
    plateau = bright_ends(at_edge_0[3] + np.radians([-45.0, 45.0]), MODEL)
    np.testing.assert_array_equal([plateau.bow, plateau.skew], np.zeros((2, 2)))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("sweep", [0.02, 0.15, 1.1])
def test_both_of_a_window_are_the_mean_of_many_instants(model, sweep):
    """Oracle: midpoint rule over 4000 instants of the window (eq. 1), corners and all; S jumps by a sixth at them."""
    angles = np.random.default_rng(5).uniform(-TURN, TURN, 200)
    moments = angles[:, None] + (np.arange(4000) + 0.5) / 4000 * sweep
    instants, found = bright_ends(moments.ravel(), model), bright_ends(angles, model, sweep_rad=sweep)
    np.testing.assert_allclose(found.skew, instants.skew.reshape(moments.shape).mean(axis=1), atol=2 / 6 / 4000)
    np.testing.assert_allclose(found.bow, instants.bow.reshape(moments.shape).mean(axis=1), atol=1e-6)
    assert np.ptp(found.skew) > 1e-3
    assert np.ptp(found.bow) > 1e-3


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("sweep", [0.005, 0.15, 0.5])
def test_slopes_are_those_of_differences(model, sweep):
    """Oracle: central differences, but where an edge stands at an end of the opening or of the window: there slopes jump."""
    start, step = np.random.default_rng(6).uniform(-TURN, TURN, 400), 1e-6
    wider, narrower = (
        bright_ends(start, replace(model, opening_angle_rad=model.opening_angle_rad + sign * step), sweep_rad=sweep)
        for sign in (1, -1)
    )
    longer, shorter = (bright_ends(start - sign * step / 2, model, sweep_rad=sweep + sign * step) for sign in (1, -1))
    found = bright_ends(start, model, sweep_rad=sweep)
    for slopes, name in ((found.skew_slopes, "skew"), (found.bow_slopes, "bow")):
        for slope, ahead, behind in ((slopes[0], wider, narrower), (slopes[1], longer, shorter)):
            numeric = (getattr(ahead, name) - getattr(behind, name)) / (2 * step)
            assert np.abs(numeric).max() > 1e-3
            assert np.quantile(np.abs(slope - numeric), 0.98) < 1e-6 * np.abs(numeric).max() + 1e-9


def test_the_shortest_window_is_an_instant():
    """Oracle: a law; what is seen in a window that vanishes is what an instant shows, and slopes stay finite."""
    angles = np.random.default_rng(7).uniform(0, TURN, 200)
    instant, short = bright_ends(angles, MODEL), bright_ends(angles, MODEL, sweep_rad=1e-7)
    np.testing.assert_allclose(short.skew, instant.skew, atol=1e-6)
    np.testing.assert_allclose(short.bow, instant.bow, atol=1e-6)
    assert np.all(np.isfinite([*instant.skew_slopes, *instant.bow_slopes]))
