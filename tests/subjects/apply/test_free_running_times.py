"""Results of cameras that run free, put onto strobe edges, stamps and arrivals of the twin, whose frames' times are known."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_result import made_up_result

from irtiming.apply import camera_timing, frame_times
from irtiming.apply.stamps import Generator, Latency
from irtiming.archive.result_model import EventsOfFrames, Item
from irtiming.errors import ConditionError
from irtiming.records.frame_events import DELAYS
from irtiming.reduce.events import placing
from irtiming.report.result_of_inputs import event as events_of_result
from irtiming.session import frame_stamps
from irtiming.session.frame_stamps import StampsWanted
from irtiming.twin import free_camera
from irtiming.twin import rig as twin
from irtiming.twin.clockwork import first_trigger_ticks
from irtiming.twin.scene import Faults, paper_scene, with_wheel_speed

EVENTS = ("strobe", "stamp", "arrival")
SCENE = replace(with_wheel_speed(paper_scene(16, 16), 3.0, samples=120), faults=Faults(lost_frames=7))
EXPOSED_AFTER_S, U_S, WINDOW_S = 417e-6, 5e-6, 250e-6


def _result(free, rng, *, jitter=None):
    """A made-up result of this camera, off by its uncertainty; ``jitter`` as its analysis would state it."""
    start_s = free_camera.delay_s(free, exposed_after_s=EXPOSED_AFTER_S) + rng.normal(0, U_S)
    numbers = {DELAYS[free.event]: (start_s, U_S), "exposure_midpoint_delay": (start_s + WINDOW_S / 2, U_S)}
    made = made_up_result("photon", "snapshot", numbers, matrix=[[1.0, 1.0], [1.0, 1.0]])
    inputs = [made.inputs[0].model_copy(update={"event": jitter, "image": None})]
    return made.model_copy(update={"frame_event": free.event, "inputs": inputs, "item": Item()})


def _measured_jitter(free, seed):
    """How stamps scatter, as a measurement of 2000 frames of the same camera tells it in its result."""
    run = twin.simulate(replace(SCENE, free=free, trigger=replace(SCENE.trigger, n_triggers=2000)), seed=seed + 1000)
    return EventsOfFrames.model_validate(events_of_result(placing.placed(run).events))


def _true_starts(run, free):
    """When frames began their exposure by the clock that stamped, which is the counter's for a strobe."""
    true_s = free_camera.begun_s(SCENE.trigger, free, number=run.frame_number) + EXPOSED_AFTER_S
    if free.event == "strobe":
        return true_s + first_trigger_ticks(SCENE.trigger) / SCENE.trigger.clock_frequency_hz
    if free.event == "stamp":
        return true_s * (1 + free.rate_error) + free.camera_zero_ticks / free.timestamp_frequency_hz
    return true_s * (1 + free.computer_rate_error) + free.computer_zero_s


def _pulls(event, seed, *, alone):
    """Pulls of the start of all frames of one camera, and the correlation of two frames that is stated."""
    rng = np.random.default_rng(seed)
    free = free_camera.draw_free(event, seed=seed)
    run = twin.simulate(replace(SCENE, free=free), seed=seed)
    jitter = _measured_jitter(free, seed) if alone else None
    camera = camera_timing.of_result(_result(free, rng, jitter=jitter))
    stamped = frame_stamps.of_recording(run, StampsWanted(source="run.nxs", alone=alone), camera=camera)
    times = frame_times.apply(camera, stamped.events)
    off_s = times.time_s("start")[:, 0] + stamped.events.origin_s - _true_starts(run, free)
    return off_s / times.u_s("start")[0], times.correlation("start")[0]


@pytest.mark.parametrize("event", EVENTS)
def test_times_of_50_cameras_that_run_free_miss_by_what_is_stated(event):
    """Oracle: the twin's times of its frames; errors are common to the frames of a camera, so 50 independent ones count."""
    found = [_pulls(event, seed, alone=False) for seed in range(50)]
    pulls, correlation = np.array([one for one, _ in found]), np.array([r for _, r in found])
    assert np.sqrt(np.mean(pulls**2)) == pytest.approx(0.95, abs=0.25)
    assert abs(pulls.mean()) < 3 / 50**0.5
    assert np.all(correlation > 0.99)


def test_arrivals_one_by_one_scatter_by_what_the_result_measured():
    """Oracle: the twin's; every frame of eight cameras counts, so the scatter is that of single frames, mean and spread."""
    found = [_pulls("arrival", seed, alone=True) for seed in range(8)]
    pulls = np.concatenate([one for one, _ in found])
    assert abs(pulls.mean()) < 0.12
    assert np.sqrt(np.mean(pulls**2)) == pytest.approx(1, abs=0.3)
    assert max(r for _, r in found) < 0.01


def test_the_latency_of_the_strobe_is_in_delay_and_edges_alike():
    """Oracle: by hand; edges stamped 3 us late were taken to be early by that in the result, and are so here: it cancels in u."""
    free = free_camera.draw_free("strobe", seed=3)
    run = twin.simulate(replace(SCENE, free=free), seed=3)
    camera = camera_timing.of_result(_result(free, np.random.default_rng(1)))
    plain, known = (
        frame_stamps.of_recording(
            run, StampsWanted(source="run.nxs"), camera=camera, generator=Generator(way=way)
        ).events
        for way in (None, Latency(value_s=-3e-6, u_s=1e-6))
    )
    assert known.time_s - plain.time_s == pytest.approx(-3e-6, abs=1e-12)
    assert known.u_cancelled_s == 1e-6


def test_stamps_of_another_event_are_refused_unless_their_latency_is_said():
    """Oracle: the words; and by hand a latency that makes arrivals of stamps."""
    free = free_camera.draw_free("stamp", seed=4)
    run = twin.simulate(replace(SCENE, free=free), seed=4)
    camera = camera_timing.of_result(_result(free, np.random.default_rng(1)))
    wanted = StampsWanted(source="run.nxs", kind="arrival")
    with pytest.raises(ConditionError, match=r"counts from the frame's stamp \(median\), these are arrivals"):
        frame_stamps.of_recording(run, wanted, camera=camera)
    late_s = free_camera.usual_latency_s(free) - free.stamp_after_s
    said = replace(wanted, latency_s=late_s, latency_u_s=1e-6)
    events = frame_stamps.of_recording(run, said, camera=camera).events
    stamped_s = free_camera.begun_s(SCENE.trigger, free, number=run.frame_number) + free.stamp_after_s
    off_s = events.time_s + events.origin_s - stamped_s * (1 + free.computer_rate_error) - free.computer_zero_s
    assert abs(off_s.mean()) < 3.5 * events.u_common_s
    with pytest.raises(ConditionError, match="leave out --alone"):
        frame_stamps.of_recording(run, replace(said, alone=True), camera=camera)
    with pytest.raises(ConditionError, match="trigger edges are asked for"):
        frame_stamps.of_recording(run, replace(wanted, kind="trigger"), camera=camera)
    triggered = twin.simulate(SCENE, seed=4)
    strobed = camera_timing.of_result(_result(free_camera.draw_free("strobe", seed=4), np.random.default_rng(1)))
    with pytest.raises(ConditionError, match="no edges of the camera's strobe"):
        frame_stamps.of_recording(triggered, StampsWanted(source="run.nxs"), camera=strobed)
