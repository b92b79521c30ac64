"""Remarks of every reduction: what is said of one, and what of several."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.records.reduced import ShutterEvent
from irtiming.reduce import remarks

RUN = SimpleNamespace(name="run")


@pytest.mark.parametrize(
    ("first", "end", "words"),
    [
        (0, 1, "in frame 0: dropped with the frames around it"),
        (7, 9, "in frames 7 to 8: dropped with the frames around them"),
    ],
)
def test_a_shutter_is_closed_in_one_frame_or_several(first, end, words):
    """Oracle: by hand; the end is the first frame in which it is open again."""
    event = ShutterEvent(first_frame=first, end_frame=end, kind="closed")
    assert remarks.shutter_closed(RUN, event).what == f"the shutter is closed {words}"


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ([5], "image row 5 left out: it has too few live pixels, or is a copy of a row beside it"),
        ([5, 9], "image rows 5, 9 left out: they have too few live pixels, or are copies of a row beside them"),
    ],
)
def test_one_row_or_several_are_left_out(rows, words):
    """Oracle: by hand."""
    assert remarks.rows_left_out(RUN, np.array(rows)).what == words
