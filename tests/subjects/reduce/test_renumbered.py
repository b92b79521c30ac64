"""Frames that belong to other triggers than their numbers say: light of a wheel made point by point, frames lost and won."""

import numpy as np
import pytest

from irtiming.reduce.renumbered import Shift, _joined, shifts

TURN, N = 2 * np.pi, 500


def _angle(step=49 / 500, n=N):
    return TURN * step * np.arange(n)


def _light(angle, *, noise=2e-3, seed=0):
    """Of 75 degrees behind two cutouts of a quarter turn, counted at 2000 places of the opening, behind a lag of 0.1 rad."""
    places = np.radians(75) * (np.arange(2000) / 2000 - 0.5) + 0.1
    open_ = np.mod(angle[:, None] - places, TURN / 2) < TURN / 4
    return open_.mean(axis=1) + np.random.default_rng(seed).normal(0, noise, angle.size)


def _counted(lost=(), twice=()):
    """Light of ``N`` triggers, of which some made no frame, and some two, in the order of the frames."""
    made = [k for k in range(N) if k not in lost for _ in range(1 + (k in twice))]
    return _light(_angle())[made], _angle()[: len(made)] if len(made) <= N else _angle(n=len(made))


@pytest.mark.parametrize(
    ("lost", "twice", "wanted"),
    [
        ({300}, set(), [(300, 499, 1)]),
        ({470}, set(), [(470, 499, 1)]),
        ({300, 301}, set(), [(300, 498, 2)]),
        (set(), {300}, [(301, 501, -1)]),
        ({300}, {400}, [(300, 400, 1)]),
    ],
    ids=["one lost", "one lost near the end", "two lost", "one twice", "one lost, one won"],
)
def test_frames_that_are_counted_on_are_found(lost, twice, wanted):
    """Oracle: the frames that were taken out or doubled; where a stretch begins is told to a block of 15."""
    found = shifts(*_counted(lost, twice))
    assert [one.by for one in found] == [by for *_, by in wanted]
    for one, (first, end, _) in zip(found, wanted, strict=True):
        assert abs(one.first_frame - first) <= 15
        assert abs(one.end_frame - end) <= 15


@pytest.mark.parametrize("step", [49 / 500, 0.1, 0.0663, 0.27, 0.3371])
def test_a_run_in_order_has_no_shift(step):
    """Oracle: nothing was changed; at any step of the wheel, with noise of up to a tenth of the contrast."""
    for seed, noise in enumerate((1e-4, 2e-3, 0.02, 0.1)):
        assert shifts(_light(_angle(step), noise=noise, seed=seed), _angle(step)) == ()


def test_a_wheel_that_goes_round_in_six_frames_and_a_little_has_no_shift():
    """Oracle: nothing was changed; blocks visit three places of the wave, which drift, and a level sways by a twentieth."""
    angle = _angle(1 / 6 + 1e-4)
    for seed, noise in enumerate((1e-4, 5e-4, 2e-3)):
        light = _light(angle, noise=noise, seed=seed)
        assert shifts(light, angle) == ()
        assert shifts(light * (1 + 0.05 * np.sin(np.arange(N) / 15)) + 0.05 * np.sin(np.arange(N) / 14), angle) == ()


def test_a_shutter_or_a_drift_is_no_shift():
    """Oracle: what was changed is not which trigger made a frame."""
    share = np.linspace(0, 1, N)
    for changed in (
        np.where((share > 0.4) & (share < 0.43), 0.0, _light(_angle())),
        _light(_angle()) * (1 - 0.5 * share) + share,
        _light(_angle()) + (share > 0.5),
    ):
        assert shifts(changed, _angle()) == ()


def test_where_the_wheel_turns_by_a_half_from_trigger_to_trigger_nothing_tells():
    """Oracle: by hand; half a turn looks like none."""
    angle = _angle(0.5 + 1e-4)
    light = np.where(np.arange(N) >= 250, np.roll(_light(angle), -1), _light(angle))
    assert shifts(light, angle) == ()


def test_few_frames_tell_nothing():
    """Oracle: the limit of the module; fewer than four blocks of 15."""
    assert shifts(_light(_angle(n=59)), _angle(n=59)) == ()


def test_a_run_of_a_few_frames_has_no_shift():
    """Oracle: by hand; fewer than a block of 15, and none of a known angle."""
    assert shifts(_light(_angle(n=7)), _angle(n=7)) == ()
    assert shifts(np.ones(40), np.full(40, np.nan)) == ()


def test_two_lost_are_not_three_won_where_half_a_turn_has_five_frames():
    """Oracle: by hand; two triggers on and three back show the same, and fewer frames are likelier lost than more."""
    angle = _angle(0.1)
    light = np.where(np.arange(N) >= 250, np.roll(_light(angle), -2), _light(angle))
    assert [one.by for one in shifts(light, angle)] == [2]


@pytest.mark.parametrize("k", [-4, -3, 3, 4])
def test_more_than_three_frames_lost_or_won_are_not_told(k):
    """Oracle: the limit of the module, alike on both sides; 0.07 turns a trigger, of which half a turn has no whole number."""
    angle = _angle(0.07)
    light = np.where(np.arange(N) >= 250, np.roll(_light(angle), -k), _light(angle))
    assert [one.by for one in shifts(light, angle)] == [k] * (abs(k) <= 3)


def test_three_blocks_in_a_row_make_a_stretch_from_the_first_frame_to_the_last():
    """Oracle: by hand; blocks of three frames, each a frame after the one before; two in a row or an uncertain one are none."""
    blocks = 10 + np.arange(11)[:, None] + np.arange(3)
    by = [0, 2, 2, 2, 2, None, 1, 1, -1, -1, -1]
    expected = (Shift(first_frame=11, end_frame=17, by=2), Shift(first_frame=18, end_frame=23, by=-1))
    assert _joined(by, blocks) == expected
