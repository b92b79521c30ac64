"""The exposed fraction in closed form against counting of points, finite differences and corners computed by hand."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from irtiming.errors import GeometryError
from irtiming.physics.wheel import (
    EDGE_SIGNS,
    at_point,
    corner_angles_rad,
    edge_in_opening,
    exposed_fraction,
    fading_fraction,
    slope_centres_rad,
    summed_points,
    wheel_model,
)

TURN = 2 * np.pi
EDGES = (0.0, 1.571755105, 3.142105320, 4.712485078)
UNEQUAL = (0.0, 1.62, 3.2, 4.65)
MODELS = [
    wheel_model(EDGES, 0.2682, opening_angle_rad=radians(75), centre_angle_rad=radians(-90)),
    wheel_model(UNEQUAL, -0.1, opening_angle_rad=1.2, centre_angle_rad=2.7),
    wheel_model(UNEQUAL, 0.3, opening_angle_rad=0.2, centre_angle_rad=-3.1, rotation="counterclockwise"),
]


def _points_seen(theta, model, n=20_000):
    """Share of n points spread over the opening that see the blackbody; conventions.md, rule for one point."""
    phi = model.centre_angle_rad + model.opening_angle_rad * ((np.arange(n) + 0.5) / n - 0.5)
    _, alpha_1, alpha_2, alpha_3 = model.cutout_edges_rad
    alpha = np.mod(model.gate_angle_rad + theta - phi, TURN)
    return np.mean(((alpha >= alpha_1) & (alpha < alpha_2)) | (alpha >= alpha_3))


@pytest.mark.parametrize("model", MODELS)
def test_fraction_of_an_instant_is_the_share_of_points_in_a_cutout(model):
    """Oracle: 20 000 points over the opening, each asked for its own wheel coordinate."""
    angles = np.random.default_rng(1).uniform(-20, 20, 200)
    counted = np.array([_points_seen(theta, model) for theta in angles])
    np.testing.assert_allclose(exposed_fraction(angles, model), counted, atol=1.1 / 20_000 * 2)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("sweep", [1e-3, 4.71e-3, 0.3, 2.0])
def test_fraction_of_a_window_is_the_mean_of_many_instants(model, sweep):
    """Oracle: midpoint rule over 4000 instants of the window (eq. 1)."""
    angles = np.random.default_rng(2).uniform(0, TURN, 100)
    instants = (np.arange(4000) + 0.5) / 4000 * sweep
    mean = exposed_fraction(angles[:, None] + instants, model).mean(axis=1)
    assert np.ptp(mean) > 0.3
    np.testing.assert_allclose(exposed_fraction(angles, model, sweep_rad=sweep), mean, atol=2e-7 * max(1, sweep))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("fades", [1e-3, 0.02, 0.4])
def test_fraction_that_fades_is_the_weighted_mean_of_many_instants(model, fades):
    """Oracle: midpoint rule over equal shares of the weight exp(-x / b) / b."""
    angles = np.random.default_rng(2).uniform(-TURN, TURN, 100)
    instants = -fades * np.log((np.arange(20_000) + 0.5) / 20_000)
    mean = exposed_fraction(angles[:, None] + instants, model).mean(axis=1)
    np.testing.assert_allclose(fading_fraction(angles, model, fades_rad=fades), mean, atol=1e-4 * fades)


@pytest.mark.parametrize("sweep", [0.0, 4.71e-3])
def test_fraction_is_as_exact_after_many_turns_as_in_the_first(sweep):
    """Oracle: the same angles one turn and 20 000 turns earlier; a long recording counts its turns."""
    angles = np.linspace(0, TURN, 500)
    model = MODELS[0]
    first = exposed_fraction(angles, model, sweep_rad=sweep)
    late = exposed_fraction(angles + 20_000 * TURN, model, sweep_rad=sweep)
    np.testing.assert_allclose(late, first, atol=1e-9)
    crossing = edge_in_opening(angles, model, sweep_rad=sweep)
    np.testing.assert_allclose(edge_in_opening(angles + 20_000 * TURN, model, sweep_rad=sweep), crossing, atol=1e-7)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("edge", range(4))
def test_crossing_share_is_the_derivative_to_each_edge_angle(model, edge):
    """Oracle: central differences of the exposed fraction to one edge angle."""
    angles, sweep, step = np.random.default_rng(3).uniform(0, TURN, 300), 0.02, 1e-6

    def moved(by):
        edges = list(model.cutout_edges_rad)
        edges[edge] += by
        return exposed_fraction(angles, replace(model, cutout_edges_rad=tuple(edges)), sweep_rad=sweep)

    expected = -EDGE_SIGNS[edge] * edge_in_opening(angles, model, sweep_rad=sweep)[edge] / model.opening_angle_rad
    assert np.ptp(expected) > 0.1
    np.testing.assert_allclose((moved(step) - moved(-step)) / (2 * step), expected, atol=3e-4 / model.opening_angle_rad)


def test_derivatives_to_all_edges_add_up_to_the_derivative_to_the_wheel_angle():
    """Oracle: central differences; turning the wheel on is moving all four edges back."""
    angles, sweep, step = np.random.default_rng(4).uniform(0, TURN, 300), 0.02, 1e-6
    for model in MODELS:
        ahead, behind = (exposed_fraction(angles + s, model, sweep_rad=sweep) for s in (step, -step))
        total = np.array(EDGE_SIGNS) @ edge_in_opening(angles, model, sweep_rad=sweep) / model.opening_angle_rad
        np.testing.assert_allclose(total, (ahead - behind) / (2 * step), atol=3e-4 / model.opening_angle_rad)


def test_instant_crossing_is_one_inside_the_slope_and_zero_outside():
    """Oracle: the opening of 60 deg is at 90 deg; edge 0 enters it at 60 deg and leaves it at 120 deg of wheel angle."""
    model = wheel_model(
        tuple(np.radians([0, 90, 180, 270])), 0.0, opening_angle_rad=radians(60), centre_angle_rad=radians(0)
    )
    # alpha of the opening's centre is 90 deg + theta - 0: edge 0 (= 360 deg) is met at theta = 270 deg
    angles = np.radians([239, 241, 299, 301])
    assert edge_in_opening(angles, model)[0].tolist() == [0, 1, 1, 0]


def test_corners_of_figure_4b_by_hand():
    """Oracle: by hand. beta_1 = 15, phi_M = -90, gamma = 75 deg: alpha of the centre is 105 + 90 = 195 deg + theta.

    Edge 2 (180 deg) is in the middle at theta = -15 = 345 deg, edge 3 at 75, edge 0 at 165, edge 1 at 255 deg; each
    slope starts 37.5 deg before its middle. Edges 0 and 2 cover the opening, 1 and 3 uncover it.
    """
    model = wheel_model(
        tuple(np.radians([0, 90, 180, 270])), radians(15), opening_angle_rad=radians(75), centre_angle_rad=radians(-90)
    )
    np.testing.assert_allclose(np.degrees(slope_centres_rad(model)), [165, 255, 345, 75])
    np.testing.assert_allclose(
        np.degrees(corner_angles_rad(model)), [[127.5, 202.5], [217.5, 292.5], [307.5, 382.5], [37.5, 112.5]]
    )
    at = np.radians([112.5, 120, 127.5, 165, 202.5, 210, 217.5, 255, 292.5, 300, 307.5, 345, 22.5, 30, 37.5, 75])
    levels = [1, 1, 1, 0.5, 0, 0, 0, 0.5, 1, 1, 1, 0.5, 0, 0, 0, 0.5]
    np.testing.assert_allclose(exposed_fraction(at, model), levels, atol=1e-12)


def test_window_average_rounds_a_corner_by_a_parabola():
    """Oracle: by hand; a window that starts at the corner and sweeps s sees s^2 / 2 of light out of gamma s."""
    model = MODELS[0]
    sweep = 0.01
    foot = corner_angles_rad(model)[1, 0]
    rounded = exposed_fraction(np.array([foot - sweep, foot - sweep / 2, foot]), model, sweep_rad=sweep)
    gamma = model.opening_angle_rad
    np.testing.assert_allclose(rounded, [0, sweep / 8 / gamma, sweep / 2 / gamma], atol=1e-12)


def test_middle_of_a_slope_is_seen_half_a_window_earlier():
    """Oracle: on a straight slope the window's mean is the value at its middle."""
    for model in MODELS:
        at = slope_centres_rad(model) - 0.05 / 2
        np.testing.assert_allclose(exposed_fraction(at, model, sweep_rad=0.05), 0.5, atol=1e-12)


def test_counterclockwise_rotation_is_the_mirrored_drawing():
    """Oracle: every point mirrored about the vertical (phi -> 180 deg - phi) by hand, then counted."""
    gate, gamma, centre = 0.3, 0.9, 0.4
    model = wheel_model(UNEQUAL, gate, opening_angle_rad=gamma, centre_angle_rad=centre, rotation="counterclockwise")
    phi = centre + gamma * ((np.arange(20_000) + 0.5) / 20_000 - 0.5)
    for theta in np.linspace(0, TURN, 50):
        # the application gate lies at 90 - beta_1 seen from the other side, edges travel to smaller phi:
        # edge i is at phi = (90 deg - beta_1) - (theta - alpha_i)
        alpha = np.mod(theta + phi - (np.pi / 2 - gate), TURN)
        seen = np.mean(((alpha >= UNEQUAL[1]) & (alpha < UNEQUAL[2])) | (alpha >= UNEQUAL[3]))
        assert exposed_fraction(np.array(theta), model) == pytest.approx(seen, abs=2e-4)


def test_shapes_are_kept():
    """Oracle: the docstring; any shape in, the same shape out."""
    for sweep in (0.0, 0.1):
        assert np.shape(exposed_fraction(np.zeros((3, 5)), MODELS[0], sweep_rad=sweep)) == (3, 5)
        assert np.shape(exposed_fraction(np.float64(1.0), MODELS[0], sweep_rad=sweep)) == ()
        assert edge_in_opening(np.zeros(7), MODELS[0], sweep_rad=sweep).shape == (4, 7)


@pytest.mark.parametrize(
    ("edges", "opening_deg"),
    [((0, 90, 180, 270), 90), ((0, 90, 180, 270), 95), ((0, 70, 180, 270), 75), ((0, 90, 180, 290), 75)],
)
def test_opening_without_plateau_is_refused(edges, opening_deg):
    """Oracle: design.md; a plateau needs a cutout and a blade that are wider than the opening."""
    with pytest.raises(GeometryError, match=r"never wholly open or covered; use a narrower mask"):
        wheel_model(
            tuple(np.radians(edges)), 0.2, opening_angle_rad=radians(opening_deg), centre_angle_rad=radians(-90)
        )


@pytest.mark.parametrize("sweep", [1e-3, 0.3])
def test_a_point_is_as_open_and_as_far_behind_the_second_blade_as_many_instants_say(sweep):
    """Oracle: 20 000 instants of the window, each asked for the point: open after edges 1 and 3, the blade between 2 and 3."""
    alpha = np.random.default_rng(4).uniform(-2, 9, 200)
    found = at_point(alpha, UNEQUAL, sweep_rad=sweep)
    there = np.mod(alpha[:, None] + sweep * (np.arange(20_000) + 0.5) / 20_000, TURN)
    is_open = ((there >= UNEQUAL[1]) & (there < UNEQUAL[2])) | (there >= UNEQUAL[3])
    is_behind = (there >= UNEQUAL[2]) & (there < UNEQUAL[3])
    np.testing.assert_allclose(found.openness, is_open.mean(axis=1), atol=2e-4)
    np.testing.assert_allclose(found.behind_second_blade, is_behind.mean(axis=1), atol=2e-4)
    assert found.openness.min() == pytest.approx(0, abs=1e-12)
    assert found.openness.max() == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("sweep", [1e-4, 5e-3, 0.4, 2.9, 7.0])
@pytest.mark.parametrize(("n", "span"), [(1, 0.0), (60, 1.4), (60, 6.2), (40, 15.0)])
def test_points_that_are_summed_are_each_of_them_with_its_weight(sweep, n, span):
    """Oracle: each point by itself, times its weight; in any order, over more than a turn, and in windows that long too."""
    rng = np.random.default_rng(n)
    start, offset, weight = rng.uniform(-7, 14, 500), rng.uniform(-span / 2, span / 2, n), rng.standard_normal(n)
    found = summed_points(start, offset, weight=weight, edges=UNEQUAL, sweep_rad=sweep)
    each = at_point(start + offset[:, None], UNEQUAL, sweep_rad=sweep)
    for name in ("arc_rad", "ends_rad", "blade_arc_rad", "blade_ends_rad", "passed"):
        np.testing.assert_allclose(
            getattr(found, name), weight @ getattr(each, name), atol=1e-11 * max(1, np.abs(weight).sum()), err_msg=name
        )
