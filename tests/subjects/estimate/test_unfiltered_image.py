"""A contrast image as pixels saw it, before a filter in the camera: by hand on a few pixels."""

import numpy as np
import pytest

from irtiming.estimate import frame_steps
from irtiming.records.reduced import ContrastImage, ContrastPairs

TURN, CLOCK_HZ = 2 * np.pi, 49_152_000
SHARE = 0.25


@pytest.fixture
def filtered(track_of, reduced_recording):
    """The wheel turns by 0.7 rad per frame; what pixels saw, 100 exp(0.3 i) and 40 DN, and what a filter left of it."""
    period = 1_638_400
    omega = 0.7 * CLOCK_HZ / period
    ticks = 30_000_000 + period * np.arange(50, dtype=np.int64)
    track = track_of(lambda t: omega * t, start=10_000_000, duration_s=3.0)
    saw, before = np.array([[100 * np.exp(0.3j), 40.0]]), np.array([[30 - 5j, 7j]])
    later = np.append(0.0, np.ones(49)).astype(complex)
    pairs = ContrastPairs(
        projection_dn=(1 - SHARE) * saw + SHARE * before, before_dn=before, frame_weight=later * (np.arange(50) < 33)
    )
    image = ContrastImage(
        projection_dn=np.zeros((1, 2), complex), frame_weight=np.ones(50, complex), u_dn=3.0, good=np.ones((1, 2), bool),
        roi=(0, 1, 0, 2), pairs=pairs,
    )  # fmt: skip
    return reduced_recording(track, ticks, np.ones(50), contrast=image), saw


def test_an_image_is_what_the_pixels_saw(filtered):
    """Oracle: by hand; each frame was a quarter of the frame before it and three quarters of what pixels saw."""
    recording, saw = filtered
    found = frame_steps.unfiltered(recording, SHARE).contrast_image
    np.testing.assert_allclose(found.projection_dn, saw, atol=1e-12)
    assert found.pairs is None


def test_noise_grows_as_the_filter_weakened_the_wave_and_with_fewer_frames(filtered):
    """Oracle: by hand; of a wave twice a turn a geometric series of frames leaves |(1 - k) / (1 - k exp(-1.4 i))|; 32 of 50."""
    recording, _ = filtered
    left = abs(sum((1 - SHARE) * SHARE**n * np.exp(-2j * 0.7 * n) for n in range(60)))
    found = frame_steps.unfiltered(recording, SHARE).contrast_image.u_dn
    assert found == pytest.approx(3.0 / left * (50 / 32) ** 0.5, rel=1e-4)
