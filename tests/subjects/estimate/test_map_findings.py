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
