"""Whether all parts of a run tell one story: light of a wheel that is made point by point, late from some frame on."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.records.rig import LightGates, MaskOpening, Measured, Rig
from irtiming.reduce import steadiness

TURN, HZ = 2 * np.pi, 3.0
RIG = Rig(
    light_gates=LightGates(half_separation_m=Measured(13e-3), height_difference_m=Measured(5e-3), whole_slots_between=9),
    mask_opening=MaskOpening(opening_angle_rad=Measured(1.3), centre_angle_rad=Measured(-1.57, 5e-4)),
)  # fmt: skip


def _angle(n=500):
    return TURN * 49 / 500 * np.arange(n)


def _light(angle, *, noise=1e-3, seed=0):
    """Of 75 degrees behind two cutouts of a quarter turn, counted at 2000 places of the opening."""
    places = np.radians(75) * (np.arange(2000) / 2000 - 0.5)
    open_ = np.mod(angle[:, None] - places, TURN / 2) < TURN / 4
    return open_.mean(axis=1) + np.random.default_rng(seed).normal(0, noise, angle.size)


def _found(light, angle):
    recording = SimpleNamespace(name="run", events=None, rotation_speed_hz=HZ)
    return steadiness.findings(SimpleNamespace(recording=recording, angle_rad=angle), RIG, light_dn=light)


@pytest.mark.parametrize("late_rad", [3e-3, -3e-3, 0.62])
def test_light_that_is_late_from_the_middle_on_is_measured(late_rad):
    """Oracle: the angle by which it was made late: 3 mrad, and one frame of a tenth of a turn."""
    angle = _angle()
    late = steadiness.lateness(_light(angle - late_rad * (np.arange(angle.size) >= 250)), angle)
    assert late.angle_rad[2:].mean() - late.angle_rad[:2].mean() == pytest.approx(late_rad, abs=6 * late.u_rad.max())
    assert late.u_rad.max() < 1.5e-3
    assert late.first_frame == (0, 125, 250, 375)


def test_late_light_is_a_doubt_that_says_how_much_and_from_where():
    """Oracle: by hand; 0.1 rad at 3 Hz is 5.31 ms, told to 0.05 ms."""
    angle = _angle()
    (one,) = _found(_light(angle - 0.1 * (np.arange(500) >= 250)), angle)
    assert (one.code, one.severity, one.recording) == ("run-not-steady", "doubt", "run")
    assert "the light follows the wheel 5.3" in one.what


def test_light_that_is_late_by_a_whole_frame_is_of_another_trigger():
    """Oracle: by hand; from frame 250 on each frame is that of the trigger after its own."""
    angle = _angle()
    light = np.where(np.arange(500) >= 250, np.roll(_light(angle), -1), _light(angle))
    (one,) = _found(light, angle)
    assert (one.code, one.severity, one.recording) == ("frames-renumbered", "doubt", "run")


@pytest.mark.parametrize(
    "changed",
    [
        lambda light, share: light,
        lambda light, share: light + 0.3 * share,
        lambda light, share: light * (1 - 0.3 * share),
        lambda light, share: np.where((share > 0.4) & (share < 0.42), 0.0, light),
        lambda light, share: light + 0.5 * (share > 0.5),
    ],
    ids=["nothing", "drift", "contrast", "shutter", "jump"],
)
def test_levels_that_change_are_no_lateness(changed):
    """Oracle: what was changed is when no edge passes."""
    for seed in range(20):
        light = changed(_light(_angle(), seed=seed), np.linspace(0, 1, 500))
        assert _found(light, _angle()) == ()


@pytest.mark.parametrize("late_rad", [0.0, 8e-3])
def test_a_closed_shutter_hides_nothing_and_is_no_lateness(late_rad):
    """Oracle: the angle by which it was made late; 7 of 507 frames are brighter than all others."""
    frames = np.arange(507)
    angle = TURN * 0.4773 * frames
    light = _light(angle - late_rad * (frames >= 254))
    light[105:112] = 2.2
    late = steadiness.lateness(light, angle)
    assert late.u_rad.max() < 1.5e-3
    assert late.angle_rad[2:].mean() - late.angle_rad[:2].mean() == pytest.approx(late_rad, abs=4 * late.u_rad.max())
    assert len(_found(light, angle)) == (late_rad > 0)


def test_less_than_the_mask_may_be_off_is_no_doubt():
    """Oracle: rig.toml; twice 0.5 mrad between two parts is as much as the whole run may be off."""
    angle = _angle()
    assert _found(_light(angle - 0.9e-3 * (np.arange(500) >= 250), noise=1e-5), angle) == ()


@pytest.mark.parametrize("step", [2 + 1 / 500, 1 - 1 / 500, 0.5 + 0.5 / 500, 0.25 + 0.25 / 500])
def test_a_run_that_visits_the_angles_once_has_no_parts(step):
    """Oracle: nothing was changed; each quarter sees other angles, of which a fit of waves makes anything."""
    angle = TURN * step * np.arange(500)
    assert steadiness.lateness(_light(angle), angle) is None
    assert _found(_light(angle), angle) == ()


def test_a_short_run_has_no_parts():
    """Oracle: by hand; ten waves of two numbers each, a level and a slope are 22, three frames for each, in four parts: 264."""
    assert steadiness.lateness(_light(_angle(263)), _angle(263)) is None
    assert steadiness.lateness(_light(_angle(264)), _angle(264)).first_frame == (0, 66, 132, 198)


def test_a_gain_that_sways_over_a_slow_pattern_of_angles_is_no_lateness():
    """Oracle: what sways is when no edge passes; 0.2526 turns a frame come back to an angle's neighbour after four frames."""
    frames = np.arange(1200)
    angle = TURN * 0.2526 * frames
    doubted = 0
    for seed in range(20):
        random = np.random.default_rng(seed)
        sway = sum(0.01 * np.sin(TURN * k * frames / 1200 + random.uniform(0, TURN)) for k in range(4, 16, 2))
        doubted += bool(_found(_light(angle, seed=seed) * (1 + sway), angle))
    assert doubted == 0


@pytest.mark.parametrize("step", [1 / 11 + 1.9e-4, 2 / 19 - 1.5e-4])
def test_cutouts_that_differ_are_no_lateness_where_their_waves_look_like_the_passing_one(step):
    """Oracle: nothing was changed; one cutout is 2 degrees wider. After 11 or 19 frames an odd wave looks like the second."""
    angle, places = TURN * step * np.arange(500), np.radians(50) * (np.arange(2000) / 2000 - 0.5)
    at = np.mod(angle[:, None] - places, TURN)
    light = ((at < TURN / 4 + np.radians(2)) | ((at >= TURN / 2) & (at < 3 * TURN / 4))).mean(axis=1)
    light += np.random.default_rng(3).normal(0, 1e-3, light.size)
    late = steadiness.lateness(light, angle)
    assert np.all(np.abs(late.angle_rad) < 2 * late.u_rad)
    assert np.all(late.u_rad < 1.5e-3)
    assert _found(light, angle) == ()


def test_frames_that_see_the_passing_wave_or_its_double_slowly_are_not_asked():
    """Oracle: by hand; 0.748 turns a frame are 2.992 double waves: one period in 125 frames, and three in 375."""
    angle = TURN * 0.748 * np.arange(1500)
    assert steadiness.lateness(_light(angle[:500]), angle[:500]) is None
    assert steadiness.lateness(_light(angle), angle).u_rad.max() < 1e-3


@pytest.mark.parametrize(("n_turns", "n_parts"), [(5.9, None), (6.1, 2), (9.1, 3), (12.1, 4), (81.3, 4)])
def test_a_part_has_three_turns_at_least(n_turns, n_parts):
    """Oracle: by hand; so many threes in the turns of the run, four at most, and a part alone has nothing to be late against."""
    angle = np.linspace(0.3, 0.3 + 2 * np.pi * n_turns, 400)
    light = np.cos(2 * angle) + np.random.default_rng(1).normal(0, 1e-3, 400)
    found = steadiness.lateness(light, angle)
    assert (found if found is None else found.angle_rad.size) == n_parts
