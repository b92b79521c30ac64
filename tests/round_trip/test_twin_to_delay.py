"""From a simulated rig with known truth to the delay: the twin and the estimator share no formula."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.measurement import analyse
from irtiming.twin import rig as twin
from irtiming.twin.scene import EdgeFaults, Faults, paper_scene, with_wheel_speed

BASE = with_wheel_speed(paper_scene(60, 80), 3.0, samples=300)
SCENES = {
    "as in the paper": BASE,
    "rolled camera, distorting lens, cold blackbody, counterclockwise, long delay": replace(
        BASE,
        optics=replace(BASE.optics, roll_rad=0.06, distortion=-0.05),
        radiance=replace(BASE.radiance, blackbody_k=287.0),
        wheel=replace(BASE.wheel, rotation="counterclockwise"),
        timing=replace(BASE.timing, trigger_delay_s=14e-3),
    ),
    "fast wheel, long integration, faults": replace(
        with_wheel_speed(BASE, 11.0, samples=300),
        timing=replace(BASE.timing, integration_time_s=3e-3, substeps=64),
        faults=Faults(
            lost_frames=20,
            control_slot=EdgeFaults(missing=12, doubled=3, spurious=3),
            application=EdgeFaults(missing=2),
        ),
    ),
}


@pytest.fixture(scope="module")
def analysed():
    """Rig and analysis of a scene at two delays that were set, made once."""

    def make(scene):
        rig = twin.draw(scene, seed=77)
        return rig, analyse(twin.series(rig.scene, [0.0, 0.025], repeats=1, seed=5), rig.measured)

    return cache(make)


@pytest.fixture(scope="module")
def two_speeds():
    """Rig, recordings at 3 and 9 Hz, and their analysis."""
    rig = twin.draw(BASE, seed=21)
    recordings = [twin.simulate(with_wheel_speed(rig.scene, hz, samples=400), seed=int(hz)) for hz in (3.0, 9.0)]
    return rig, recordings, analyse(recordings, rig.measured)


def test_a_mirror_image_on_one_end_of_the_opening_does_not_turn_the_mask():
    """Oracle: the mask as drawn; wheel and plate differ by 2 to 4 % of the contrast, most where the wheel mirrors the camera.

    Frames on plateaus, evened out by a polynomial, told the bisector 2.3 mrad away.
    """
    scene = with_wheel_speed(paper_scene(96, 120), 3.0, samples=200)
    optics = replace(scene.optics, wheel_centre_row_px=57.4, wheel_centre_column_px=47.8, distortion=-0.05)
    rig = twin.draw(replace(scene, optics=optics), seed=1)
    view = analyse(twin.series(rig.scene, [0.0], repeats=1, seed=5), rig.measured).recordings[0].axle
    truth = rig.scene.mask.centre_angle_rad + rig.scene.optics.roll_rad
    apart = np.angle(np.exp(1j * (view.bisector_rad - truth)))
    assert abs(apart) < 0.3e-3
    assert abs(apart) < 3 * view.u_off_axle_rad < 4e-3


@pytest.mark.parametrize("name", SCENES)
def test_truth_lies_within_the_stated_uncertainty(analysed, name):
    """Oracle: the scene; rig.toml is off by its stated uncertainties, and 3.5 of them leave one chance in 2000."""
    rig, analysis = analysed(SCENES[name])
    best = analysis.best.estimate
    values = dict(zip(best.names, best.values, strict=True))
    u = dict(zip(best.names, best.standard_uncertainties, strict=True))
    timing = rig.scene.timing
    assert abs(values["trigger_delay"] - timing.trigger_delay_s) < 3.5 * u["trigger_delay"]
    middle = timing.trigger_delay_s + timing.integration_time_s / 2
    assert abs(values["exposure_midpoint_delay"] - middle) < 3.5 * u["exposure_midpoint_delay"]
    u_mask = rig.measured.mask_opening.centre_angle_rad.standard_uncertainty
    assert (
        1 < u["trigger_delay"] * 2 * np.pi * rig.scene.trigger.wheel_hz / u_mask < 1.5
    )  # at one speed no better than phi_M
    _, second = analysis.best.relative_delays
    assert abs(second.value_s - 0.025) < 3.5 * second.standard_uncertainty_s
    assert second.standard_uncertainty_s < 4e-6


def test_lost_frames_do_not_move_the_delay(analysed):
    """Oracle: the same recordings whole; a tenth of their frames lost may cost noise, 0.7 us, and 0.02 px of the axle."""
    _, whole = analysed(BASE)
    _, lossy = analysed(replace(BASE, faults=Faults(lost_frames=30)))
    for one, other in zip(whole.recordings, lossy.recordings, strict=True):
        assert other.frame_index.size == one.frame_index.size - 30
        assert other.axle.column_px == pytest.approx(one.axle.column_px, abs=0.02)
        assert other.axle.row_px == pytest.approx(one.axle.row_px, abs=0.02)
    assert lossy.best.estimate.values[0] == pytest.approx(whole.best.estimate.values[0], abs=12e-6)


def test_both_methods_on_a_perfect_rig_of_a_third_of_the_papers_size():
    """Oracle: the scene; without any imperfection the published middle of the window is right to a few microseconds too.

    A third of its rows and columns: noise and pixels are within these limits, and the time goes with their number.
    """
    nothing = dict.fromkeys(
        (
            "cutout_error_rad",
            "slot_error_rad",
            "slot_eccentricity_rad",
            "beam_m",
            "mask_angle_rad",
            "mask_centre_m",
            "roll_rad",
        ),
        0.0,
    )
    perfect = twin.Tolerances(**nothing, ring_edge_rad=2e-4, u_beam_m=0.0, u_mask_angle_rad=0.0)
    scene = paper_scene(160, 200)
    scene = replace(scene, radiance=replace(scene.radiance, mask_k=scene.radiance.wheel_k, narcissus_dn=0.0))
    scene = with_wheel_speed(scene, 3.0, samples=250)
    rig = twin.draw(scene, seed=4, tolerances=perfect)
    analysis = analyse([twin.simulate(rig.scene, seed=4)], rig.measured, extras=("published",))
    truth = rig.scene.timing.trigger_delay_s
    for result, limit in ((analysis.best, 10e-6), (analysis.published.result, 15e-6)):
        k = result.estimate.names.index("trigger_delay")
        assert result.estimate.values[k] == pytest.approx(truth, abs=limit)
    falling, rising = (
        analysis.best.estimate.values[analysis.best.estimate.names.index(f"trigger_delay_{w}")]
        for w in ("falling", "rising")
    )
    assert falling - rising == pytest.approx(0, abs=3e-6)


def test_several_wheel_speeds_need_no_caliper(two_speeds):
    """Oracle: the scene; angle errors drop out between 3 and 9 Hz, so the delay is known to a few microseconds.

    That is without what pixels may remember of the frame before, which several speeds do not tell from a delay as well.
    """
    rig, _, analysis = two_speeds
    best = analysis.best
    estimate = best.estimate
    k = estimate.names.index("trigger_delay")
    lines = {line.source: line.standard_uncertainty["trigger_delay"] for line in best.budget}
    memory = lines.pop("share of the frame before in each frame")
    assert np.linalg.norm(list(lines.values())) < 2.5e-6
    assert memory < 10e-6
    assert estimate.standard_uncertainties[k] == pytest.approx(np.hypot(memory, np.linalg.norm(list(lines.values()))))
    u = estimate.standard_uncertainties[k]
    assert estimate.values[k] == pytest.approx(rig.scene.timing.trigger_delay_s, abs=2 * u)


def test_a_recording_that_does_not_tell_its_reference_edge_takes_that_of_the_others(two_speeds):
    """Oracle: the analysis of the recordings as they were; in one the edges beside the reference are put midway."""
    rig, (slow, fast), analysis = two_speeds
    edges, halves = slow.application_slot_ticks.copy(), np.diff(slow.application_slot_ticks)
    others = np.arange(1 if halves[::2].mean() > halves[1::2].mean() else 2, edges.size - 1, 2)
    edges[others] = (edges[others - 1] + edges[others + 1]) // 2
    alike = replace(slow, application_slot_ticks=edges)
    with pytest.raises(ReductionError, match="the reference edge cannot be determined"):
        analyse([alike], rig.measured)
    found, expected = analyse([alike, fast], rig.measured).best.estimate, analysis.best.estimate
    assert found.names == expected.names
    np.testing.assert_allclose(
        (found.values - expected.values) / expected.standard_uncertainties, 0, atol=0.5
    )  # half a turn would be millions


def test_no_order_of_files_changes_a_result(two_speeds):
    """Oracle: a law; recordings have no order of their own, so all digits of a result are the same in any.

    The opening is that of the first one, and each has its own noise: taken as they came, u differed by a tenth.
    """
    rig, recordings, analysis = two_speeds
    one, other = analysis.best.estimate, analyse(recordings[::-1], rig.measured).best.estimate
    np.testing.assert_array_equal(one.values, other.values)
    np.testing.assert_array_equal(one.covariance, other.covariance)
