"""A frame that is read when the next trigger has come; what recordings cannot check."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import doubts, on_trust
from irtiming.records.estimate import Estimate
from irtiming.records.rig import Latency, LightGates, MaskOpening, Measured, Rig

HZ, PERIOD_TICKS = 1e6, 33_000
RIG = Rig(
    light_gates=LightGates(half_separation_m=Measured(13e-3), height_difference_m=Measured(5e-3), whole_slots_between=9),
    mask_opening=MaskOpening(opening_angle_rad=Measured(1.3), centre_angle_rad=Measured(-1.57, 5e-4)),
)  # fmt: skip


def _recording(*, wheel_hz=3.0, lost=(), window_s=None, learned=True):
    track = SimpleNamespace(
        clock_frequency_hz=HZ, angular_frequency_rad_per_s=2 * np.pi * wheel_hz, has_learned_slots=learned
    )
    return SimpleNamespace(
        trigger_ticks=np.delete(7000 + PERIOD_TICKS * np.arange(50), lost), track=track, events=None, camera_type="photon",
        opening=SimpleNamespace(mask=np.zeros((101, 40), bool)), integration_time_s=window_s,
    )  # fmt: skip


def _result(delay_s, row_s=None):
    names = ("trigger_delay",) if row_s is None else ("trigger_delay", "row_delay")
    values = np.array([delay_s, row_s][: len(names)])
    return SimpleNamespace(
        estimate=Estimate(names=names, units=("s",) * len(names), values=values, covariance=1e-12 * np.eye(len(names)))
    )


@pytest.mark.parametrize(
    ("delay_s", "row_s", "is_told"),
    [
        (32.9e-3, None, False),
        (33.0e-3, None, True),
        (33.4e-3, 30e-6, True),
        (36.4e-3, -34.1e-6, False),
        (36.5e-3, -34.9e-6, True),
    ],
)
def test_a_first_row_after_the_next_trigger_is_a_doubt(delay_s, row_s, is_told):
    """Oracle: by hand; triggers are 33 ms apart, lost frames change nothing; 100 rows of -34.1 us are 3.41 ms."""
    found = doubts.of_next_trigger(_result(delay_s, row_s), recordings=[_recording(lost=(7, 20, 21))])
    assert [(one.code, one.severity) for one in found] == [("delay-beyond-next-trigger", "doubt")] * is_told


def test_what_one_speed_leaves_unchecked_is_listed_and_several_check_angles():
    """Oracle: an angle that is wrong shifts a delay by angle / speed, which two speeds tell from a delay."""
    (one,) = on_trust.of([_recording(window_s=250e-6)], rig=replace(RIG, latency=Latency(trigger_s=Measured(0.0))))
    (two,) = on_trust.of([_recording(), _recording(wheel_hz=5.0)], rig=RIG)
    assert one.severity == two.severity == "info"
    for words in ("centre_angle_deg", "whole_slots_between", "count_time", "[latency]"):
        assert words in one.what
        assert words not in two.what
    assert "trigger_delay_time_set" in one.what
    assert "trigger_delay_time_set" in two.what


def test_an_integration_time_that_frames_hardly_tell_stays_on_trust():
    """Oracle: the rule; several speeds check angles, the window's length only where its corners show."""
    two = [_recording(window_s=250e-6), _recording(window_s=250e-6, wheel_hz=5.0)]
    assert "count_time" in on_trust.of(two, rig=RIG)[0].what
    assert "count_time" not in on_trust.of(two, rig=RIG, is_length_checked=True)[0].what


def test_a_ruler_checks_the_slots():
    """Oracle: one slot more moves the beam by some millimetres, which a ruler tells."""
    ruled = replace(RIG, light_gates=replace(RIG.light_gates, height_m=47e-3))
    assert "whole_slots_between" not in on_trust.of([_recording()], rig=ruled)[0].what


def test_slots_that_no_turns_told_are_taken_as_regular_on_trust():
    """Oracle: by hand; one recording of two has fewer than the nine turns that are needed to learn them."""
    (learned,) = on_trust.of([_recording(), _recording()], rig=RIG)
    (one_is_short,) = on_trust.of([_recording(), _recording(learned=False)], rig=RIG)
    assert "slots are regular" not in learned.what
    assert "slots are regular" in one_is_short.what
