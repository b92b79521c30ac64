"""Recordings that are taken together: the opening must lie in one place."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.errors import EstimationError, ReductionError
from irtiming.reduce.recipes import _refuse_another, check_one_opening


def _opening(row, column, rows=12):
    mask = np.zeros((40, 50), bool)
    mask[row : row + rows, column : column + 20] = True
    return SimpleNamespace(mask=mask, roi=(row - 2, row + rows + 2, column - 2, column + 22))


def test_an_opening_in_its_place_passes_and_one_that_was_moved_is_refused_with_both_places():
    """Oracle: by hand; a block of 12 x 20 pixels, a border pixel more here or there, and two columns to the right."""
    recording, before, ragged = SimpleNamespace(name="second"), _opening(10, 8), _opening(10, 8)
    ragged.mask[10, 8:14] = False
    _refuse_another(recording, ragged, before)
    with pytest.raises(ReductionError, match=r"second: .* row 15.5, column 19.5, .* row 15.5, column 17.5; .* apart"):
        _refuse_another(recording, _opening(10, 10), before)


def test_an_opening_of_another_size_is_refused_with_both_sizes():
    """Oracle: by hand; 14 rows in place of 12, and half of the difference to either side leaves the middle where it was."""
    with pytest.raises(
        ReductionError, match=r"second: the opening has 280 pixels, 240 in the recordings before; .*readout"
    ):
        _refuse_another(SimpleNamespace(name="second"), _opening(9, 8, rows=14), _opening(10, 8))


@pytest.mark.parametrize("other", [_opening(10, 9), _opening(9, 8, rows=14)])
def test_recordings_that_were_reduced_each_for_itself_are_refused_with_both_places(other):
    """Oracle: by hand; a block of 12 x 20 pixels with two about it, the same again, and one that lies or is otherwise."""
    one, again = (SimpleNamespace(name=name, opening=_opening(10, 8)) for name in ("first", "again"))
    check_one_opening([one])
    check_one_opening([one, again])
    pixels, first_row = int(other.mask.sum()), other.roi[0]
    with pytest.raises(
        EstimationError, match=rf"second .* {pixels} pixels in rows {first_row} .* 240 in rows 8 to 23, .* 6 to 29"
    ):
        check_one_opening([one, again, SimpleNamespace(name="second", opening=other)])


def test_a_border_pixel_more_is_another_opening():
    """Oracle: by hand; the same region, but for one pixel."""
    one, other = (SimpleNamespace(name=name, opening=_opening(10, 8)) for name in ("first", "second"))
    other.opening.mask[9, 12] = True
    with pytest.raises(EstimationError, match="241 pixels"):
        check_one_opening([one, other])
