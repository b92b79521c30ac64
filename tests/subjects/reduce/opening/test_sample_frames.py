"""Noise and level of sampled frames: noise that was drawn, and means by hand."""

import numpy as np
import pytest

from irtiming.reduce.opening.sample_frames import mean_within, noise_dn


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
