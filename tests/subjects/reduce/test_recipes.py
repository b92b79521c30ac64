"""Recordings that are taken together: the opening must lie in one place."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.reduce.recipes import _refuse_another


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
