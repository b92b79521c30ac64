"""Masks drawn by hand: their largest part, whether they are in place, the box and the region around them, their blur."""

import numpy as np
import pytest
from scipy.special import ndtr

from irtiming.errors import ReductionError
from irtiming.reduce.opening.mask_shape import border_px, box, check_roi, is_in_place, largest_part


def _square(shape=(30, 40), first=(8, 10), size=10):
    mask = np.zeros(shape, bool)
    mask[first[0] : first[0] + size, first[1] : first[1] + size] = True
    return mask


def test_the_largest_part_is_kept():
    """Oracle: by hand; parts of 3 and 100 pixels, that touch at a corner only."""
    mask = _square()
    small = np.zeros_like(mask)
    small[18, 20:23] = True
    np.testing.assert_array_equal(largest_part(mask | small), mask)
    nothing = np.zeros((3, 3), bool)
    np.testing.assert_array_equal(largest_part(nothing), nothing)


@pytest.mark.parametrize(("n", "in_place"), [(0, True), (9, True), (10, False)])
def test_a_mask_is_in_place_if_a_quarter_of_its_border_differs_at_most(n, in_place):
    """Oracle: by hand; the border of 10 x 10 pixels has 36, a quarter of them is 9."""
    whole = _square()
    other = whole.copy()
    other[8, 10 : 10 + n] = False
    assert is_in_place(other, whole) is in_place
    assert is_in_place(whole, other) is in_place


def test_masks_of_other_images_or_places_are_not_in_place():
    """Oracle: by hand; another size of the image, and two rows further down."""
    assert not is_in_place(_square(), _square((30, 41)))
    assert not is_in_place(_square(), _square(first=(10, 10)))


def test_the_box_has_its_margin_where_there_is_room():
    """Oracle: by hand."""
    assert box(_square(), margin=3, name="a") == (5, 21, 7, 23)
    assert box(_square(first=(2, 28)), margin=3, name="a") == (0, 15, 25, 40)


@pytest.mark.parametrize("first", [(1, 10), (8, 1), (19, 10), (8, 29)])
def test_an_opening_that_the_image_cuts_is_refused(first):
    """Oracle: by hand; one pixel of room on one side, where two must be."""
    with pytest.raises(ReductionError, match=r"a: the opening spans rows .* is cut by its border; the whole opening"):
        box(_square(first=first), margin=3, name="a")
    roomy = tuple(np.clip(first, 2, (18, 28)))
    assert box(_square(first=roomy), margin=0, name="a")[0] == roomy[0]


@pytest.mark.parametrize(
    ("roi", "says"),
    [
        ((8, 18, 10, 20), ""),
        ((0, 30, 0, 40), ""),
        ((0, 31, 0, 40), "lies outside the image of 30 rows and 40 columns"),
        ((0, 30, 0, 41), "lies outside"),
        ((-1, 30, 0, 40), "lies outside"),
        ((0, 30, -1, 40), "lies outside"),
        ((9, 9, 0, 40), "lies outside"),
        ((0, 30, 20, 20), "lies outside"),
        ((9, 18, 10, 20), "leaves out 10 of 100 pixels of the opening"),
        ((8, 18, 10, 18), "leaves out 20 of 100 pixels"),
    ],
)
def test_a_region_holds_the_whole_opening_and_lies_in_the_image(roi, says):
    """Oracle: by hand, side by side."""
    if not says:
        check_roi(roi, _square(), name="a")
        return
    with pytest.raises(ReductionError, match=says):
        check_roi(roi, _square(), name="a")


def _blurred(sigma, plate=0.0):
    """A disc of radius 14 whose border is a Gaussian's integral, and what the mask plate shows around it."""
    rows, columns = np.mgrid[:80, :80] - 39.5
    return plate + (1 - plate) * ndtr((14 - np.hypot(rows, columns)) / sigma)


@pytest.mark.parametrize("plate", [0.0, 0.05])
@pytest.mark.parametrize("sigma", [0.5, 1.0, 2.0, 3.0])
def test_the_border_ends_where_the_blur_does(sigma, plate):
    """Oracle: the Gaussian; beyond 2.5 sigma less than 0.6 % is left, and the ring after that is flat."""
    contrast = _blurred(sigma, plate)
    found = border_px(contrast, contrast > 0.5, plate=plate)
    assert 2 * sigma <= found <= 3.5 * sigma + 3


def test_the_border_ends_where_two_rings_in_a_row_are_as_the_one_before():
    """Oracle: by hand; below the opening rows are rings: two alike, then a reflection, and from the fifth on nothing."""
    rings = [0.5, 0.02, 0.02, 0.08, *[0.0] * 46]
    contrast = np.repeat([*[1.0] * 20, *rings], 30).reshape(70, 30)
    assert border_px(contrast, contrast > 0.9) == 6


def test_a_border_that_never_ends_has_the_largest_width():
    """Oracle: the limit of 16 px in the module; contrast that falls by a per cent each pixel."""
    rows, columns = np.mgrid[:90, :90] - 44.5
    contrast = np.clip(1 - (np.hypot(rows, columns) - 8) * 0.02, 0, 1)
    assert border_px(contrast, np.hypot(rows, columns) < 8) == 16
