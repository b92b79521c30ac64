"""Recordings that are taken together: the opening must lie in one place."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.reduce.recipes import _refuse_moved


def _mask(row, column):
    mask = np.zeros((40, 50), bool)
    mask[row : row + 12, column : column + 20] = True
    return mask


def test_an_opening_in_its_place_passes_and_one_that_was_moved_is_refused_with_both_places():
    """Oracle: by hand; a block of 12 x 20 pixels, a border pixel more here or there, and two columns to the right."""
    recording, before = SimpleNamespace(name="second"), _mask(10, 8)
    ragged = before.copy()
    ragged[10, 8:14] = False
    _refuse_moved(recording, ragged, before)
    with pytest.raises(ReductionError, match=r"second: .* row 15.5, column 19.5, .* row 15.5, column 17.5; .* apart"):
        _refuse_moved(recording, _mask(10, 10), before)
