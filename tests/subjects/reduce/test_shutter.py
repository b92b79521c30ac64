"""Frames judged good or bad, on levels written by hand."""

import numpy as np
import pytest

from irtiming.records.reduced import ShutterEvent
from irtiming.reduce import shutter
from irtiming.reduce.shutter import FrameLevels, Watch, events, fewest_pixels, tolerance_dn, watch


def _levels(n=60, *, beside=(), quiet=(), band=(), repeated=(), dead=()):
    """Good frames, but where told: index to value, or indices."""
    levels = FrameLevels(
        beside_dn=np.zeros(n),
        quiet_dn=np.full(n, 100.0),
        band_dn=np.full((n, 4), 100.0),
        repeated=np.zeros(n, bool),
        dead=np.zeros(n, bool),
    )
    for index, value in dict(beside).items():
        levels.beside_dn[index] = value
    for index, value in dict(quiet).items():
        levels.quiet_dn[index] = value
    for index, value in dict(band).items():
        levels.band_dn[index, 2] = value
    levels.repeated[list(repeated)] = True
    levels.dead[list(dead)] = True
    return levels


_WATCH = Watch(tolerance_dn=10.0, margin=3)


def _judged(levels, *, at_start=False, at_end=False):
    """Indices of suspicious frames, of those in events, and of those too near to an event."""
    return [np.flatnonzero(part).tolist() for part in _WATCH.judge(levels, at_start=at_start, at_end=at_end)]


def test_good_frames_are_good():
    """Oracle: by hand; levels within the tolerance, unknown ones, and a slow drift of the quiet level."""
    levels = _levels(beside={3: 9.9, 8: -9.9, 20: np.nan, 21: np.nan})
    levels.quiet_dn[:] += 1.2 * np.arange(60)
    assert _judged(levels, at_start=True, at_end=True) == [[], [], []]


@pytest.mark.parametrize("kind", ["beside", "quiet", "band", "repeated", "dead"])
def test_each_sign_of_a_bad_frame_counts(kind):
    """Oracle: by hand; one frame alone is suspicious and no event, two side by side are, and three frames around them go."""
    marked = (
        (lambda *where: dict.fromkeys(where, 50.0)) if kind in ("beside", "quiet", "band") else (lambda *where: where)
    )
    assert _judged(_levels(**{kind: marked(30)})) == [[30], [], []]
    assert _judged(_levels(**{kind: marked(30, 31)})) == [[30, 31], [30, 31], list(range(27, 35))]
    assert _judged(_levels(**{kind: marked(30, 32)})) == [[30, 32], [30, 32], list(range(27, 36))]
    assert _judged(_levels(**{kind: marked(30, 33)})) == [[30, 33], [], []]


def test_a_bad_frame_at_either_end_may_be_the_rest_of_an_event():
    """Oracle: by hand; a lone frame is an event only where the recording begins or ends, and unless it is blank."""
    assert _judged(_levels(beside={0: 50.0}), at_start=True) == [[0], [0], [0, 1, 2, 3]]
    assert _judged(_levels(beside={0: 50.0})) == [[0], [], []]
    assert _judged(_levels(beside={59: 50.0}), at_end=True) == [[59], [59], [56, 57, 58, 59]]
    assert _judged(_levels(dead=[0]), at_start=True) == [[0], [], []]
    assert _judged(_levels(dead=[59]), at_end=True) == [[59], [], []]


def test_a_judgement_needs_no_frame_out_of_reach():
    """Oracle: the same frames judged with random ones further away than the reach."""
    rng = np.random.default_rng(0)
    n, reach = 400, _WATCH.reach
    levels = _levels(n, beside=dict.fromkeys(rng.choice(n, 40), 50.0), quiet=dict.fromkeys(rng.choice(n, 30), 50.0))
    whole = _WATCH.judge(levels, at_start=False, at_end=False)
    for first in range(reach, n - reach - 20, 37):
        part = slice(first - reach, first + 20 + reach)
        cut = FrameLevels(**{name: value[part] for name, value in levels.__dict__.items()})
        judged = _WATCH.judge(cut, at_start=False, at_end=False)
        for one, other in zip(judged, whole, strict=True):
            assert np.array_equal(one[reach : reach + 20], other[first : first + 20])


def test_tolerance_and_margin():
    """Oracle: by hand; eight scatters within 8 to 30 % of the contrast; 0.12 s or as long as the level stands still."""
    plain = {"longest_level_s": 0.03, "frame_period_s": 0.033}
    assert [tolerance_dn(contrast_dn=100.0, scatter_dn=scatter) for scatter in (0.1, 2.0, 50.0)] == [8.0, 16.0, 30.0]
    assert watch(8.0, **plain) == Watch(tolerance_dn=8.0, margin=4)
    assert watch(8.0, **(plain | {"frame_period_s": 0.11})).margin == 3
    assert watch(8.0, **(plain | {"longest_level_s": 0.5})).margin == 16


def test_a_mean_needs_pixels_enough():
    """Oracle: by hand: 7 x 20 DN over the root of 49 pixels is 20 DN; noise that is small beside the tolerance asks for one."""
    assert fewest_pixels(20.0, noise_dn=20.0) == 49
    assert fewest_pixels(376.0, noise_dn=20.0) == 1


def test_events_are_told_apart_and_named():
    """Oracle: by hand; a closed shutter whose first and last frame had the expected level, and a frozen camera."""
    levels = _levels(80, quiet=dict.fromkeys(range(20, 30), 60.0), repeated=[60, 61, 62])
    event = np.zeros(80, bool)
    event[[21, 22, 23, 26, 28, 60, 61, 62]] = True
    zone = np.zeros(80, bool)
    zone[18:32] = zone[57:66] = True
    assert events(event, zone, levels=levels) == (
        ShutterEvent(first_frame=20, end_frame=30, kind="closed"),
        ShutterEvent(first_frame=60, end_frame=63, kind="frozen"),
    )


@pytest.mark.parametrize(("repeated", "kind"), [([60, 62, 63], "frozen"), ([60, 62], "closed")])
def test_a_camera_is_frozen_where_most_frames_repeat(repeated, kind):
    """Oracle: by hand; three of four frames and two of four."""
    event, zone = np.zeros(80, bool), np.zeros(80, bool)
    event[60:64] = zone[57:67] = True
    found = events(event, zone, levels=_levels(80, repeated=repeated))
    assert found == (ShutterEvent(first_frame=60, end_frame=64, kind=kind),)


def test_an_event_may_reach_over_either_end():
    """Oracle: by hand; closed in the first four and the last three frames."""
    levels = _levels(50, quiet=dict.fromkeys([0, 1, 2, 3, 47, 48, 49], 60.0))
    event, zone = np.zeros(50, bool), np.zeros(50, bool)
    event[[1, 2, 47, 48]] = True
    zone[:6] = zone[44:] = True
    assert [(e.first_frame, e.end_frame) for e in events(event, zone, levels=levels)] == [(0, 4), (47, 50)]
    everywhere = np.ones(50, bool)
    assert [(e.first_frame, e.end_frame) for e in events(event, everywhere, levels=levels)] == [(1, 49)]


def test_a_level_is_usual_where_half_of_the_frames_within_reach_have_it():
    """Oracle: by hand; another level is a step for fewer than half of the window's frames, and usual for more of them."""
    long = 2 * shutter._HALF_WINDOW + 1
    for n, is_usual in ((shutter._HALF_WINDOW, False), (shutter._HALF_WINDOW + 1, True)):
        levels = _levels(6 * long)
        levels.quiet_dn[2 * long : 2 * long + n] = 150.0
        suspicious = _judged(levels)[0]
        assert (2 * long + n // 2 not in suspicious) == is_usual
