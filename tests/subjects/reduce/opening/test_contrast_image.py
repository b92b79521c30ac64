"""Mean of each pixel of the region that is summed: by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.reduce.nonuniformity import Correction
from irtiming.reduce.opening import contrast_image


def test_the_mean_is_that_of_the_corrected_frames():
    """Oracle: every frame corrected, then the mean; a region of 2 x 3 pixels, a stretch of three frames and one of one."""
    rng = np.random.default_rng(1)
    correct = Correction(
        gain=rng.uniform(0.8, 1.2, (5, 7)), offset_dn=rng.normal(0, 50, (5, 7)), bad=np.zeros((5, 7), bool)
    )
    opening = SimpleNamespace(roi=(1, 3, 4, 7))
    frames = rng.integers(3000, 6000, (6, 5, 7)).astype(np.uint16)
    made = contrast_image.projection(rng.uniform(0, 6, 6), opening)
    for stretch in (np.array([0, 1, 2]), np.array([4])):
        made.add(stretch, np.ascontiguousarray(frames[stretch, 1:3, 4:7]))
        made.keep(stretch)
    expected = (correct.offset_dn + correct.gain * frames[[0, 1, 2, 4]]).mean(axis=0)[1:3, 4:7]
    assert contrast_image.mean_dn(made, opening, correct=correct) == pytest.approx(expected)


def test_a_stuck_pixel_beside_the_opening_is_dead():
    """Oracle: by hand: pixels at either limit, and one between them, among noise of 3 DN; drift is taken off all alike."""
    rng, n = np.random.default_rng(2), 60
    frames = rng.normal(5000, 3, (n, 12, 14)).round().astype(np.uint16)
    for place, value in (((1, 2), 65535), ((7, 3), 0), ((10, 12), 5000)):
        frames[:, *place] = value
    bad = np.zeros((12, 14), bool)
    bad[5, 6] = True
    opening = SimpleNamespace(roi=(0, 12, 0, 14), bad=bad, summed=np.zeros((12, 14), bool))
    made = contrast_image.projection(2.9 * np.arange(n), opening)
    made.add(np.arange(n), frames)
    made.keep(np.arange(n))
    none = Correction(gain=np.ones((12, 14)), offset_dn=np.zeros((12, 14)), bad=np.zeros((12, 14), bool))
    found = contrast_image.of(made, opening, correct=none, drift_dn=np.linspace(0, 40, n), noise_dn=3.0)
    assert np.argwhere(~found.good).tolist() == [[1, 2], [5, 6], [7, 3], [10, 12]]
    assert found.u_dn == pytest.approx(3 * np.sqrt(2 / n), rel=0.2)
