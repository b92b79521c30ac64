"""Proposals for a wanted uncertainty."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from irtiming.errors import PlanError, UnitError
from irtiming.plan.assumptions import USUAL_RIG, assumed
from irtiming.plan.photon_information import KNOWN_WINDOW
from irtiming.plan.prediction import Setting, uncertainties
from irtiming.plan.proposals import propose, usual_speeds
from irtiming.plan.targets import Target, targets
from irtiming.plan.wishes import wish_around
from irtiming.records.camera_description import Microbolometer, PhotonCamera
from irtiming.records.rig import Clock, Latency, Measured

SMALL = PhotonCamera(opening_pixels=1200.0)
CLOCK_HZ = 49_152_000


def _setting(camera=SMALL, rig=None, **changes):
    return Setting(camera=camera, rig=assumed(rig, camera), clock_frequency_hz=CLOCK_HZ, **changes)


def _wishes(*speeds, **changes):
    usual = usual_speeds()
    rates = tuple(wish_around(Fraction(speed), Fraction(1, 100)) for speed in speeds) or usual.wheel_rates_hz
    return replace(usual, wheel_rates_hz=rates, **changes)


def _target(name="trigger_delay", u=0.5e-6):
    return (Target(name=name, standard_uncertainty_s=u),)


def test_several_speeds_reach_what_no_single_one_can():
    """Oracle: 0.5 us is an angle of 0.16 mrad at 50 Hz, less than the 0.52 mrad of the mask; with two speeds angles drop out."""
    found = propose(_setting(structure=KNOWN_WINDOW), _wishes(), targets=_target())
    assert all(len(each.plan.schemes) > 1 for each in found.best)
    assert all(each.uncertainties[0].standard_uncertainty_s <= 0.5e-6 for each in found.best)
    (alone,) = found.one_speed.uncertainties
    assert alone.standard_uncertainty_s > np.radians(0.03) / (2 * np.pi * 51)
    assert alone.largest_part.source in ("mask centre angle phi_M", "mask beside the axle (image)")


def test_what_one_speed_cannot_reach_is_said_with_its_cause_and_its_cure():
    """Oracle: 0.03 degrees of the mask at 3 Hz are 28 us; the cure is more than one speed."""
    camera = PhotonCamera()
    with pytest.raises(
        PlanError, match=r"cannot be reached: at best 31 µs with 3 Hz .* phi_M makes 28 µs; .* at several: take"
    ):
        propose(_setting(camera), _wishes(3), targets=_target())


def test_where_noise_is_the_limit_more_speeds_are_no_cure():
    """Oracle: a tenth of a nanosecond is below what a hundred runs of each of four speeds tell."""
    with pytest.raises(PlanError, match="noise of the frames makes .*; take more pixels, more contrast"):
        propose(_setting(structure=KNOWN_WINDOW), _wishes(), targets=_target(u=1e-10))


def test_runs_are_as_many_as_noise_asks_for():
    """Oracle: relative delays at one speed have noise alone, so u falls with the root of the runs: the fewest that do."""
    wishes = _wishes(3, trigger_delays_s=(Fraction(0), Fraction(1, 40)))
    setting = _setting(rig=replace(USUAL_RIG, clock=Clock(relative_error=Measured(0.0))))
    (scheme,) = propose(setting, wishes, targets=_target("relative_delay", 1e-4)).best[0].plan.schemes
    one = uncertainties([(setting.one_run(scheme), 1)], ["relative_delay"], n_delays=2)[0].standard_uncertainty_s
    found = propose(setting, wishes, targets=_target("relative_delay", one / 2.9)).best[0]
    assert found.runs_of_each == (9,)
    assert found.uncertainties[0].standard_uncertainty_s == pytest.approx(one / 3, rel=1e-3)
    assert found.duration_s == pytest.approx(9 * 2 * 33 + 0.025)
    assert [(run.trigger_delay_ticks, run.repeats) for run in found.plan] == [(0, 9), (1_228_800, 9)]


def test_the_shortest_comes_first_and_all_targets_are_met():
    """Oracle: the definition of a proposal."""
    asked = (*_target(u=0.2e-6), *_target("exposure_midpoint_delay", 0.05e-6), *_target("integration_time", 0.5e-6))
    found = propose(_setting(PhotonCamera()), _wishes(), targets=asked, most=5)
    assert len(found.best) == 5
    for each in found.best:
        for got, target in zip(each.uncertainties, asked, strict=True):
            assert got.name == target.name
            assert got.standard_uncertainty_s <= target.standard_uncertainty_s
    durations = [each.duration_s for each in found.best]
    assert durations[0] <= 1.02 * min(durations)
    assert durations == pytest.approx(sorted(durations), rel=0.02)


def test_a_small_microbolometer_is_planned_for_row_delay_and_time_constant():
    """Oracle: both shrink with a faster wheel, and no angle touches them.

    For the row delay one run at one speed will do. A time constant is told from a filter over frames by two speeds, between which
    the echo of the frame before moves and the lag's tail does not; one speed alone takes several runs.
    """
    setting = _setting(Microbolometer(opening_pixels=2000.0))
    row_delay, both = _target("row_delay", 0.1e-6), (*_target("row_delay", 0.1e-6), *_target("time_constant", 3e-6))
    found = propose(setting, _wishes(3, 10), targets=row_delay).best[0]
    assert found.runs_of_each == (1,)
    assert CLOCK_HZ / found.plan.schemes[0].turn_period_ticks == pytest.approx(10, rel=0.01)
    assert propose(setting, _wishes(3, 10), targets=both).best[0].runs_of_each == (1, 1)
    assert propose(setting, _wishes(10), targets=both).best[0].runs_of_each[0] > 2


def test_a_wheel_too_fast_for_the_integration_is_left_out():
    """Oracle: 15 degrees of plateau last 0.83 ms at 50 Hz."""
    setting = _setting(PhotonCamera(integration_time_s=2e-3))
    with pytest.raises(PlanError, match="wholly open for 833.* 2 ms; turn the wheel more slowly"):
        propose(setting, _wishes(50), targets=_target())
    found = propose(setting, _wishes(3, 12, 50), targets=_target(u=2e-6))
    rates = {round(CLOCK_HZ / s.turn_period_ticks) for each in found.best for s in each.plan.schemes}
    assert rates == {3, 12}


def test_what_the_rig_states_is_taken_and_what_it_does_not_is_said():
    """Oracle: the rig's own numbers."""
    stated = replace(
        USUAL_RIG,
        wheel=replace(USUAL_RIG.wheel, cutout_edges_rad=tuple(Measured(k * np.pi / 2, 3e-5) for k in range(4))),
    )
    found = assumed(stated, SMALL)
    assert [text.split(":")[0] for text in found.remarks] == ["No [latency] known"]
    assert found.angles.edge_rad == pytest.approx(3e-5)
    assert dict(found.angles.common)["mask centre angle phi_M"] == pytest.approx(np.radians(0.03))
    exact = replace(USUAL_RIG, mask_opening=replace(USUAL_RIG.mask_opening, centre_angle_rad=Measured(-np.pi / 2)))
    assert any("phi_M counts as exact" in text for text in assumed(exact, SMALL).remarks)
    assert any("No rig.toml" in text for text in assumed(None, SMALL).remarks)


def test_latencies_and_clock_stay_however_many_runs():
    """Oracle: squares add by hand; 0.4 us of the gate and 0.3 us of the trigger path in a delay, 50 ppm / sqrt(3) in 100 ms."""
    late = Latency(application_gate_s=Measured(5e-6, 0.4e-6), trigger_s=Measured(1e-6, 0.3e-6))
    exact = replace(USUAL_RIG, clock=Clock(relative_error=Measured(0.0)))
    asked = _target("trigger_delay", 2e-6) + _target("relative_delay", 1e-5)
    wishes = _wishes(3, 12, trigger_delays_s=(Fraction(0), Fraction(1, 10)))
    found = [
        {
            one.name: one.standard_uncertainty_s
            for one in propose(_setting(rig=rig), wishes, targets=asked).best[0].uncertainties
        }
        for rig in (exact, replace(USUAL_RIG, latency=late))
    ]
    assert found[1]["trigger_delay"] == pytest.approx(np.hypot(found[0]["trigger_delay"], 0.5e-6))
    assert found[1]["relative_delay"] == pytest.approx(np.hypot(found[0]["relative_delay"], 5e-6 / np.sqrt(3)))
    (trigger, *_) = propose(_setting(rig=replace(USUAL_RIG, latency=late)), wishes, targets=asked).best[0].uncertainties
    assert {part.source for part in trigger.parts} >= {"latency of the application gate", "latency of the trigger path"}


def test_a_stated_integration_time_helps_the_start():
    """Oracle: by hand; a window known to 1 us leaves that of itself; its tail, unknown then, shifts the middle by little."""
    known = replace(USUAL_RIG, camera=replace(USUAL_RIG.camera, integration_time_u_s=1e-6))
    names = ["trigger_delay", "exposure_midpoint_delay", "integration_time"]
    (scheme,) = propose(_setting(), _wishes(3), targets=_target(u=1e-4)).best[0].plan.schemes
    bare, told = (
        {one.name: one.standard_uncertainty_s for one in uncertainties([(setting.one_run(scheme), 1)], names)}
        for setting in (_setting(), _setting(rig=known))
    )
    assert told["integration_time"] < 1e-6 < bare["integration_time"]
    assert told["exposure_midpoint_delay"] <= 1.001 * bare["exposure_midpoint_delay"]


def test_targets_are_read_with_their_units():
    """Oracle: by hand."""
    found = targets(["trigger_delay=0.5us", "relative_delay = 200 ns"], SMALL)
    assert [(each.name, each.standard_uncertainty_s) for each in found] == [
        ("trigger_delay", pytest.approx(5e-7)),
        ("relative_delay", pytest.approx(2e-7)),
    ]


@pytest.mark.parametrize(
    ("texts", "error", "message"),
    [
        (["trigger_delay"], PlanError, "such as 'trigger_delay=0.5us'"),
        (["triger_delay=1us"], PlanError, "did you mean trigger_delay"),
        (["row_delay=1us"], PlanError, "this camera has trigger_delay"),
        (["trigger_delay=0 us"], PlanError, "greater than 0"),
        (["trigger_delay=-1 us"], PlanError, "greater than 0"),
        (["trigger_delay=5"], UnitError, "has no unit"),
        (["trigger_delay=1us", "trigger_delay=2us"], PlanError, "twice"),
    ],
)
def test_targets_that_make_no_sense_are_refused(texts, error, message):
    """Oracle: the parameters of a photon camera."""
    with pytest.raises(error, match=message):
        targets(texts, SMALL)


@pytest.mark.parametrize("name", ["noise_to_contrast", "opening_pixels", "integration_time_s"])
@pytest.mark.parametrize("number", [0.0, -1.0, float("nan"), float("inf")])
def test_a_camera_that_cannot_be_is_refused(name, number):
    """Oracle: all three are positive and finite."""
    with pytest.raises(PlanError, match="greater than 0 and finite"):
        PhotonCamera(**{name: number})
