"""A camera that runs free, recorded with the wheel: strobe edges of its frames, clocks between two looks at another."""

import asyncio
from dataclasses import replace

import numpy as np
import pytest

from irtiming.acquire.checklist import complaints
from irtiming.archive import reader
from irtiming.records.series_plan import CameraWishes
from irtiming.reduce.events import clocks, placing


def _counts_from(laboratory, event):
    """Its camera runs free, no delay is set, and its strobe comes with each frame; ``event`` is what delays count from."""
    laboratory.runs = tuple(replace(run, trigger_delay_ticks=0) for run in laboratory.runs)
    laboratory.plan = replace(laboratory.plan, camera=CameraWishes(camera_type="photon", frame_event=event))
    camera = laboratory.camera
    laboratory.generator.strobes = lambda: camera.made_by_itself() if camera.starts else []
    return laboratory


def test_each_frame_is_recorded_with_its_strobe_edge(laboratory):
    """Oracle: when the fake camera made its frames; those after the last that came are left out, lost ones have their edge."""
    _counts_from(laboratory, "strobe").camera.lost = {3}
    (outcome,) = laboratory.recorded().outcomes
    assert outcome.is_complete, outcome.ending
    assert "start" not in laboratory.generator.begun
    run = reader.read(outcome.path)
    made = np.array(laboratory.camera.made_by_itself())
    assert run.frame_event == "strobe"
    assert run.camera_trigger_ticks.size == 0
    assert np.array_equal(run.camera_input_ticks, made[: run.frame_id[-1] + 1])
    assert 3 not in run.frame_id.tolist()
    assert run.frame_id.size >= 15
    placed = placing.placed(run)
    assert np.array_equal(placed.camera_trigger_ticks[placed.frame_number], made[run.frame_id])


def test_clocks_are_looked_at_all_the_while(laboratory):
    """Oracle: the fake rig's own clocks: true offset and rate lie within the bounds; times are the rig's, twice as fast."""
    (outcome,) = _counts_from(laboratory, "stamp").recorded().outcomes
    run = reader.read(outcome.path)
    assert run.frame_event == "stamp"
    counter, camera = clocks.of_counter(run), clocks.of_camera(run)
    zero = clocks.zeros(run)
    born_s = laboratory.generator.born * laboratory.rig.speed
    true_s = zero.counter_ticks / laboratory.generator.clock_frequency_hz + born_s - zero.computer_s
    at = counter.middle_s
    assert counter.computer_s(np.array(at)) == pytest.approx(at + true_s, abs=2 * counter.u_offset_s + 1e-5)
    assert counter.u_offset_s < 5e-3
    assert camera.rate == pytest.approx(0, abs=5e-3)
    assert run.camera_exchange_ticks.size >= 3


@pytest.mark.parametrize(
    ("strobes", "said"),
    [
        (lambda camera: camera.made_by_itself()[::2], "edges for"),
        (lambda camera: [camera.generator.armed + 10, *camera.made_by_itself()], "before the camera was started"),
    ],
    ids=["half", "early"],
)
def test_strobes_that_cannot_be_the_frames_are_not_trusted(laboratory, strobes, said):
    """Oracle: the words: half of the edges gone, and an edge before the camera was started."""
    _counts_from(laboratory, "strobe")
    camera = laboratory.camera
    laboratory.generator.strobes = lambda: strobes(camera) if camera.starts else []
    (outcome,) = laboratory.recorded().outcomes
    assert said in outcome.ending
    assert not outcome.is_complete


def test_a_delay_for_a_camera_that_runs_free_is_a_complaint(laboratory):
    """Oracle: the words."""
    delayed = laboratory.runs
    _counts_from(laboratory, "strobe").runs = delayed
    (said,) = asyncio.run(complaints(laboratory.rig, laboratory.series, journal=laboratory.journal))
    assert "a camera that runs free knows none" in said
