"""Plateaus of a trapezoid whose corners are known."""

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.reduce.published.plateaus import find, inside, normalise

TURN = 2 * np.pi
CORNERS = np.radians([37.5, 112.5, 127.5, 202.5, 217.5, 292.5, 307.5, 382.5])
LEVELS = [0, 1, 1, 0, 0, 1, 1, 0]


def _trapezoid(angle, shift, corners=CORNERS):
    """Fraction over angle: straight lines between the corners, shifted and repeated each turn."""
    at = np.concatenate([corners - TURN, corners, corners + TURN])
    return np.interp(np.mod(angle - shift - corners[0], TURN) + corners[0], at, LEVELS * 3)


def _angles(n=1000):
    return TURN * (np.arange(n) + 0.3) / n


@pytest.mark.parametrize("shift", np.linspace(0, TURN, 41))
@pytest.mark.parametrize(("low", "step"), [(0.0, 1.0), (30_000.0, 2500.0), (9e6, -4e5)])
def test_plateaus_lie_between_the_corners_wherever_the_curve_is(shift, low, step):
    """Oracle: the corners that made the curve; 15 % of each plateau stay off at both ends; levels turn with the step."""
    angle = np.random.default_rng(0).permutation(_angles())
    found = find(angle, low + step * _trapezoid(angle, shift), name="x")
    assert len(found) == 4
    ends = np.sort(np.mod(CORNERS[1::2] + shift, TURN))
    starts = np.sort([p[0] for p in found])
    np.testing.assert_allclose(starts, np.sort(np.mod(CORNERS[1::2] + shift + 0.15 * np.radians(15), TURN)), atol=5e-3)
    assert ends.size == 4
    for lower, upper, level in found:
        assert 0 <= lower < TURN
        assert upper - lower == pytest.approx(0.7 * np.radians(15), abs=5e-3)
        middle = _trapezoid(np.array([lower, upper]), shift)
        np.testing.assert_allclose(middle, level if step > 0 else 1 - level, atol=1e-9)


@pytest.mark.parametrize("shift", [0.0, 1.1, 5.9])
def test_normalised_values_are_the_fraction(shift):
    """Oracle: the curve before it was scaled."""
    angle = _angles()
    value = 1200 + 345 * _trapezoid(angle, shift)
    found = find(angle, value, name="x")
    np.testing.assert_allclose(normalise(angle, value, plateaus=found), _trapezoid(angle, shift), atol=1e-9)


def test_noise_and_single_wild_frames_move_no_plateau():
    """Oracle: the corners that made the curve; 2 % noise, six frames at any level, on slopes too."""
    rng = np.random.default_rng(2)
    angle = _angles()
    value = _trapezoid(angle, 0.7) + rng.normal(0, 0.02, angle.size)
    value[[130, 250, 251, 400, 600, 880]] = [1.0, 0.0, 1.0, 0.5, 0.0, 0.4]
    found = find(angle, value, name="x")
    assert len(found) == 4
    for lower, upper, level in found:
        np.testing.assert_allclose(_trapezoid(np.linspace(lower, upper, 9), 0.7), level, atol=1e-9)


@pytest.mark.parametrize(("n", "noise", "jump"), [(40_000, 0.01, 0.0), (4000, 1e-3, 0.02)])
def test_many_frames_of_nearly_one_angle_make_no_further_slope(n, noise, jump):
    """Oracle: the corners that made the curve; neighbours differ by less than they scatter, or than levels jumped meanwhile."""
    rng = np.random.default_rng(4)
    angle = TURN * rng.random(n)
    found = find(angle, _trapezoid(angle, 0.4) + jump * (np.arange(n) > n / 3) + rng.normal(0, noise, n), name="x")
    starts = np.sort([p[0] for p in found])
    true = np.sort(np.mod(CORNERS[1::2] + 0.4 + 0.15 * np.radians(15), TURN))
    np.testing.assert_allclose(starts, true, atol=0.02)


def test_inside_goes_around_the_turn():
    """Oracle: by hand; a plateau from 350 to 370 deg."""
    plateau = (np.radians(350), np.radians(370), 1)
    angles = np.radians([349, 351, 359, 0, 5, 9, 11, 180])
    assert inside(angles, plateau).tolist() == [False, True, True, True, True, True, False, False]


def test_mask_as_wide_as_the_cutout_is_refused():
    """Oracle: by hand; a triangle wave has corners but no plateau between them."""
    corners = np.radians([0, 90, 90, 180, 180, 270, 270, 360]) + np.array([0, -1, 1, -1, 1, -1, 1, -1]) * 1e-3
    value = _trapezoid(_angles(), 0.2, corners)
    with pytest.raises(ReductionError, match=r"film: no plateau between .* at least 2.6 deg are needed; use a narr"):
        find(_angles(), value, name="film")


@pytest.mark.parametrize("part", [slice(0, 300), slice(200, 700)])
def test_part_of_a_turn_is_refused(part):
    """Oracle: by hand; a third or half a turn does not hold four slopes."""
    angle = _angles()[part]
    with pytest.raises(
        ReductionError, match=r"falling slopes over one turn, 2 of each must be there; the recording must"
    ):
        find(angle, _trapezoid(angle, 0.0), name="film")


def test_pure_noise_and_constant_are_refused():
    """Oracle: by hand; neither has slopes."""
    noise = np.random.default_rng(3).normal(0, 1, 1000)
    for value in (noise, np.full(1000, 7.0)):
        with pytest.raises(ReductionError, match=r"slopes over one turn"):
            find(_angles(), value, name="film")


@pytest.mark.parametrize(("n", "is_found"), [(40, True), (32, False)])
def test_five_points_make_a_slope(n, is_found):
    """Oracle: by hand; the middle 45 degrees of each slope hold 5 of 40 points in a turn, and 4 of 32."""
    angle = _angles(n)
    if is_found:
        assert [level for *_, level in find(angle, _trapezoid(angle, 0.0), name="film")] == [1, 0, 1, 0]
        return
    with pytest.raises(ReductionError, match="found 0 rising and 0 falling slopes"):
        find(angle, _trapezoid(angle, 0.0), name="film")
