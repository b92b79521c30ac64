"""Openings that no camera shows are refused with what they are."""

from contextlib import nullcontext

import pytest

from irtiming.errors import EstimationError
from irtiming.estimate import sector_limits


@pytest.mark.parametrize(
    ("distortion", "beside", "words"),
    [(-0.1395, 0.0, "distortion would be -0.1395"), (-0.1385, 0.0, ""), (0.0, 12.9, "13 px from"), (0.0, 12.7, "")],
)
def test_a_lens_that_there_is_not_is_refused(distortion, beside, words):
    """Oracle: by hand; -0.14 is where a barrel folds, and a fifth of 64 columns is 12.8 px."""
    known = {"lens_row_px": 20.0, "lens_column_px": 1.0}
    numbers = {"distortion": distortion, "lens_row_px": 20 + 0.6 * beside, "lens_column_px": 1 - 0.8 * beside}
    if not words:
        sector_limits.check_lens(numbers, known, name="run", columns=64)
        return
    with pytest.raises(EstimationError, match=words):
        sector_limits.check_lens(numbers, known, name="run", columns=64)


@pytest.mark.parametrize(
    ("change", "is_one"),
    [
        ({}, True),
        ({"outer_radius_px": 12.9}, False),
        ({"opening_angle_rad": 0.09}, False),
        ({"offset_row_px": 9.1}, False),
    ],
)
def test_what_is_no_sector_is_refused(change, is_one):
    """Oracle: by hand; three pixels of radius at least, a tenth of a radian, less than a third of the radius beside the axle."""
    numbers = {
        "inner_radius_px": 10.0,
        "outer_radius_px": 30.0,
        "opening_angle_rad": 1.0,
        "offset_row_px": 8.9,
    } | change
    numbers["offset_column_px"] = 0.0
    with nullcontext() if is_one else pytest.raises(EstimationError, match="does not look like an annular sector"):
        sector_limits.check(numbers, "run")
