"""Who stands in for whom."""

import numpy as np
import pytest

from irtiming.reduce.opening import dead_pixels


def test_neighbours_of_the_same_row_stand_in():
    """Oracle: by hand; between good ones, in a pair, at either end of the row, and a row with a third of its pixels bad."""
    bad = np.zeros((5, 12), bool)
    for row, columns in enumerate([[2], [1, 2], [0, 11], [3, 4, 5, 6], [4]]):
        bad[row, columns] = True
    wanted = np.ones_like(bad)
    wanted[4] = False
    weight = dead_pixels.row_weights(wanted, bad)
    odd = {(row, column): weight[row, column] for row, column in np.argwhere(weight[:3] != 1).tolist()}
    assert odd == {
        (0, 1): 1.5, (0, 2): 0, (0, 3): 1.5, (1, 0): 2, (1, 1): 0, (1, 2): 0, (1, 3): 2, (2, 0): 0, (2, 1): 2, (2, 10): 2,
        (2, 11): 0,
    }  # fmt: skip
    assert not weight[4].any()
    assert dead_pixels.hopeless_rows(wanted, bad).tolist() == [False, False, False, True, False]


def test_nobody_is_needed_where_all_are_good():
    """Oracle: by hand."""
    bad, wanted = np.zeros((3, 4), bool), np.ones((3, 4), bool)
    assert np.array_equal(dead_pixels.row_weights(wanted, bad), np.ones((3, 4)))
    assert np.array_equal(dead_pixels.weights(wanted, bad), np.ones((3, 4)))
    assert not dead_pixels.hopeless_rows(wanted, bad).any()


def test_what_stands_out_is_mended():
    """Oracle: by hand; a hole in a plain, a pair of holes, a spike in the dark; a straight border is left alone."""
    contrast = np.zeros((12, 14))
    contrast[:, :8] = 1.0
    contrast[:, 8] = 0.5
    broken = contrast.copy()
    broken[3, 3] = broken[8, 4] = broken[8, 5] = 0.0
    broken[5, 11] = 1.0
    assert np.array_equal(dead_pixels.mended(broken), contrast)
    assert np.array_equal(dead_pixels.mended(contrast), contrast)


def test_a_clean_border_has_no_dead_pixels():
    """Oracle: by hand; a blurred disc over noise, followed at once by all pixels."""
    rng = np.random.default_rng(0)
    rows, columns = np.mgrid[:60, :60]
    contrast = 1 / (1 + np.exp((np.hypot(rows - 30, columns - 30) - 20) / 0.6))
    live = (5000 + 300 * rng.random(100)[:, None, None] * contrast + rng.normal(0, 5, (100, 60, 60))).astype(np.uint16)
    mask, summed = contrast > 0.5, contrast > 1e-3
    assert not dead_pixels.find(live, contrast, mask=mask, summed=summed).any()
    contrast[30, 30] = 0.1
    live[:, 20, 25] = (live[:, 20, 25] + rng.normal(0, 60, 100)).astype(np.uint16)
    assert np.argwhere(dead_pixels.find(live, contrast, mask=mask, summed=summed)).tolist() == [[20, 25], [30, 30]]


def test_dead_pixels_are_found_right_up_to_the_border():
    """Oracle: by hand; a sharp opening of 20 x 24 pixels, a dead one two pixels from each of its corners."""
    opening = np.zeros((40, 50), bool)
    opening[8:28, 11:35] = True
    dead = [(10, 13), (10, 32), (25, 13), (25, 32)]
    contrast = opening.astype(float)
    contrast[*np.transpose(dead)] = 0.2
    live = np.full((20, 40, 50), 5000, np.uint16)
    assert np.argwhere(dead_pixels.find(live, contrast, mask=opening, summed=opening)).tolist() == [
        list(one) for one in dead
    ]


@pytest.mark.parametrize(("row", "is_found"), [(10, False), (11, True)])
def test_a_blinking_pixel_is_found_from_the_fourth_row_of_the_opening_on(row, is_found):
    """Oracle: by hand; a sharp opening from row 8 on, of noise of 5 DN, and a pixel that scatters by 60 DN."""
    opening = np.zeros((40, 50), bool)
    opening[8:28, 11:35] = True
    rng = np.random.default_rng(0)
    live = 5000 + rng.normal(0, 5, (100, 40, 50))
    live[:, row, 20] += rng.normal(0, 60, 100)
    found = dead_pixels.find(live.astype(np.uint16), opening.astype(float), mask=opening, summed=opening)
    assert np.argwhere(found).tolist() == ([[row, 20]] if is_found else [])
