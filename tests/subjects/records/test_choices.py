"""What a person may choose of an analysis, and what is refused before any frame is read."""

from types import SimpleNamespace

import pytest

from irtiming.errors import EstimationError, IrTimingError, UnitError
from irtiming.records.choices import Choices


def _recording(camera_type, readout_mode):
    return SimpleNamespace(name="r", camera_type=camera_type, readout_mode=readout_mode)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"threshold_level": 0.96}, "threshold_level is 0.96, must lie between 0.05 and 0.95"),
        ({"threshold_level": float("nan")}, "threshold_level is nan, must lie between 0.05 and 0.95"),
        ({"plateau_margin": -0.01}, "plateau_margin is -0.01, must lie between 0.0 and 0.45"),
        ({"slope_limits": (0.5, 0.5)}, "slope_limits is 0.5,0.5, must be two fractions with 0 < LOW < HIGH < 1"),
        ({"slope_limits": (0.1, 1.0)}, "slope_limits is 0.1,1, must be two fractions with 0 < LOW < HIGH < 1"),
        ({"roi": (5, 5, 0, 9)}, "roi is 5,5,0,9, must be R0,R1,C0,C1"),
        ({"roi": (-1, 5, 0, 9)}, "roi is -1,5,0,9, must be R0,R1,C0,C1"),
        (
            {"method": "pixel-sums"},
            "method is 'pixel-sums', must be pixel-sum or row-sum or published; did you mean 'pixel-sum'?",
        ),
        ({"method": None}, "method is 'None', must be pixel-sum or row-sum or published; name one of them"),
        ({"reference_edge": "third"}, "reference_edge is 'third', must be automatic or first or second"),
        ({"border_px": -1}, "border_px is -1, must be a whole number of pixels from 0 to 64"),
        ({"border_px": 65}, "border_px is 65, must be a whole number of pixels from 0 to 64"),
        ({"border_px": 2.5}, "border_px is 2.5, must be a whole number of pixels from 0 to 64"),
        ({"wheel_temperature_k": 300.0}, "wheel_temperature_k is of use with substrate_temperature_k only"),
    ],
)
def test_what_cannot_be_is_refused_by_its_name(wrong, says):
    """Oracle: the limits by hand, one wrong choice at a time."""
    with pytest.raises(UnitError) as refused:
        Choices(**wrong)
    assert says in str(refused.value)


@pytest.mark.parametrize(
    "right",
    [
        {"threshold_level": 0.95},
        {"plateau_margin": 0.0},
        {"plateau_margin": 0.45},
        {"roi": (0, 1, 0, 1)},
        {"border_px": 0},
        {"border_px": 64},
    ],
)
def test_limits_belong_to_what_may_be_chosen(right):
    """Oracle: by hand."""
    for name, value in right.items():
        assert getattr(Choices(**right), name) == value


@pytest.mark.parametrize("kind", [("microbolometer", "rolling"), ("microbolometer", "snapshot"), ("photon", "rolling")])
def test_choices_for_pixel_sums_mean_something_for_snapshot_photon_cameras_only(kind):
    """Oracle: the recipes: every other camera is reduced to row sums, without threshold, plateaus and slopes."""
    chosen = Choices(threshold_dn=5.0, slope_limits=(0.1, 0.9))
    chosen.check_for(_recording("photon", "snapshot"))
    with pytest.raises(
        EstimationError, match=r"threshold_dn, slope_limits with r, the recording of a .*; leave them out"
    ):
        chosen.check_for(_recording(*kind))
    Choices(threshold_level=0.4, border_px=3, roi=(0, 2, 0, 2)).check_for(_recording(*kind))


def test_time_constants_are_those_of_a_microbolometer():
    """Oracle: by hand; a photon camera has none."""
    chosen = Choices(substrate_temperature_k=300.0, wheel_temperature_k=295.0)
    for readout in ("snapshot", "rolling"):
        chosen.check_for(_recording("microbolometer", readout))
        with pytest.raises(EstimationError, match="a photon camera, which has no time constants; leave it out"):
            chosen.check_for(_recording("photon", readout))


def test_a_door_calls_the_fields_by_its_own_names():
    """Oracle: by hand; what a brace in a name of a file says is left alone."""
    with pytest.raises(IrTimingError) as refused:
        Choices(wheel_temperature_k=300.0)
    refused.value.call_fields(str.upper)
    assert str(refused.value).startswith("WHEEL_TEMPERATURE_K is of use with SUBSTRATE_TEMPERATURE_K only")
    error = EstimationError("{a} with {run}.nxs, {b}", "a", "b", where="file")
    assert str(error) == "file: a with {run}.nxs, b"
    error.call_fields(str.upper)
    assert (str(error), error.where, error.what) == ("file: A with {run}.nxs, B", "file", "A with {run}.nxs, B")
