"""Runs of a series: from a plan file, found for wishes, and chosen by number."""

import json
from dataclasses import replace
from fractions import Fraction

import pytest

from irtiming.errors import PlanError
from irtiming.records.series_plan import CameraWishes, DeviceAddresses, SeriesPlan, TriggerWishes
from irtiming.session.triggers import chosen_runs, exact, triggers_of


def _plan(**about):
    wishes = TriggerWishes(wheel_hz=("3", "9"), frame_hz="30.303", samples="1000", **about)
    return SeriesPlan(
        devices=DeviceAddresses(camera="gige:1", trigger_generator="/dev/null"),
        camera=CameraWishes(camera_type="photon"),
        triggers=wishes,
        file_name="{run}.nxs",
    )


def test_wishes_become_runs_for_the_generators_clock():
    """Oracle: two speeds, two delays and two repeats of the paper's scheme: four runs of 2000 triggers."""
    plan = triggers_of(_plan(delays=("0 s", "25 ms"), repeats="2"), clock_frequency_hz=49_152_000)
    assert plan.clock_frequency_hz == 49_152_000
    assert [(run.trigger_delay_ticks, run.repeats) for run in plan] == [(0, 2), (1_228_800, 2)] * 2
    for run in plan:
        assert run.scheme.samples_per_turn == pytest.approx(1000, rel=0.01)
    rates = [49_152_000 / scheme.turn_period_ticks for scheme in plan.schemes]
    assert rates == pytest.approx([3, 9], rel=0.01)


def test_a_delay_that_no_recording_holds_is_refused_before_it_is_recorded():
    """Oracle: the limit of trigger_delay_time_set in a recording, 60 s."""
    assert exact(_plan(delays=("60 s",)).triggers, clock_frequency_hz=49_152_000).trigger_delays_s == (60,)
    with pytest.raises(PlanError, match=r"the trigger delay is 61 s, must be at most 60 s"):
        exact(_plan(delays=("61 s",)).triggers, clock_frequency_hz=49_152_000)


def test_a_plan_file_is_read(tmp_path):
    """Oracle: the numbers in the file."""
    run = {
        "turn_period_ticks": 4_000_000, "camera_period_ticks": 1_560_000, "control_slots": 100, "trigger_delay_ticks": 0,
        "repeats": 1, "is_after_correction": False,
    }  # fmt: skip
    path = tmp_path / "plan.json"
    path.write_text(json.dumps({"clock_frequency_hz": 48_000_000, "plan": {"runs": [run]}}))
    plan = SeriesPlan(
        devices=DeviceAddresses(camera="gige:1", trigger_generator="/dev/null"),
        camera=CameraWishes(camera_type="photon"),
        plan_file=str(path),
        file_name="{run}.nxs",
    )
    assert triggers_of(plan, clock_frequency_hz=1).runs[0].scheme.camera_period_ticks == 1_560_000


def test_runs_are_chosen():
    """Oracle: by hand."""
    assert chosen_runs("2", 5) == {2}
    assert chosen_runs("1,3-5", 5) == {1, 3, 4, 5}


@pytest.mark.parametrize("text", ["", "a", "0", "6", "3-1", "1-", "²", "1-999999999", "9" * 5000])
def test_runs_that_are_not_there_are_refused(text):
    """Oracle: a series of five."""
    with pytest.raises(PlanError, match="--runs"):
        chosen_runs(text, 5)


def test_limits_that_are_not_stated_follow_from_the_tolerance():
    """Oracle: by hand; 2 % of 3 Hz and 1 % of 30 Hz, half and double of the samples where the frame rate is exact."""
    asked = TriggerWishes(
        wheel_hz=("3",), frame_hz="30", samples="1000", wheel_tolerance="2%", samples_limits=(None, "1100")
    )
    found = exact(asked, clock_frequency_hz=48_000_000)
    assert (found.wheel_rates_hz[0].lowest, found.wheel_rates_hz[0].highest) == (Fraction("2.94"), Fraction("3.06"))
    assert (found.frame_rate_hz.lowest, found.frame_rate_hz.highest) == (Fraction("29.7"), Fraction("30.3"))
    assert (found.samples_per_turn.lowest, found.samples_per_turn.highest) == (990, 1100)
    assert found.clock_frequency_hz == 48_000_000
    strict = exact(replace(asked, frame_hz_exact=True, samples_limits=(None, None)), clock_frequency_hz=1)
    assert strict.frame_rate_hz.lowest == strict.frame_rate_hz.highest == 30
    assert (strict.samples_per_turn.lowest, strict.samples_per_turn.highest) == (500, 2000)
