"""What is said of maps of pixels."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import map_findings


@pytest.mark.parametrize(
    ("rows", "named"),
    [
        ([0, 1, 2, 7, 8], "image rows 0 to 2 and 7 to 8 hold"),
        ([3, 5], "image rows 3 and 5 hold"),
        ([0, 1, 3, 4], "image rows 0 to 1 and 3 to 4 hold"),
    ],
)
def test_rows_without_a_pixel_are_named_in_runs(rows, named):
    """Oracle: by hand; a single row with pixels parts two runs."""
    maps = SimpleNamespace(unseen_row_px=np.array(rows), fitted_row_delay_s=30e-6)
    (finding,) = map_findings._unseen(maps)
    assert finding.sentence().startswith(named)
    assert map_findings._unseen(SimpleNamespace(unseen_row_px=np.array(rows), fitted_row_delay_s=0.0)) == []


@pytest.mark.parametrize(("n", "ends"), [(8, "(14, 9),"), (11, "(14, 9) and 3 more,")])
def test_the_first_eight_pixels_are_named(n, ends):
    """Oracle: by hand; a column of the map that begins at row 7 and column 9."""
    these = np.zeros((11, 3), bool)
    these[:n, 0] = True
    named = map_findings._named(these, SimpleNamespace(roi=(7, 18, 9, 12)))
    assert named.startswith(f"{n} pixels, in (row, column) (7, 9), (8, 9)")
    assert named.endswith(ends)
