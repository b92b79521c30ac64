"""Slow drift beside what the wheel does."""

import numpy as np
import pytest

from irtiming.reduce import drift

TURN = 2 * np.pi
_N = 1000
_TIME_S = 0.033 * np.arange(_N)
_ANGLE = TURN * 99 * np.arange(_N) / 1000


def _fit(level, *, segment=None, seed=0, noise=0.1, **options):
    values = level + np.random.default_rng(seed).normal(0, noise, _N)
    segment = np.zeros(_N, int) if segment is None else segment
    return drift.fit(values, _TIME_S, wheel_angle_rad=_ANGLE, segment=segment, **options)


@pytest.mark.parametrize(
    "curve",
    [0 * _TIME_S, 3.0 * _TIME_S, 80 * np.exp(-_TIME_S / 8), 0.1 * _TIME_S**2, 10 * np.sin(_TIME_S / 5)],
    ids=["none", "line", "exponential", "parabola", "wave"],
)
def test_a_curve_is_followed(curve):
    """Oracle: the curve itself, less its mean; the noise is 0.1 DN."""
    found = _fit(500 + curve)
    np.testing.assert_allclose(found.level_dn, curve - curve.mean(), atol=0.12)
    np.testing.assert_allclose(found.jump_dn, 0, atol=1e-9)


def test_a_line_stays_a_line():
    """Oracle: noise about a straight line; the criterion must not take waves for drift."""
    for seed in range(10):
        found = _fit(2.0 * _TIME_S, seed=seed)
        assert np.abs(np.diff(found.level_dn, 2)).max() < 1e-9


@pytest.mark.parametrize("order", [1, 2, 10, 20])
def test_what_the_wheel_does_is_no_drift(order):
    """Oracle: a harmonic of the wheel, 50 times the noise; order 10 beats in 100 frames."""
    found = _fit(2.0 * _TIME_S + 5 * np.cos(order * _ANGLE + 1))
    np.testing.assert_allclose(found.level_dn, 2.0 * (_TIME_S - _TIME_S.mean()), atol=0.05)


def test_segments_have_levels_of_their_own():
    """Oracle: the jumps that were made, on a bent curve."""
    segment = np.repeat([0, 1, 2], [300, 450, 250])
    jump = np.array([0.0, 12.0, -7.0])[segment]
    curve = 30 * np.exp(-_TIME_S / 10)
    found = _fit(curve + jump, segment=segment)
    np.testing.assert_allclose(found.level_dn, curve + jump - np.mean(curve + jump), atol=0.15)
    np.testing.assert_allclose(found.jump_dn, jump - jump.mean(), atol=0.3)


def test_wild_frames_do_not_bend_it():
    """Oracle: the same line without them."""
    level = 2.0 * _TIME_S
    level[::50] += 300
    np.testing.assert_allclose(_fit(level).level_dn, 2.0 * (_TIME_S - _TIME_S.mean()), atol=0.1)


def test_straight_means_straight():
    """Oracle: the least-squares line of a parabola over whole turns; a wave of the wheel leaves it alone."""
    parabola = 0.05 * (_TIME_S - 3) ** 2
    found = _fit(parabola + 40 * np.sin(2 * _ANGLE), noise=0, straight=True)
    slope = np.polyfit(_TIME_S, parabola, 1)[0]
    assert np.abs(np.diff(found.level_dn, 2)).max() < 1e-9
    assert np.diff(found.level_dn)[0] / 0.033 == pytest.approx(slope, rel=0.05)


def test_a_constant_level_has_no_drift():
    """Oracle: by hand; no noise at all, and all frames at one instant."""
    np.testing.assert_allclose(_fit(np.full(_N, 7.0), noise=0).level_dn, 0, atol=1e-9)
    flat = drift.fit(np.ones(200), np.zeros(200), wheel_angle_rad=_ANGLE[:200], segment=np.zeros(200, int))
    np.testing.assert_allclose(flat.level_dn, 0, atol=1e-6)


def test_a_drift_that_the_wheel_could_make_is_told_from_a_still_level():
    """Oracle: the drift that was added. 167 of 1000 samples a frame: order 6 of the wheel beats twice a run, like the drift."""
    frame = np.arange(1000)
    angle = TURN * 167 * frame / 1000
    true = 25 * np.exp(-frame / 300)
    level = true + 0.04 * np.random.default_rng(5).standard_normal(1000)
    segment = np.zeros(1000, np.int64)
    still = drift.fit(level, frame / 30, wheel_angle_rad=None, segment=segment)
    np.testing.assert_allclose(still.level_dn, true - true.mean(), atol=0.05)
    turning = drift.fit(level, frame / 30, wheel_angle_rad=angle, segment=segment)
    assert np.std(turning.level_dn - true) > 10 * np.std(still.level_dn - true)


def test_a_short_recording_is_followed_by_up_to_a_quarter_as_many_numbers():
    """Oracle: the curve itself; a swing in 40 levels over a minute takes more than the five numbers of a bent line."""
    time_s = np.linspace(0, 60, 40)
    wave = 20 * np.sin(TURN * time_s / 80)
    level = 7 + wave + np.random.default_rng(2).normal(0, 0.1, 40)
    found = drift.fit(level, time_s, wheel_angle_rad=None, segment=np.zeros(40, np.int64))
    np.testing.assert_allclose(found.level_dn, wave - wave.mean(), atol=0.5)


@pytest.mark.parametrize(("n", "is_followed"), [(250, False), (330, True)])
def test_waves_of_the_wheel_count_among_the_numbers(n, is_followed):
    """Oracle: by hand; thirty waves are sixty numbers, with them a bend takes 65: of 250 levels a quarter are 62, of 330, 82."""
    time_s = np.linspace(0, 60, n)
    bend = 0.05 * (time_s - 30) ** 2
    angle = TURN * 0.1234 * np.arange(n)
    found = drift.fit(7 + bend, time_s, wheel_angle_rad=angle, segment=np.zeros(n, np.int64))
    left = np.ptp(found.level_dn - bend)
    assert (left < 1.0) == is_followed
    assert left < 1.0 or left == pytest.approx(np.ptp(bend), rel=0.3)
