"""The expected level, learned from sample frames of which up to two in five lie."""

import numpy as np
import pytest

from irtiming.reduce.opening import expected_level

TURN = 2 * np.pi


def _triangle(angle):
    """From 0, covered, to -1000, open, twice a turn, with rounded corners and the second peak a little lower."""
    phase = np.mod(angle, np.pi) / np.pi
    wave = np.clip(1.15 * np.abs(2 * phase - 1) - 0.075, 0, 1)
    return -1000 * wave + 8 * np.cos(angle)


def _scouts(seed, n=240):
    rng = np.random.default_rng(seed)
    return rng.uniform(0, TURN, n), np.sort(rng.random(n)), rng


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("share", [0.0, 0.2, 0.4])
@pytest.mark.parametrize("level", [0.0, -480.0, -1000.0, 400.0])
def test_lies_are_seen_through(seed, share, level):
    """Oracle: the curve that the good frames follow; the others show one level, as a closed shutter does."""
    angle, place, rng = _scouts(seed)
    values = _triangle(angle) + rng.normal(0, 3, angle.size)
    lies = np.zeros(angle.size, bool)
    lies[rng.choice(angle.size, round(share * angle.size), replace=False)] = True
    values[lies] = level + rng.normal(0, 3, lies.sum())
    found = expected_level.learn(angle, place, level_dn=values)
    grid = TURN * np.arange(500) / 500
    np.testing.assert_allclose(found.at(grid, np.full(500, 0.5)), _triangle(grid), atol=25)
    far = np.abs(values - _triangle(angle)) > 80
    assert not found.good[far].any()
    assert found.good[~lies].mean() > 0.97


def test_frozen_frames_are_seen_through():
    """Oracle: the curve; three in ten frames show the level of another angle."""
    angle, place, rng = _scouts(11)
    values = _triangle(angle) + rng.normal(0, 3, angle.size)
    frozen = rng.choice(angle.size, 72, replace=False)
    values[frozen] = _triangle(rng.uniform(0, TURN, 72))
    found = expected_level.learn(angle, place, level_dn=values)
    grid = TURN * np.arange(500) / 500
    np.testing.assert_allclose(found.at(grid, np.full(500, 0.5)), _triangle(grid), atol=25)


def test_a_slow_change_is_followed():
    """Oracle: the curve with a straight line over the recording."""
    angle, place, rng = _scouts(3)
    values = _triangle(angle) + 60 * (place - 0.5) + rng.normal(0, 1, angle.size)
    found = expected_level.learn(angle, place, level_dn=values)
    assert found.good.mean() > 0.95
    assert found.at(np.array([1.0, 1.0]), np.array([0.0, 1.0])) @ [-1, 1] == pytest.approx(60, abs=3)
    assert (found.low_dn, found.high_dn) == pytest.approx((-1000, 4), abs=15)


def test_how_long_a_level_stands_still():
    """Oracle: by hand; the plateaus of the triangle last 0.13 of half a turn, and 2 x 50 of 1000 DN take 0.043 on each side."""
    angle, place, _ = _scouts(5, n=1000)
    found = expected_level.learn(angle, place, level_dn=_triangle(angle) - 8 * np.cos(angle))
    expected = np.pi * (0.075 / 1.15 + 0.1 / 1.15)
    assert found.longest_level_rad(50.0) == pytest.approx(expected, abs=0.06)
    assert found.longest_level_rad(2000.0) == pytest.approx(TURN)


def test_the_scatter_is_that_of_the_noise_though_few_frames_are_fitted():
    """Oracle: the noise that was drawn, 30 DN; of 20 draws of 100 frames, of which a third goes into the curve."""
    found = []
    for seed in range(20):
        angle, place, rng = _scouts(seed, n=100)
        values = _triangle(angle) + rng.normal(0, 30, angle.size)
        found.append(expected_level.learn(angle, place, level_dn=values).scatter_dn)
    assert np.mean(found) == pytest.approx(30, rel=0.1)


def test_the_wave_that_most_frames_confirm_is_of_the_second_order():
    """Oracle: by hand; a wave twice a turn at some phase, which frames follow exactly, three in ten of them 600 DN aside."""
    angle, _, rng = _scouts(7, n=200)
    aside = np.where(rng.permutation(200) < 60, 600.0, 0.0)
    beside = expected_level._consensus(angle, 300 * np.cos(2 * angle - 0.8) + 40 + aside)
    np.testing.assert_allclose(beside, aside, atol=1e-6)
