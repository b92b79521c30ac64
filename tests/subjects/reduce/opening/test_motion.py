"""Where the opening lies in the parts of a run: a soft opening that is moved by known amounts, each pixel covered in its time."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.records.rig import LightGates, MaskOpening, Measured, Rig
from irtiming.reduce.opening import motion

TURN = 2 * np.pi
N, ROWS, COLUMNS = 240, 50, 70
RIG = Rig(
    light_gates=LightGates(half_separation_m=Measured(13e-3), height_difference_m=Measured(5e-3), whole_slots_between=9),
    mask_opening=MaskOpening(opening_angle_rad=Measured(1.3), centre_angle_rad=Measured(-1.57, 5e-4)),
)  # fmt: skip


def _share(row, column):
    """Of a sector of 75 degrees about the axle at row 60, radii 25 to 50 px, with a soft border."""
    across, down = column - 35.0, row - 60.0
    radius, angle = np.hypot(across, down), np.arctan2(across, -down)
    soft = [radius - 25, 50 - radius, radius * (np.radians(37.5) - np.abs(angle))]
    return np.prod([1 / (1 + np.exp(-2 * one)) for one in soft], axis=0), angle


def _seen(moved_px, *, gain=None, level=None, noise=8.0, seed=0, step=0.0991):
    """Frames of 1000 DN of contrast with the opening, and the wheel with it, moved by ``moved_px`` (n, 2)."""
    random = np.random.default_rng(seed)
    row, column = np.mgrid[:ROWS, :COLUMNS].astype(float)
    index = np.sort(random.choice(1000, N, replace=False))
    angle = TURN * step * index
    frames = np.full((N, ROWS, COLUMNS), 2000.0)
    for k, (down, right) in enumerate(moved_px):
        share, place = _share(row - down, column - right)
        contrast = 1000.0 * (1.0 if gain is None else gain[k])
        frames[k] += contrast * share * (np.mod(angle[k] - place, TURN / 2) < TURN / 4)
    frames += random.normal(0, noise, frames.shape) + (0.0 if level is None else level[:, None, None])
    seen = motion.SampledFrames(
        values=np.rint(frames).astype(np.uint16), angle_rad=angle, index=index, good=np.ones(N, bool)
    )
    mask = _share(row, column)[0] > 0.5
    return seen, SimpleNamespace(mask=mask, bad=np.zeros_like(mask), border_px=2)


def _still():
    return np.zeros((N, 2))


def _from_half(down, right):
    return np.outer(np.arange(N) >= N // 2, [down, right]).astype(float)


@pytest.mark.parametrize("step", [2 + 1 / 1000, 0.5 + 0.5 / 1000])
def test_a_run_that_visits_the_angles_once_has_no_places(step):
    """Oracle: nothing was moved; each quarter sees other angles."""
    assert motion.places(*_seen(_still(), step=step)) is None


@pytest.mark.parametrize("moved", [(0.0, 0.3), (-0.5, 0.0), (1.5, -1.0)])
def test_a_jump_is_measured(moved):
    """Oracle: the jump that was made, from the middle of the run on; the linear slopes are good to a tenth."""
    found = motion.places(*_seen(_from_half(*moved)))
    for first in (0, 1):
        for last in (2, 3):
            apart, pull = found.between(first, last)
            assert apart == pytest.approx(np.array(moved), abs=0.1 * np.hypot(*moved))
            assert pull > 6
    assert found.first_frame[0] < 10
    assert 480 < found.first_frame[2] < 520


def test_the_axle_is_as_far_as_the_phases_say():
    """Oracle: the geometry; the middle of the opening is 37.5 px, its light 39 px from the axle."""
    assert motion.places(*_seen(_still())).radius_px == pytest.approx(38.5, abs=2.0)


def test_a_move_is_a_doubt_that_says_where_to():
    """Oracle: by hand; 0.5 px to the right from the middle on."""
    (one,) = motion.findings(motion.places(*_seen(_from_half(0.0, 0.5))), RIG, name="run")
    assert (one.code, one.severity, one.recording) == ("image-moved", "doubt", "run")
    assert "px to the right" in one.what
    assert "+0.4" in one.what or "+0.5" in one.what


@pytest.mark.parametrize(
    "changed",
    [{}, {"gain": np.linspace(1, 0.7, N)}, {"level": np.linspace(0, 300, N)}, {"level": 200.0 * (np.arange(N) > 80)}],
    ids=["nothing", "contrast", "drift", "jump"],
)
def test_levels_that_change_move_nothing(changed):
    """Oracle: what was changed is no place."""
    for seed in range(4):
        found = motion.places(*_seen(_still(), seed=seed, **changed))
        assert motion.findings(found, RIG, name="run") == ()
        assert np.abs(found.moved_px).max() < 0.02


def test_the_uncertainty_is_that_of_the_scatter():
    """Oracle: chi-square; twelve runs of eight numbers, whose mean is taken off, with noise alone: mean square pull about 1."""
    pulls = []
    for seed in range(12):
        found = motion.places(*_seen(_still(), noise=80.0, seed=seed))
        u = np.sqrt(np.diagonal(found.covariance_px2, axis1=1, axis2=2))
        pulls.append((found.moved_px - found.moved_px.mean(axis=0)) / u)
    assert 0.4 < np.mean(np.square(pulls)) < 2.5


def test_as_much_as_the_mask_may_be_off_is_no_doubt():
    """Oracle: rig.toml; twice 0.5 mrad at 39 px are 0.04 px."""
    found = motion.places(*_seen(_from_half(0.03, 0.0), noise=0.5))
    assert found.between(0, 3)[1] > 6
    assert motion.findings(found, RIG, name="run") == ()


def test_as_much_as_a_sway_feigns_is_no_doubt():
    """Oracle: by hand; a tenth of the contrast over a border of 2 px is 0.2 px."""
    for right, is_doubt in ((0.15, False), (0.3, True)):
        found = motion.places(*_seen(_from_half(0.0, right), noise=0.5))
        assert found.between(0, 3)[1] > 6
        assert bool(motion.findings(found, RIG, name="run")) == is_doubt


def test_few_frames_tell_nothing():
    """Oracle: by hand; four parts of thirty frames have fewer than 2.5 frames for each of 20 numbers."""
    seen, opening = _seen(_still())
    few = np.arange(N) % 2 == 0
    assert (
        motion.places(
            motion.SampledFrames(values=seen.values, angle_rad=seen.angle_rad, index=seen.index, good=few), opening
        )
        is None
    )
    assert motion.findings(None, RIG, name="run") == ()


@pytest.mark.parametrize(("n", "tells"), [(199, False), (200, True)])
def test_every_part_has_two_and_a_half_frames_for_each_number(n, tells):
    """Oracle: by hand; nine waves of two numbers, level and slope are 20; of 199 frames a fourth part has 49."""
    seen, opening = _seen(_still())
    few = motion.SampledFrames(values=seen.values, angle_rad=seen.angle_rad, index=seen.index, good=np.arange(N) < n)
    assert (motion.places(few, opening) is not None) == tells


def test_two_parts_are_apart_by_the_uncertainty_of_both():
    """Oracle: by hand; 3 px along rows, known to 0.6 and to 0.8 px: three standard uncertainties of 1 px."""
    places = motion.Places(
        first_frame=(0, 100), moved_px=np.array([[1.0, 0.0], [4.0, 0.0]]),
        covariance_px2=np.array([np.eye(2) * 0.36, np.eye(2) * 0.64]), radius_px=30.0, border_px=2,
    )  # fmt: skip
    apart, pull = places.between(0, 1)
    assert (apart.tolist(), pull) == ([3.0, 0.0], pytest.approx(3.0))


@pytest.mark.parametrize("wave", [np.cos, np.sin])
def test_waves_of_corners_leak_into_no_part(wave):
    """Oracle: the passing wave of 5000 DN that was put in, late by 0.4 rad, beside one of the lowest order of corners."""
    angle = np.random.default_rng(2).uniform(0, TURN, N)
    values = 20_000 + 5000 * np.cos(2 * angle - 0.4) + 5000 * wave(motion._CORNERS[0] * angle)
    frames = np.rint(values).astype(np.uint16)[:, None, None] * np.ones((1, 2, 2), np.uint16)
    for found in motion._harmonics(frames, angle, parts=np.array_split(np.arange(N), 4)):
        np.testing.assert_allclose(found, 5000 * np.exp(-0.4j), atol=5)


def test_the_axles_distance_is_that_of_pixels_two_from_the_border():
    """Oracle: the geometry; a strip of seven rows about 40 px above the axle, whose outermost pixels show anything."""
    row, column = np.mgrid[:15, :61].astype(float)
    inner = np.zeros(row.shape, bool)
    inner[4:11, 10:51] = True
    direction = np.exp(2j * np.arctan2(column - 30, 47 - row))
    anything = np.exp(1j * np.random.default_rng(3).uniform(0, TURN, row.shape))
    direction = np.where(inner & np.roll(inner, 1, 0) & np.roll(inner, -1, 0), direction, anything)
    deep = inner & (np.abs(row - 7) <= 1) & (np.abs(column - 30) <= 18)
    expected = np.median(np.hypot(row - 47, column - 30)[deep])
    assert motion._radius_px(direction, inner) == pytest.approx(expected, rel=0.01)


def test_the_part_that_is_looked_at_has_a_margin_on_every_side():
    """Oracle: by hand; three pixels about rows 10 to 12 and columns 20 to 24, as far as the image goes."""
    mask = np.zeros((50, 70), bool)
    mask[10:13, 20:25] = True
    assert motion._box(mask, margin=3) == (slice(7, 16), slice(17, 28))
    mask[1, 2] = True
    assert motion._box(mask, margin=3) == (slice(0, 16), slice(0, 28))
