"""Noise filters that know moving pixels from still ones: an opening that is covered and uncovered at once, filtered by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.reduce import motion_filter

N, ROWS, COLUMNS = 240, 24, 30


def _frames(*, contrast=600.0, noise=5.0, sway=0.0, swell=0.0):
    """A part of the image that is open for three frames and covered for three, at the same time everywhere."""
    random = np.random.default_rng(3)
    inside = np.zeros((ROWS, COLUMNS), bool)
    inside[6:18, 6:24] = True
    open_ = np.arange(N) % 6 < 3
    gain = random.normal(1, 0.03, (ROWS, COLUMNS))
    light = contrast * open_[:, None, None] * inside * gain
    light = light * (1 + swell * np.sin(np.arange(N) / 40))[:, None, None]
    return 5000 + light + random.normal(0, noise, light.shape) + sway * np.sin(np.arange(N) / 40)[:, None, None]


def _filtered(frames, share, *, below=np.inf):
    """Each frame with a share of the one before, where they differ by less than ``below``."""
    out = frames.copy()
    for k in range(1, len(out)):
        step = frames[k] - out[k - 1]
        out[k] = frames[k] - share * step * (np.abs(step) < below)
    return out


def _recording(values):
    frames = np.rint(values).astype(np.uint16)
    stack = SimpleNamespace(shape=frames.shape, pick=lambda index: frames[index])
    return SimpleNamespace(name="run", frames=stack)


@pytest.mark.parametrize("share", [0.5, 0.8])
@pytest.mark.parametrize("below", [20.0, 100.0])
def test_a_filter_that_lets_moving_pixels_through_is_a_doubt(share, below):
    """Oracle: by hand; a filter of the share that acts on differences below a part of the contrast."""
    (one,) = motion_filter.findings(_recording(_filtered(_frames(), share, below=below)))
    assert (one.code, one.severity, one.recording) == ("filter-follows-motion", "doubt", "run")
    assert "0% where it does" in one.what


@pytest.mark.parametrize("share", [0.0, 0.05, 0.3, 0.8])
@pytest.mark.parametrize("sway", [0.0, 30.0])
def test_a_filter_of_all_pixels_and_none_are_no_doubt(share, sway):
    """Oracle: by hand; a share of the frame before that is the same everywhere, and levels that sway."""
    assert motion_filter.findings(_recording(_filtered(_frames(sway=sway), share))) == ()


def test_a_gain_that_sways_is_no_filter():
    """Oracle: by hand; pixels whose gains differ show it when they are open, and in frames far apart, too."""
    frames = _frames(contrast=6000.0, noise=2.0, swell=0.03)
    found = motion_filter.correlation([frames])
    assert found.still - max(0.0, found.changed) > 0.4
    assert found.by_filter < 0.1
    assert motion_filter.findings(_recording(frames)) == ()
    (one,) = motion_filter.findings(_recording(_filtered(frames, 0.8, below=100.0)))
    assert one.code == "filter-follows-motion"


@pytest.mark.parametrize(("stays", "is_doubt"), [(3, False), (12, True)])
def test_pixels_that_hardly_ever_stay_tell_nothing(stays, is_doubt):
    """Oracle: by hand; covered and uncovered frame by frame but for 3 of 239 pairs, or for 12, which share their noise."""
    random, open_ = np.random.default_rng(4), np.arange(N) % 2 < 1
    places = np.linspace(10, N - 10, stays).astype(int)
    for place in places:
        open_[place:] = ~open_[place:]
    frames = 5000 + random.normal(0, 5, (N, ROWS, COLUMNS))
    frames[:, 6:18, 6:24] += 600 * open_[:, None, None]
    frames[places] = 0.7 * frames[places - 1] + 0.3 * frames[places]
    assert bool(motion_filter.findings(_recording(frames))) == is_doubt


def test_frames_that_came_twice_are_no_filter():
    """Oracle: by hand; each third frame is the one before."""
    frames = _frames()
    frames[2::3] = frames[1::3]
    assert motion_filter.findings(_recording(frames)) == ()


@pytest.mark.parametrize(("contrast", "noise"), [(0.0, 5.0), (600.0, 0.0), (0.0, 0.0)])
def test_without_light_or_noise_nothing_is_said(contrast, noise):
    """Oracle: by hand."""
    assert motion_filter.findings(_recording(_frames(contrast=contrast, noise=noise))) == ()


def test_the_correlations_are_those_of_the_filter():
    """Oracle: by hand; without a filter there is none, and after a change of level all is new."""
    found = motion_filter.correlation([_frames()])
    assert found.still == pytest.approx(0, abs=0.05)
    assert found.changed == pytest.approx(0, abs=0.05)
    found = motion_filter.correlation([_filtered(_frames(), 0.8, below=100.0)])
    assert found.still > 0.6
    assert found.changed == pytest.approx(0, abs=0.1)
    assert motion_filter.correlation([]) is None
