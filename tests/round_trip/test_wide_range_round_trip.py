"""From a simulated camera whose pixels radiate to its two constants: the twin steps what the estimator has in closed form."""

import json
from dataclasses import replace

import numpy as np
import pytest

from irtiming import measurement
from irtiming.records.choices import Choices
from irtiming.report import result as result_of
from irtiming.twin import rig as twin
from irtiming.twin.scene import RadiativeExchange, microbolometer_scene, with_wheel_speed

SUBSTRATE_S, SCENE_S, SUBSTRATE_K = 12e-3, 8e-3, 303.15


@pytest.fixture(scope="module")
def analysed():
    """Two recordings: blackbody colder and warmer than the wheel."""
    scene = with_wheel_speed(microbolometer_scene(64, 84), 3.0, samples=400)
    scene = replace(scene, optics=replace(scene.optics, pixel_pitch_m=1.15 * scene.optics.pixel_pitch_m))
    rig = twin.draw(scene, seed=3)
    exchange = RadiativeExchange(scene_time_constant_s=SCENE_S, substrate_k=SUBSTRATE_K)
    timing = replace(rig.scene.timing, time_constant_s=SUBSTRATE_S, radiative=exchange)
    recordings = [
        twin.simulate(
            replace(rig.scene, timing=timing, radiance=replace(rig.scene.radiance, blackbody_k=kelvin)),
            seed=8,
            name=f"{kelvin:g}",
        )
        for kelvin in (310.15, 283.15)
    ]
    choices = Choices(substrate_temperature_k=SUBSTRATE_K)
    return rig, measurement.analyse(recordings, rig.measured, choices=choices)


def test_both_constants_lie_within_their_uncertainty(analysed):
    """Oracle: the scene; 3.5 standard uncertainties leave one chance in 2000. Delay and row delay are none the worse."""
    rig, analysis = analysed
    estimate = analysis.two_constants.estimate
    assert estimate.names == ("substrate_time_constant", "scene_time_constant")
    off = np.abs(estimate.values - [SUBSTRATE_S, SCENE_S]) / estimate.standard_uncertainties
    assert np.all(off < 3.5), off
    assert np.all(estimate.standard_uncertainties < [2e-3, 1e-3])
    assert analysis.two_constants.surroundings.wheel_temperature_k == pytest.approx(296.15, abs=1.5)
    found = dict(zip(analysis.best.estimate.names, analysis.best.estimate.values, strict=True))
    u = analysis.best.estimate.standard_uncertainties
    assert abs(found["trigger_delay"] - rig.scene.timing.trigger_delay_s) < 3.5 * u[0]
    assert abs(found["row_delay"] - rig.scene.timing.row_delay_s) < 3.5 * u[2]
    assert [recording.opening.blackbody_is_colder for recording in analysis.recordings] == [True, False]
    assert any("is an effective one" in one.what for one in analysis.findings)


def test_result_tells_them(analysed):
    """Oracle: the estimate; the result stays plain JSON and states where the scene's constant holds."""
    _, analysis = analysed
    result = json.loads(json.dumps(result_of.result(analysis)))
    values = dict(zip(analysis.two_constants.estimate.names, analysis.two_constants.estimate.values, strict=True))
    for name, value in values.items():
        assert result["parameters"][name]["value"] == pytest.approx(value)
        assert result["parameters"][name]["reference_temperature"] == {"value": 300.0, "unit": "K"}
    assert [one["blackbody_temperature"] for one in result["two_constants"]["effective"]] == [283.15, 310.15]
    assert result["choices"]["substrate_temperature"] == SUBSTRATE_K
