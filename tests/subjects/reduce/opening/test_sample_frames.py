"""Noise and level of sampled frames: noise that was drawn, and means by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.reduce.nonuniformity import Correction
from irtiming.reduce.opening.sample_frames import SampleFrames, look, mean_within, noise_dn


def test_noise_is_that_of_one_pixel_from_frame_to_frame():
    """Oracle: the standard deviation that was drawn; a fixed pattern and a level that all pixels share are none."""
    rng = np.random.default_rng(1)
    frames = 5000 + rng.normal(0, 200, (40, 60)) + rng.normal(0, 40, (200, 1, 1)) + rng.normal(0, 5, (200, 40, 60))
    assert noise_dn(np.rint(frames).astype(np.uint16), np.ones((40, 60), bool)) == pytest.approx(5.0, rel=0.02)
    assert noise_dn(np.rint(frames).astype(np.uint16), np.zeros((40, 60), bool)) == 0.0


def test_the_mean_is_that_of_the_pixels_in_the_area():
    """Oracle: by hand; 3 and 5, 7 and 9, and 0 of no pixels."""
    frames = np.array([[[3, 99], [5, 99]], [[7, 99], [9, 99]]], np.uint16)
    assert mean_within(frames, np.array([[True, False], [True, False]])).tolist() == [4.0, 8.0]
    assert mean_within(frames, np.zeros((2, 2), bool)).tolist() == [0.0, 0.0]


def _recording(frames):
    pick = SimpleNamespace(shape=frames.shape, pick=lambda these: frames[these])
    return SimpleNamespace(name="a", frames=pick)


def _flat():
    return Correction(gain=np.ones((12, 16)), offset_dn=np.zeros((12, 16)), bad=np.zeros((12, 16), bool), is_none=True)


def test_frames_without_an_angle_and_blank_ones_are_not_looked_at():
    """Oracle: by hand; of 60 frames 20 have no angle, and three of the others are blank; the rim's level is common to all."""
    rng = np.random.default_rng(1)
    frames = rng.integers(4990, 5011, (60, 12, 16)).astype(np.uint16)
    frames[:, 4:8, 4:8] += 1000
    frames[[30, 40, 50]] = 4095
    angle = np.where(np.arange(60) < 20, np.nan, 0.1 * np.arange(60))
    found = look(_recording(frames), angle, correct=_flat())
    expected = [n for n in range(20, 60) if n not in (30, 40, 50)]
    np.testing.assert_array_equal(found.raw, frames[expected])
    assert found.place.tolist() == pytest.approx([n / 60 for n in expected])
    assert found.common_dn == pytest.approx(np.full(37, 5000.0), abs=3)


@pytest.mark.parametrize(
    ("n_unknown", "n_blank", "words"),
    [(31, 0, "29 of 60 sample frames were triggered while"), (0, 31, "31 of 60 sample frames are blank")],
)
def test_too_few_frames_that_show_something_are_refused(n_unknown, n_blank, words):
    """Oracle: by hand; of 60 frames fewer than half have an angle, or show an image."""
    frames = np.random.default_rng(1).integers(4990, 5011, (60, 12, 16)).astype(np.uint16)
    frames[:n_blank] = 4095
    angle = np.where(np.arange(60) < n_unknown, np.nan, 0.1 * np.arange(60))
    with pytest.raises(ReductionError, match=words):
        look(_recording(frames), angle, correct=_flat())


def test_frames_that_are_all_equal_are_refused():
    """Oracle: by hand; one frame of noise sixty times, as of a camera that has stopped; one other will do."""
    frames = np.repeat(np.random.default_rng(1).integers(4990, 5011, (1, 12, 16)).astype(np.uint16), 60, axis=0)
    angle = 0.1 * np.arange(60)
    with pytest.raises(ReductionError, match="all 60 sample frames are equal, pixel by pixel"):
        look(_recording(frames), angle, correct=_flat())
    frames[59, 5, 5] += 1
    assert len(look(_recording(frames), angle, correct=_flat()).raw) == 60


def test_a_frame_whose_band_is_off_by_half_of_its_contrast_is_not_whole():
    """Oracle: by hand; 36 of 40 columns lie 100 DN from the mean, so that half of a frame's deviation is 47.4 DN; no noise.

    Rows 6 and 7 are one of 16 bands, and one of them alone counts half.
    """
    values = np.full((30, 32, 40), 5000, np.uint16)
    values[:, :, 2:20], values[:, :, 20:38] = 4900, 5100
    values[3, 6:8, [0, 1, 38, 39]] = 5045
    values[5, 6:8, [0, 1, 38, 39]] = 5050
    values[7, 6:8, [0, 1, 38, 39]] = 4950
    values[9, 7, [0, 1, 38, 39]] = 5090
    frames = SampleFrames(
        raw=values, values=values, wheel_angle_rad=np.zeros(30), place=np.zeros(30), common_dn=np.full(30, 5000.0)
    )
    assert np.flatnonzero(~frames.is_whole).tolist() == [5, 7]
