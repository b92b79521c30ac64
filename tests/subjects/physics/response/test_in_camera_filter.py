"""Oracles: the recursion frame by frame, derivatives by differences, limits, and numbers by hand."""

import numpy as np
import pytest

from irtiming.physics.response import in_camera_filter, pixel_memory

M = 12
TURN = 2 * np.pi
SCHEME_STEP = TURN * 3 / (49_152_000 / 1_622_016)


def _periodic(angle, harmonics):
    return (np.exp(1j * np.multiply.outer(angle, np.arange(M + 1))) @ harmonics).real


@pytest.fixture
def harmonics():
    """Of any periodic signal."""
    rng = np.random.default_rng(3)
    return rng.normal(size=M + 1) + 1j * rng.normal(size=M + 1)


@pytest.mark.parametrize("share", [0.0, 0.06, 0.3, 0.5, 0.9])
@pytest.mark.parametrize("step", [0.1, SCHEME_STEP, 2.5])
def test_the_factor_is_what_the_recursion_leaves(harmonics, share, step):
    """Oracle: y_n = (1 - k) x_n + k y_{n-1} frame by frame, long after its start."""
    angle = 0.7 + step * np.arange(600)
    seen = _periodic(angle, harmonics)
    given = seen.copy()
    for n in range(1, seen.size):
        given[n] = (1 - share) * seen[n] + share * given[n - 1]
    left = harmonics * in_camera_filter.transfer(step, share, n_harmonics=M)
    np.testing.assert_allclose(given[300:], _periodic(angle[300:], left), atol=1e-9)


@pytest.mark.parametrize("share", [0.0, 0.01, 0.5])
def test_the_memory_is_one_echo(harmonics, share):
    """Oracle: f_n = (1 - s) F_n + s F_{n-1} frame by frame."""
    angle = SCHEME_STEP * np.arange(50)
    seen = _periodic(angle, harmonics)
    given = (1 - share) * seen[1:] + share * seen[:-1]
    left = harmonics * pixel_memory.transfer(SCHEME_STEP, share, n_harmonics=M)
    np.testing.assert_allclose(given, _periodic(angle[1:], left), atol=1e-12)


@pytest.mark.parametrize("memory", [in_camera_filter, pixel_memory])
@pytest.mark.parametrize("share", [0.0, 0.06, 0.4])
def test_slopes_are_those_of_small_differences(memory, share):
    """Oracle: central differences."""
    h = 1e-6
    ahead, behind = (memory.transfer(SCHEME_STEP, share + sign * h, n_harmonics=M) for sign in (1, -1))
    found = memory.transfer_slope(SCHEME_STEP, share, n_harmonics=M)
    np.testing.assert_allclose(found, (ahead - behind) / (2 * h), atol=1e-8)


@pytest.mark.parametrize("memory", [in_camera_filter, pixel_memory])
def test_nothing_kept_changes_nothing_and_a_constant_scene_stays(memory):
    """Oracle: the limits share 0 and harmonic 0; a whole turn per frame, where all frames are alike."""
    np.testing.assert_array_equal(memory.transfer(SCHEME_STEP, 0.0, n_harmonics=M), 1)
    assert memory.transfer(SCHEME_STEP, 0.37, n_harmonics=M)[0] == pytest.approx(1, abs=1e-15)
    np.testing.assert_allclose(memory.transfer(TURN, 0.37, n_harmonics=M), 1, atol=1e-12)


def test_a_half_turn_per_frame_by_hand():
    """Oracle: by hand; the first harmonic alternates, so k = 0.2 leaves 0.8 / 1.2 of it, s = 0.2 leaves 0.6."""
    assert in_camera_filter.transfer(np.pi, 0.2, n_harmonics=1)[1] == pytest.approx(2 / 3)
    assert pixel_memory.transfer(np.pi, 0.2, n_harmonics=1)[1] == pytest.approx(0.6)


def test_the_filter_is_undone_between_frames_that_followed_each_other():
    """Oracle: the frames before the filter; of a frame after a lost one nothing is said."""
    rng = np.random.default_rng(5)
    seen = rng.normal(size=(40, 3))
    given = seen.copy()
    for n in range(1, 40):
        given[n] = 0.7 * seen[n] + 0.3 * given[n - 1]
    there = np.delete(np.arange(40), [7, 8, 20])
    follows = np.concatenate([[False], np.diff(there) == 1])
    found = in_camera_filter.undone(given[there], 0.3, follows=follows)
    np.testing.assert_allclose(found, seen[there[follows]], atol=1e-12)
    assert found.shape == (34, 3)


@pytest.mark.parametrize("share", [-0.3, 0.0, 0.2, 0.6])
def test_whole_turns_per_frame_say_nothing_of_the_filter(share):
    """Oracle: every frame sees what the frame before saw, so their mix is the same whatever the share."""
    for turns in (1, 3):
        np.testing.assert_allclose(in_camera_filter.transfer(2 * np.pi * turns, share, n_harmonics=6), 1, atol=1e-13)
        np.testing.assert_allclose(
            in_camera_filter.transfer_slope(2 * np.pi * turns, share, n_harmonics=6), 0, atol=1e-13
        )


@pytest.mark.parametrize("share", [-0.3, 0.05, 0.3, 0.6])
def test_a_small_step_is_a_delay_by_the_mean_age(share):
    """Oracle: the mean age summed over the frames that a frame holds; the turn of each harmonic by that many small steps."""
    ages = np.arange(400)
    assert in_camera_filter.mean_age(share) == pytest.approx(float(np.sum(ages * (1 - share) * share**ages)))
    step = 1e-4
    found = in_camera_filter.transfer(step, share, n_harmonics=4)
    np.testing.assert_allclose(np.angle(found), -step * in_camera_filter.mean_age(share) * np.arange(5), rtol=1e-5)
    np.testing.assert_allclose(np.abs(found), 1, atol=1e-5)
    small = (in_camera_filter.mean_age(share + 1e-6) - in_camera_filter.mean_age(share - 1e-6)) / 2e-6
    assert in_camera_filter.mean_age_slope(share) == pytest.approx(small, rel=1e-6)
