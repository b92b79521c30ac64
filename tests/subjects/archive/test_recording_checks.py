"""What verify says of timestamps is said of a recording in memory as well."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.archive.recording_checks import check_recording
from irtiming.twin.rig import simulate
from irtiming.twin.scene import paper_scene, with_wheel_speed


@pytest.fixture(scope="module")
def sound():
    return simulate(with_wheel_speed(paper_scene(16, 20), 3.0, samples=100), seed=1, name="run")


def test_a_sound_recording_has_nothing_to_tell(sound):
    """Oracle: the twin without a fault."""
    assert check_recording(sound) == ()


@pytest.mark.parametrize("n_left_out", [0, 1], ids=["as many of both", "one more of either"])
@pytest.mark.parametrize("edge_2_deg", [183.0, 190.0])
def test_a_wheel_with_unequal_cutouts_turns_as_fast_as_is_stated(edge_2_deg, n_left_out):
    """Oracle: the simulated wheel's own speed; half turns of 183 and 177 degrees are 1.7 % off it, one way and the other."""
    scene = paper_scene(16, 20)
    wheel = replace(scene.wheel, ring_edges_rad=tuple(np.radians([0.0, 92.0, edge_2_deg, 275.0])))
    scene = with_wheel_speed(replace(scene, wheel=wheel), 3.0, samples=100)
    found = simulate(scene, seed=2)
    assert check_recording(replace(found, application_slot_ticks=found.application_slot_ticks[n_left_out:])) == ()


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (lambda r: {"clock_frequency_hz": 50e6}, "rotation-speed-off"),
        (lambda r: {"rotation_speed_hz": 3.1}, "rotation-speed-contradicted"),
        (
            lambda r: {"camera_trigger_ticks": r.camera_trigger_ticks + 49_152 * (np.arange(100) > 50)},
            "trigger-intervals-odd",
        ),
        (lambda r: {"integration_time_s": 0.25}, "integration-time-beyond-period"),
    ],
)
def test_a_contradiction_is_a_doubt_with_the_name_of_the_recording(sound, change, code):
    """Oracle: what was changed: a clock 1.7 % off, a speed 3 % off, triggers 1 ms late, 250 ms in a period of 33 ms."""
    found = check_recording(replace(sound, **change(sound)))
    assert (code, "doubt", "run") in [(one.code, one.severity, one.recording) for one in found]
