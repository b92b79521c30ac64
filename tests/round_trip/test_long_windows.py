"""Windows in which the wheel turns so far that no frame of the simulated camera shows the opening wholly open or covered."""

from dataclasses import replace

import pytest

from irtiming.measurement import analyse
from irtiming.twin import rig as twin
from irtiming.twin.scene import paper_scene, with_wheel_speed

WHEEL_HZ, SAMPLES = 12.0, 300


@pytest.mark.parametrize("is_stated", [True, False], ids=["stated", "not stated"])
@pytest.mark.parametrize(("window_s", "seed"), [(5e-3, 303), (8e-3, 301), (12e-3, 300)])
def test_delay_and_memory_of_a_long_window(window_s, seed, is_stated):
    """Oracle: the simulated camera's truth, of 64 instants; 22, 35 and 52 degrees of turn, cutouts 15 wider than the opening."""
    scene = paper_scene(60, 80)
    timing = replace(scene.timing, integration_time_s=window_s, substeps=64)
    rig = twin.draw(replace(scene, timing=timing), seed=100 + seed)
    recording = twin.simulate(with_wheel_speed(rig.scene, WHEEL_HZ, frame_hz=30.3, samples=SAMPLES), seed=seed)
    recording = recording if is_stated else replace(recording, integration_time_s=None)
    estimate = analyse([recording], rig.measured).best.estimate
    middle_s = rig.scene.timing.trigger_delay_s + window_s / 2
    assert estimate.value("exposure_midpoint_delay") == pytest.approx(
        middle_s, abs=3 * estimate.u("exposure_midpoint_delay")
    )
    assert estimate.u("exposure_midpoint_delay") < 50e-6
    assert estimate.value("pixel_memory") == pytest.approx(0.0, abs=3 * estimate.u("pixel_memory"))
    assert estimate.u("pixel_memory") < 8e-3
