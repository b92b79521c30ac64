"""Laws of the exposed fraction that hold for every wheel and every opening."""

from dataclasses import replace

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from irtiming.physics.wheel import edge_in_opening, exposed_fraction, slope_centres_rad
from irtiming.records.wheel_geometry import WheelModel

TURN = 2 * np.pi
_ANGLES = st.floats(-50, 50)


@st.composite
def _models(draw):
    """Any ascending edges, any opening narrower than a turn: the formula needs no plateau."""
    edges = sorted(draw(st.lists(st.floats(0, TURN), min_size=4, max_size=4)))
    return WheelModel(
        cutout_edges_rad=tuple(edges),
        gate_angle_rad=draw(st.floats(-7, 7)),
        opening_angle_rad=draw(st.floats(0.01, 6.2)),
        centre_angle_rad=draw(st.floats(-7, 7)),
    )


_SWEEPS = st.one_of(st.just(0.0), st.floats(1e-3, 8))


@given(_models(), _ANGLES, _SWEEPS)
def test_fraction_lies_between_covered_and_open(model, theta, sweep):
    """Oracle: a share of an area."""
    assert -1e-9 <= exposed_fraction(np.array(theta), model, sweep_rad=sweep) <= 1 + 1e-9


@given(_models(), _ANGLES, _SWEEPS, st.integers(-5, 5))
def test_fraction_repeats_every_turn(model, theta, sweep, turns):
    """Oracle: a wheel turned by whole turns looks the same."""
    here, there = (exposed_fraction(np.array(a), model, sweep_rad=sweep) for a in (theta, theta + turns * TURN))
    assert abs(here - there) < 1e-9


@given(_models(), _ANGLES, _SWEEPS, st.floats(-3, 3))
def test_turning_the_wheel_is_moving_its_edges_back(model, theta, sweep, by):
    """Oracle: rotating all four edges by minus the angle is the same wheel; to rounding over a narrow opening and sweep."""
    moved = replace(model, cutout_edges_rad=tuple(e - by for e in model.cutout_edges_rad))
    turned = exposed_fraction(np.array(theta + by), model, sweep_rad=sweep)
    assert abs(turned - exposed_fraction(np.array(theta), moved, sweep_rad=sweep)) < 1e-8


@given(_models(), _ANGLES, _SWEEPS, st.floats(-3, 3))
def test_only_the_angle_between_gate_and_opening_matters(model, theta, sweep, by):
    """Oracle: turning the whole rig does not change what is seen; a camera roll common to both drops out."""
    rolled = replace(model, gate_angle_rad=model.gate_angle_rad + by, centre_angle_rad=model.centre_angle_rad + by)
    here, there = (exposed_fraction(np.array(theta), m, sweep_rad=sweep) for m in (model, rolled))
    assert abs(here - there) < 1e-9


@given(_models(), _SWEEPS)
def test_mean_over_a_turn_is_the_share_of_the_cutouts(model, sweep):
    """Oracle: the cutouts' angles over 2 pi; every point of the opening sees the blackbody for just that share."""
    _, a, b, c = model.cutout_edges_rad
    open_share = ((b - a) + (TURN - c) + model.cutout_edges_rad[0]) / TURN
    n = 4000
    mean = exposed_fraction(np.arange(n) * TURN / n, model, sweep_rad=sweep).mean()
    assert abs(mean - open_share) < 4 / (n * min(1, model.opening_angle_rad) * 100)


@given(_models(), _ANGLES, _SWEEPS)
def test_wheel_with_cutouts_and_blades_swapped_shows_the_complement(model, theta, sweep):
    """Oracle: what one wheel covers, the other uncovers."""
    a, b, c, d = model.cutout_edges_rad
    swapped = replace(model, cutout_edges_rad=(b, c, d, a + TURN))
    both = sum(exposed_fraction(np.array(theta), m, sweep_rad=sweep) for m in (model, swapped))
    assert abs(both - 1) < 1e-9


@given(_models(), _ANGLES, st.floats(1e-3, 4), st.floats(1e-3, 4))
def test_long_window_is_the_weighted_mean_of_its_two_parts(model, theta, first, second):
    """Oracle: the integral over a window is the sum of the integrals over its parts."""
    whole = exposed_fraction(np.array(theta), model, sweep_rad=first + second) * (first + second)
    parts = exposed_fraction(np.array(theta), model, sweep_rad=first) * first
    parts += exposed_fraction(np.array(theta + first), model, sweep_rad=second) * second
    assert abs(whole - parts) < 1e-9


@given(_models(), _ANGLES, st.floats(0.1, 0.9), _SWEEPS)
def test_opening_is_the_weighted_mean_of_its_two_halves(model, theta, share, sweep):
    """Oracle: light adds up; an opening cut along a radius sends as much as both parts."""
    gamma = model.opening_angle_rad
    low = model.centre_angle_rad - gamma / 2
    parts = [
        (gamma * share, low + gamma * share / 2),
        (gamma * (1 - share), low + gamma * share + gamma * (1 - share) / 2),
    ]
    total = sum(
        width
        * exposed_fraction(
            np.array(theta), replace(model, opening_angle_rad=width, centre_angle_rad=middle), sweep_rad=sweep
        )
        for width, middle in parts
    )
    assert abs(total - gamma * exposed_fraction(np.array(theta), model, sweep_rad=sweep)) < 1e-9


@given(_models(), _ANGLES, st.floats(1e-3, 1))
def test_fraction_changes_no_faster_than_the_wheel_turns(model, theta, by):
    """Oracle: an edge that turns by an angle sweeps at most that angle of the opening; four edges, four times."""
    here, there = (exposed_fraction(np.array(a), model) for a in (theta, theta + by))
    assert abs(here - there) <= 4 * by / model.opening_angle_rad + 1e-9


@settings(max_examples=50)
@given(_models(), _SWEEPS)
def test_each_edge_crosses_the_opening_for_its_share_of_the_turn(model, sweep):
    """Oracle: the opening's angle over 2 pi, whatever the window."""
    assume(model.opening_angle_rad < 6)
    n = 2000
    share = edge_in_opening(np.arange(n) * TURN / n, model, sweep_rad=sweep)
    np.testing.assert_allclose(share.mean(axis=1), model.opening_angle_rad / TURN, atol=2 / n)


@given(_models())
def test_slope_centres_put_each_edge_on_the_opening(model):
    """Oracle: the definition; at the centre of its slope, edge i has the polar angle of the opening's middle."""
    at = slope_centres_rad(model)
    polar = model.gate_angle_rad + at - np.asarray(model.cutout_edges_rad)
    assert np.all((at >= 0) & (at < TURN + 1e-12))
    np.testing.assert_allclose(np.angle(np.exp(1j * (polar - model.centre_angle_rad))), 0, atol=1e-9)
