"""Openings that no camera shows are refused with what they are."""

from contextlib import nullcontext

import pytest

from irtiming.errors import EstimationError
from irtiming.estimate import sector_limits
from irtiming.physics.edge_motion import Contradiction


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


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"opening_angle_rad": -1e-9}, "no radii and no angle fit"),
        ({"inner_radius_px": 31.0}, "no radii and no angle fit"),
        ({"inner_radius_px": 28.0}, "it would be 2.0 px, more than 3 must be"),
        ({"opening_angle_rad": 0.09}, "it would be 5.2 deg wide, from 5.7 to 180 deg must be"),
        ({"offset_row_px": 9.1}, "its centre would lie 9.1 px beside the axle, at most 9.0 px can be"),
    ],
)
def test_a_refusal_states_what_cannot_be(change, words):
    """Oracle: by hand; an angle below zero, or an inner radius beyond the outer one, is no number of an opening."""
    numbers = {"inner_radius_px": 10.0, "outer_radius_px": 30.0, "opening_angle_rad": 1.0, "offset_row_px": 0.0}
    with pytest.raises(EstimationError, match=words):
        sector_limits.check(numbers | change | {"offset_column_px": 0.0}, "run")


@pytest.mark.parametrize(
    "refused",
    [
        sector_limits.check,
        lambda numbers, name, sense: sector_limits.check_lens(numbers, numbers, name=name, columns=64, sense=sense),
    ],
    ids=["sector", "lens"],
)
def test_a_contradicted_rotation_is_why_there_is_no_sector(refused):
    """Oracle: where edges move against the stated rotation, the refusal says that instead of what else does not fit."""
    sense = Contradiction(way="up", stated="[wheel] rotation = 'clockwise' with [mask] centre_angle_deg = 0")
    numbers = dict.fromkeys(("inner_radius_px", "outer_radius_px", "opening_angle_rad", "offset_row_px"), 1.0)
    numbers |= {"offset_column_px": 0.0, "distortion": -1.0, "lens_row_px": 0.0, "lens_column_px": 0.0}
    words = "run: the image shows edges that move up; .* = 0 means the other way: correct one of them, or the image is mirrored"
    with pytest.raises(EstimationError, match=words):
        refused(numbers, "run", sense=lambda: sense)
