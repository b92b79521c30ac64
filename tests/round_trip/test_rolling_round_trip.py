"""From a simulated microbolometer camera with known truth to its timing: the twin and the estimator share no formula."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming import measurement
from irtiming.errors import EstimationError
from irtiming.estimate import timing
from irtiming.records.choices import Choices
from irtiming.records.recording import Recording
from irtiming.reduce import recipes
from irtiming.twin import rig as twin
from irtiming.twin.defects import Defects, with_defects
from irtiming.twin.scene import Faults, microbolometer_scene, with_wheel_speed
from irtiming.twin.upkeep import Drift, SelfCorrection, ShutterEvent

SMALL = microbolometer_scene(72, 96)
BASE = with_wheel_speed(
    replace(SMALL, optics=replace(SMALL.optics, wheel_centre_row_px=SMALL.optics.wheel_centre_row_px + 3)),
    3.0,
    samples=500,
)
SCENES = {
    "rows from the top": BASE,
    "rows from the bottom, warm blackbody, counterclockwise, lost frames": replace(
        BASE,
        timing=replace(BASE.timing, trigger_delay_s=9e-3, row_delay_s=-60e-6),
        radiance=replace(BASE.radiance, blackbody_k=306.15),
        wheel=replace(BASE.wheel, rotation="counterclockwise"),
        faults=Faults(lost_frames=30),
    ),
    "shutter, drift, dead pixels, noise of rows, slow lag": replace(
        BASE,
        correction=SelfCorrection(events=(ShutterEvent(start_s=7.0, level_jump_dn=12.0),)),
        drift=Drift(per_second_dn=0.6, settling_dn=25.0, settling_time_s=8.0),
        detector=replace(BASE.detector, dead_pixels=12, row_noise_dn=3.0),
        timing=replace(BASE.timing, time_constant_s=11e-3, row_delay_s=90e-6),
    ),
}
NAMES = ("trigger_delay", "time_constant", "row_delay")
MEMORY = "recursive_filter"


TURNED_RAD = np.radians(40)
BLURRED = replace(
    BASE,
    optics=replace(
        BASE.optics, blur_rows_px=0.55, blur_columns_px=0.95, blur_turn_rad=TURNED_RAD, glare_share=0.03, glare_px=5.0
    ),
)


def _truth(timing):
    """Of NAMES in their order, s, and last the share of the frame before: the twin's camera keeps none."""
    return np.array([timing.trigger_delay_s, timing.time_constant_s, timing.row_delay_s, 0.0])


def _fit(rig, *recordings):
    reduced = [recipes.reduce(one, rig.measured, choices=Choices()) for one in recordings]
    return timing.estimate(reduced, rig.measured)


@pytest.mark.parametrize("name", SCENES)
def test_truth_lies_within_the_stated_uncertainty(name):
    """Oracle: the scene; rig.toml is off by its stated uncertainties, and 3.5 of them leave one chance in 2000."""
    rig = twin.draw(SCENES[name], seed=41)
    found = _fit(rig, twin.simulate(rig.scene, seed=7))
    estimate = found.found.result.estimate
    assert estimate.names == (*NAMES, MEMORY)
    off = np.abs(estimate.values - _truth(rig.scene.timing)) / estimate.standard_uncertainties
    assert np.all(off < 3.5), off
    lag = (
        rig.scene.timing.time_constant_s / BASE.timing.time_constant_s
    )  # a slower camera shows less of the filter in it
    assert np.all(estimate.standard_uncertainties < np.array([70e-6, 30e-6 * lag**2, 1.1e-6, 0.01]))
    axle = found.recordings[0].axle
    assert axle.row_px == pytest.approx(rig.scene.optics.wheel_centre_row_px, abs=0.05)
    assert axle.column_px == pytest.approx(rig.scene.optics.wheel_centre_column_px, abs=0.05)
    assert found.sectors[0].shape.blur_px == pytest.approx(rig.scene.optics.blur_px, abs=0.06)
    assert found.sectors[0].shape.mirrored == ("counterclockwise" in name)
    assert found.fits[0].variance_inflation < 4


def test_blur_along_a_diagonal_and_glare_do_no_harm():
    """Oracle: the scene, whose light the twin spreads by tables: 3 % in an exponential tail, for which the fit has a Gaussian.

    The blur's axes are turned by 40 degrees; the covariance is half the variances' difference, nearly.
    """
    rig = twin.draw(BLURRED, seed=41)
    found = _fit(rig, twin.simulate(rig.scene, seed=7))
    estimate, (sector, *_) = found.found.result.estimate, found.sectors
    for name, true in zip((*NAMES, MEMORY), _truth(rig.scene.timing), strict=True):
        assert abs(estimate.value(name) - true) < 3.5 * estimate.u(name)
    assert estimate.u("time_constant") < 30e-6
    mean_px2, half_px2 = (0.95**2 + 0.55**2) / 2, (0.95**2 - 0.55**2) / 2
    blur, apart_px2 = sector.shape.blur, half_px2 * np.cos(2 * TURNED_RAD)
    assert (blur.rows_px, blur.columns_px) == pytest.approx(
        np.sqrt([mean_px2 - apart_px2, mean_px2 + apart_px2]), abs=0.06
    )
    assert blur.covariance_px2 == pytest.approx(half_px2 * np.sin(2 * TURNED_RAD), abs=0.06)
    assert 0.015 < sector.shape.glare < 0.035
    assert not [one for one in found.found.result.findings if one.code == "image-not-explained"]


def test_several_wheel_speeds_and_delays_from_end_to_end():
    """Oracle: the scene and the trigger generator; angle errors of 30 us drop out between 3 and 7 Hz, 20 ms were set once.

    The camera's kind decides what is analysed; both methods' results are there, and the choice names the one that counts.
    """
    rig = twin.draw(BASE, seed=5)
    fast = with_wheel_speed(rig.scene, 7.0, samples=500)
    recordings = [*twin.series(rig.scene, [0.0, 0.02], repeats=1, seed=3), twin.simulate(fast, seed=9, name="fast")]
    analysis = measurement.analyse(recordings, rig.measured, extras=("published",))
    assert (analysis.camera_type, analysis.readout_mode) == ("microbolometer", "rolling")
    estimate = analysis.best.estimate
    off = np.abs(estimate.values - _truth(rig.scene.timing)) / estimate.standard_uncertainties
    assert np.all(off < 3.5), off
    assert estimate.standard_uncertainties[0] < 15e-6
    told = {one.nominal_s: one for one in analysis.best.relative_delays if "fast" not in one.file}
    assert set(told) == {0.0, 0.02}
    assert abs(told[0.02].value_s - 0.02) < 3.5 * told[0.02].standard_uncertainty_s
    assert told[0.02].standard_uncertainty_s < 15e-6
    assert analysis.result is analysis.best
    assert replace(analysis, choices=Choices(method="published")).result is analysis.published.result
    assert analysis.published.result.estimate.names == NAMES
    assert [one.rotation_speed_hz for one in analysis.recordings] == pytest.approx([3.0, 3.0, 7.0], abs=1e-3)
    assert len(analysis.fits) == len(analysis.published.fits) == 3
    assert set(analysis.result.findings) <= set(analysis.findings)


def test_nothing_and_the_same_twice_are_refused(monkeypatch):
    """Oracle: by hand; a recording is known by its checksum, before its frames are read again."""
    monkeypatch.setattr(recipes, "reduce", lambda recording, *_, **__: recording)
    monkeypatch.setattr(Recording, "opening", None, raising=False)
    rig = twin.draw(BASE, seed=41)
    one = replace(twin.simulate(rig.scene, seed=7), sha256="a" * 64)
    with pytest.raises(EstimationError, match="are the same recording"):
        measurement.analyse([one, replace(one, name="again")], rig.measured)
    with pytest.raises(EstimationError, match="no recording given"):
        measurement.analyse([], rig.measured)


def test_a_response_that_is_not_linear_is_told_at_two_speeds():
    """Oracle: the scene; values that go with the signal to the power 0.9 were edges that disagree, or did not settle."""
    rig = twin.draw(with_wheel_speed(microbolometer_scene(60, 80), 3.0, samples=300), seed=41)
    bent = with_defects(rig.scene, Defects(exponent=0.9))
    runs = [
        twin.simulate(with_wheel_speed(bent, hz, samples=300), seed=round(hz), name=f"{hz} Hz") for hz in (3.0, 8.0)
    ]
    result = _fit(rig, *runs).found.result
    estimate = result.estimate
    off = np.abs(estimate.values - _truth(rig.scene.timing)) / estimate.standard_uncertainties
    assert np.all(off < 3), off
    assert "response-not-linear" in {one.code for one in result.findings}
