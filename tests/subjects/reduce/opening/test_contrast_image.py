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
