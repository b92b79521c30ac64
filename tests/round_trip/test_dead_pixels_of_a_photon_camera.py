"""Pixels that stand in for dead ones see the wheel pass a little earlier or later, others answer more: what a sum knows."""

from dataclasses import replace

import pytest

from irtiming.interface import measuring
from irtiming.twin import rig as twin
from irtiming.twin.cameras import camera_scene
from irtiming.twin.scene import with_wheel_speed

FRAMES = 500


def _analysed(n_dead, *, n_references=50, noise_dn=2.0):
    """A cooled camera of few pixels and its true timing; 3 and 8 Hz, hardly any noise."""
    scene = camera_scene("photon", None, rows=60, columns=80)
    scene = replace(
        scene,
        detector=replace(scene.detector, dead_pixels=n_dead, noise_dn=noise_dn),
        radiance=replace(scene.radiance, reference_frames=n_references),
    )
    drawn = twin.draw(with_wheel_speed(scene, 3.0, samples=FRAMES), seed=6)
    recordings = [
        twin.simulate(with_wheel_speed(drawn.scene, rate_hz, samples=FRAMES), seed=6, name=f"{rate_hz:g}Hz")
        for rate_hz in (3.0, 8.0)
    ]
    return measuring.analyse(recordings, drawn.measured), drawn.scene.timing


@pytest.fixture(scope="module")
def result():
    """With 40 dead pixels in the whole image, 5 of 791 that are summed."""
    return _analysed(40)


def test_no_memory_is_found_where_there_is_none(result):
    """Oracle: the simulated pixels keep nothing of the frame before; stand-ins that are taken for the dead made 4 u of it."""
    found, _ = result
    assert abs(found["pixel_memory"].value) < 3 * found["pixel_memory"].u
    assert found["pixel_memory"].u < 2e-4


def test_the_middle_of_the_window_is_the_true_one(result):
    """Oracle: the twin's truth."""
    found, true = result
    middle = found["exposure_midpoint_delay"]
    assert abs(middle.value - (true.trigger_delay_s + true.integration_time_s / 2)) < 3 * middle.u


def test_what_is_left_is_what_a_camera_without_dead_pixels_leaves(result):
    """Oracle: the same camera, none of its pixels dead."""
    found, _ = result
    whole, _ = _analysed(0)
    for fit, without in zip(found.analysis.fits, whole.analysis.fits, strict=True):
        assert fit.residual.std() < 1.3 * without.residual.std()


def test_a_camera_without_references_is_as_right():
    """Oracle: the twin's truth; gains that differ by a hundredth, and 5 dead pixels, moved the middle by 8 u before."""
    found, true = _analysed(40, n_references=0, noise_dn=10.0)
    middle, memory = found["exposure_midpoint_delay"], found["pixel_memory"]
    assert "bad-pixels" in {one.code for one in found.analysis.findings}
    assert abs(middle.value - (true.trigger_delay_s + true.integration_time_s / 2)) < 3 * middle.u
    assert abs(memory.value) < 3 * memory.u
    assert memory.u < 5e-4
