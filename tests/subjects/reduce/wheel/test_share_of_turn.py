"""How much of the turn each frame stands for, by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.reduce.wheel.nominal_angles import samples_per_turn, share_of_turn

TURN = 2 * np.pi


def test_frames_stand_for_what_lies_half_way_to_their_neighbours():
    """Oracle: by hand; of ten angles 0, 1, 2 and 5 were seen: 2.5 + 0.5, 1, 0.5 + 1.5 and 1.5 + 2.5 tenths of a turn."""
    angle = TURN * np.array([0, 1, 2, 5]) / 10
    np.testing.assert_allclose(share_of_turn(angle, 10), np.array([3, 1, 2, 4]) / 10 * 4)


def test_frames_at_one_angle_share_it_and_one_without_angle_has_none():
    """Oracle: by hand; the angle 2 was seen twice, a turn apart and a little beside it; what all stand for is their number."""
    angle = np.append(TURN * np.array([0, 1, 2.2, 5, 11.8]) / 10, np.nan)
    found = share_of_turn(angle, 10)
    expected = np.array([3 + 0, 1, 1, 4, 1]) / 10 * 5
    np.testing.assert_allclose(found, [*expected, 0])


def test_an_even_turn_has_even_shares():
    """Oracle: nothing lost; each frame stands for the same, whatever the order."""
    angle = TURN * np.random.default_rng(1).permutation(40) / 40
    np.testing.assert_allclose(share_of_turn(angle, 40), 1)


@pytest.mark.parametrize("n", [0, 1, 2])
def test_fewer_than_three_angles_are_taken_as_they_are(n):
    """Oracle: the limit in the module."""
    angle = np.append(TURN * np.arange(n) / 10, [np.nan])
    assert share_of_turn(angle, 10).tolist() == [1.0] * n + [0.0]


def test_the_mean_over_a_turn_is_right_where_frames_are_lost():
    """Oracle: the trapezoidal rule over a whole turn; a third of 300 frames is lost, a wave's mean comes back to a thousandth."""
    random = np.random.default_rng(2)
    kept = np.sort(random.choice(300, 200, replace=False))
    angle = TURN * kept / 300
    wave = 3 + np.cos(angle) + 0.5 * np.sin(2 * angle)
    edges = np.append(angle, angle[0] + TURN)
    trapezoid = np.sum((wave + np.roll(wave, -1)) / 2 * np.diff(edges)) / TURN
    share = share_of_turn(angle, 300)
    assert np.mean(share * wave) == pytest.approx(trapezoid, abs=1e-12)
    assert trapezoid == pytest.approx(3, abs=1e-3)


@pytest.mark.parametrize(("turn", "expected"), [(400, 400), (401, 100), (200, 200)])
def test_a_turn_has_four_angles_a_trigger_at_most(turn, expected):
    """Oracle: by hand; 100 triggers, a tick apart: up to 400 angles are a scheme, of more there is about one a trigger."""
    recording = SimpleNamespace(wheel_period_ticks=turn, camera_period_ticks=1, camera_trigger_ticks=np.arange(100))
    assert samples_per_turn(recording) == expected
