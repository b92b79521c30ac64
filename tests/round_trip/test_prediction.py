"""From planning to outcome: what the recordings should tell against what the estimation states of them."""

import json

import pytest

from irtiming.archive.json_file import plain
from irtiming.measurement import analyse
from irtiming.report import certificate
from irtiming.report.sections import uncertainty
from irtiming.session.camera import Described, camera
from irtiming.twin import rig as twin
from irtiming.twin.cameras import camera_scene
from irtiming.twin.scene import microbolometer_scene, paper_scene, with_wheel_speed


@pytest.fixture(scope="module")
def photon():
    """A small simulated camera at two wheel speeds."""
    rig = twin.draw(paper_scene(72, 96), seed=2)
    recordings = [
        recording
        for k, speed in enumerate((3.0, 12.0))
        for recording in twin.series(with_wheel_speed(rig.scene, speed, samples=300), (0.0,), repeats=1, seed=20 + k)
    ]
    return analyse(recordings, rig.measured, extras=("prediction",))


@pytest.mark.slow
def test_stated_uncertainties_are_those_that_noise_and_rig_allow(photon):
    """Oracle: the Fisher information of the model with the noise as found; no line of the estimation takes part in it."""
    estimate = photon.best.estimate
    stated = dict(zip(estimate.names, estimate.standard_uncertainties, strict=True))
    found = {each.name: each.standard_uncertainty_s for each in photon.prediction.uncertainties}
    for name in ("trigger_delay", "exposure_midpoint_delay"):
        assert stated[name] == pytest.approx(found[name], rel=0.15), name


@pytest.mark.slow
def test_the_report_compares_and_the_result_can_be_planned_with(photon, tmp_path):
    """Oracle: the twin's own noise, 20 DN of 4770 DN, within a tenth; the ratio of two numbers of the result."""
    found = certificate.report(photon)
    assert "Prediction and outcome" in found.page
    told = found.result["prediction"]
    delay = told["parameters"]["trigger_delay"]
    stated = found.result["parameters"]["trigger_delay"]["standard_uncertainty"]
    assert delay["ratio"] == pytest.approx(stated / delay["predicted_standard_uncertainty"])
    path = tmp_path / "result.json"
    path.write_text(json.dumps(plain(found.result)))
    again = camera(Described(like=path))
    assert again.noise_to_contrast == pytest.approx(20 / 4770, rel=0.1)
    assert again.opening_pixels == pytest.approx(432, rel=0.03)
    assert again.integration_time_s == 250e-6


@pytest.mark.slow
def test_a_microbolometer_states_what_noise_gains_and_rig_allow():
    """Oracle: the Fisher information of row sums and contrast image; the estimation judges the border by what it leaves over."""
    rig = twin.draw(with_wheel_speed(microbolometer_scene(60, 80), 3.0, samples=300), seed=1)
    done = analyse(twin.series(rig.scene, (0.0,), repeats=1, seed=1), rig.measured, extras=("prediction",))
    estimate = done.best.estimate
    stated = dict(zip(estimate.names, estimate.standard_uncertainties, strict=True))
    found = {each.name: each.standard_uncertainty_s for each in done.prediction.uncertainties}
    assert stated["trigger_delay"] == pytest.approx(found["trigger_delay"], rel=0.05)
    assert (
        0.85 < stated["row_delay"] / found["row_delay"] < 1.25
    )  # the image fit distrusts phases at the border, the plan does not
    assert 0.75 < stated["time_constant"] / found["time_constant"] < 1.1
    assert "Prediction and outcome" in [block.title for block in uncertainty.section(done).blocks]


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "readout"), [("photon", "rolling"), ("microbolometer", "snapshot")])
def test_cameras_whose_rows_are_summed_state_what_noise_gains_and_rig_allow(kind, readout):
    """Oracle: the Fisher information of row sums and contrast image; correlated residuals widen what is stated."""
    rig = twin.draw(camera_scene(kind, readout, rows=48, columns=64), seed=3)
    recordings = [
        recording
        for k, speed in enumerate((3.0, 12.0))
        for recording in twin.series(with_wheel_speed(rig.scene, speed, samples=300), (0.0,), repeats=1, seed=5 + k)
    ]
    done = analyse(recordings, rig.measured, extras=("prediction",))
    estimate = done.best.estimate
    stated = dict(zip(estimate.names, estimate.standard_uncertainties, strict=True))
    found = {each.name: each.standard_uncertainty_s for each in done.prediction.uncertainties}
    assert set(found) <= set(stated)
    assert ("row_delay" in found) == (readout == "rolling")
    for name, u in found.items():
        assert 0.8 < stated[name] / u < 1.35, name
