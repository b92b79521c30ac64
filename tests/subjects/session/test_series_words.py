"""What is said while a series is recorded."""

from irtiming.session.live_estimate import LiveEstimate
from irtiming.session.series_words import so_far


def test_an_estimate_in_words_has_times_as_times_and_shares_as_shares():
    """Oracle: the numbers by hand; a share is no time and never stands in microseconds."""
    found = LiveEstimate(
        frames=771,
        values={"trigger_delay": 360e-6, "pixel_memory": -340e-6, "exposure_midpoint_delay": 1.0},
        uncertainties={"trigger_delay": 30e-6, "pixel_memory": 230e-6, "exposure_midpoint_delay": 1.0},
    )
    assert so_far(found) == "trigger_delay 360 ± 30 µs, pixel_memory −0.034 ± 0.023 %, from 771 frames"


def test_what_the_uncertainty_does_not_hold_stands_behind_the_numbers():
    """Oracle: the words behind the first number of a report, which `outside.behind` makes too."""
    found = LiveEstimate(
        frames=125,
        values={"trigger_delay": 360e-6},
        uncertainties={"trigger_delay": 30e-6},
        not_in_uncertainty=("latency of the trigger path", "lateral offset of the beams"),
    )
    words = "not in u: latency of the trigger path; lateral offset of the beams"
    assert so_far(found) == f"trigger_delay 360 ± 30 µs, from 125 frames ({words})"
