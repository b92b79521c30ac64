"""Whole rows that are dead: which they are, and what they would show."""

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.reduce import nonuniformity
from irtiming.reduce.opening import dead_rows


@pytest.fixture
def noisy(paper_wheel, recorded):
    """A recording of nothing but noise, its rows changed: ``noisy(stuck=..., copies=..., sigma=...)``."""

    def made(*, stuck=(), copies=(), sigma=3.0):
        frames = np.random.default_rng(1).normal(5000, sigma, (120, 30, 40)).round().astype(np.uint16)
        frames[:, stuck] = 7000
        for row in copies:
            frames[:, row] = frames[:, row - 1]
        return recorded(paper_wheel(), n_triggers=120, frames=frames)

    return made


@pytest.mark.parametrize(
    ("changed", "dead"),
    [
        ({}, []),
        ({"stuck": [4, 9, 10]}, [4, 9, 10]),
        ({"copies": [4, 9, 10]}, [3, 4, 8, 9, 10]),
        ({"stuck": [0], "copies": [29]}, [0, 28, 29]),
        ({"copies": range(1, 30, 2)}, []),
        ({"stuck": [4], "sigma": 0.01}, []),
    ],
    ids=["none", "stuck", "copies", "at the ends", "a binned image", "no noise"],
)
def test_dead_rows_are_told_from_live_ones(noisy, changed, dead):
    """Oracle: by hand; of two rows that are alike neither is live, half of an image is no fault, and noise tells all of it."""
    assert np.flatnonzero(dead_rows.find(noisy(**changed))).tolist() == dead


def test_all_pixels_of_a_dead_row_are_bad(noisy):
    """Oracle: by hand."""
    recording = noisy(stuck=[4])
    correct = dead_rows.marked(nonuniformity.correction(recording), recording)
    assert np.argwhere(dead_rows.of(correct.bad)).ravel().tolist() == [4]
    assert correct.bad.sum() == 40


def test_between_live_rows_a_straight_line_is_drawn():
    """Oracle: by hand; an image that is linear in its rows, to its border the nearest live row."""
    image = np.arange(10.0)[:, None] * np.array([1.0, 2j])
    dead = np.zeros(10, bool)
    dead[[3, 4, 9]] = True
    broken = np.where(dead[:, None], 99.0, image)
    full = dead_rows.filled(broken, dead)
    np.testing.assert_allclose(full[:9], image[:9])
    np.testing.assert_allclose(full[9], image[8])
    assert np.array_equal(dead_rows.filled(np.array([broken, broken]), dead), np.array([full, full]))
    assert dead_rows.filled(image, np.ones(10, bool)) is image


def test_a_wide_gap_in_the_opening_is_refused():
    """Oracle: by hand; five rows beside each other may be dead, six may not but beside the opening."""
    mask, bad = np.zeros((40, 20), bool), np.zeros((40, 20), bool)
    mask[10:30, 5:15] = True
    bad[14:19] = bad[32:40] = True
    dead_rows.refuse_wide_gaps(bad, mask, name="run")
    bad[19] = True
    with pytest.raises(ReductionError, match=r"run: image rows 14, 15, 16, 17, 18, 19 of the opening are dead"):
        dead_rows.refuse_wide_gaps(bad, mask, name="run")
