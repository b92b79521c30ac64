"""The simulated rig as a whole: what it records, tells and hides."""

import math
from dataclasses import fields, replace
from pathlib import Path

import h5py
import hdf5plugin  # noqa: F401  registers the filters of the recordings
import numpy as np
import pytest

from irtiming.errors import GeometryError, PlanError, ReductionError
from irtiming.records.rig import Measured
from irtiming.twin import rig as twin
from irtiming.twin.pixels import expose, picture
from irtiming.twin.scene import ChopperWheel, Faults, Scene, paper_scene, with_wheel_speed


def _all_frames(recording: twin.Recording) -> np.ndarray:
    return np.concatenate([block.copy() for _, block in recording.frames.blocks()])


@pytest.fixture(scope="module")
def short(small_scene: Scene) -> Scene:
    return replace(small_scene, trigger=replace(small_scene.trigger, n_triggers=60))


def test_blocks_and_picked_frames_are_the_same(short: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Oracle: equality, with blocks of seven frames and the last one shorter."""
    monkeypatch.setattr("irtiming.twin.frames._BLOCK_BYTES", 7 * 2 * 64 * 80)
    recording = twin.simulate(short, seed=5)
    sizes = [(first, len(block)) for first, block in recording.frames.blocks()]
    assert sizes == [(first, min(7, 60 - first)) for first in range(0, 60, 7)]
    assert np.array_equal(_all_frames(recording)[[40, 3, 59]], recording.frames.pick([40, 3, 59]))


def test_a_frame_that_is_not_there_is_refused(short: Scene) -> None:
    """Oracle: the message names the frame and the range."""
    with pytest.raises(ReductionError, match=r"frame 60 of 60.*0 to 59"):
        twin.simulate(short, seed=5).frames.pick([60])


def test_same_seed_same_recording(short: Scene) -> None:
    """Oracle: equality; another seed has other noise but the same fixed pattern."""
    first, again, other = (twin.simulate(short, seed=seed) for seed in (5, 5, 6))
    assert np.array_equal(_all_frames(first), _all_frames(again))
    assert np.array_equal(first.control_slot_ticks, again.control_slot_ticks)
    assert not np.array_equal(first.frames.pick([0]), other.frames.pick([0]))
    assert first.nonuniformity is other.nonuniformity


def test_lost_frames_leave_gaps_and_nothing_else(short: Scene) -> None:
    """Oracle: the frames that arrive equal those of the run without loss."""
    whole = twin.simulate(short, seed=5)
    torn = twin.simulate(replace(short, faults=Faults(lost_frames=4)), seed=5)
    assert torn.frames.shape == (56, 64, 80)
    assert len(torn.camera_trigger_ticks) == 60
    assert np.array_equal(_all_frames(torn), _all_frames(whole)[torn.frame_number])


def test_extra_delay_shows_a_later_wheel(short: Scene) -> None:
    """Oracle: a delay of two camera periods shows frame i + 2 at trigger i, but for wander in one run: same seed."""
    period_s = short.trigger.camera_period_ticks / short.trigger.clock_frequency_hz
    timing = replace(short.timing, jitter_s=0.0)
    base = twin.simulate(replace(short, timing=timing), seed=5)
    trigger = replace(short.trigger, trigger_delay_time_set_s=2 * period_s)
    late = twin.simulate(replace(short, timing=timing, trigger=trigger), seed=5)
    assert np.array_equal(late.camera_trigger_ticks, base.camera_trigger_ticks)
    difference = _all_frames(late)[:-2].astype(float) - _all_frames(base)[2:]
    assert np.abs(difference).mean() < 2.5 * short.detector.noise_dn


def test_drawn_rig_is_repeatable_and_the_owner_is_nearly_right() -> None:
    """Oracle: chi-square of what the owner measured over 200 rigs; reference edge before the longer interval."""
    nominal = paper_scene(64, 80)
    assert twin.draw(nominal, seed=3) == twin.draw(nominal, seed=3)
    assert twin.draw(nominal, seed=3) != twin.draw(nominal, seed=4)
    pulls = []
    for seed in range(200):
        rig = twin.draw(nominal, seed=seed)
        scene, gates, mask = rig.scene, rig.measured.light_gates, rig.measured.mask_opening
        for told, true in (
            (gates.half_separation_m, scene.beams.half_separation_m),
            (gates.height_difference_m, scene.beams.height_difference_m),
            (mask.centre_angle_rad, scene.mask.centre_angle_rad),
        ):
            pulls.append((told.value - true) / told.standard_uncertainty)
        assert scene.wheel.ring_edges_rad[2] > math.pi
        assert scene.wheel.ring_edges_rad == pytest.approx([0, math.pi / 2, math.pi, 1.5 * math.pi], abs=5.1e-4)
        between = scene.beams.beta_1_rad + scene.beams.beta_2_rad
        assert gates.whole_slots_between == math.floor(between * 50 / math.pi) == 9
    assert np.square(pulls).mean() == pytest.approx(1.0, abs=0.25)


def test_truth_is_flat_and_complete() -> None:
    """Oracle: by hand: the middle of the window, atan(d / h), slot 25 near a quarter turn."""
    scene = paper_scene()
    truth = twin.truth(scene)
    assert truth["trigger_delay_s"] == 412.7e-6
    assert truth["exposure_midpoint_delay_s"] == pytest.approx(537.7e-6)
    assert truth["integration_time_s"] == 250e-6
    assert truth["beta_1_rad"] == pytest.approx(math.atan(13 / 47.3))
    assert truth["beta_2_rad"] == pytest.approx(math.atan(13 / 41.8))
    slots = truth["control_slot_angles_rad"]
    assert isinstance(slots, list)
    assert slots[25] == pytest.approx(math.pi / 2)
    assert (truth["wheel_centre_row_px"], truth["wheel_centre_column_px"]) == (255.5, 319.5)
    assert all(isinstance(value, str | float | bool | int | list) for value in truth.values())
    assert all(isinstance(entry, float) for value in truth.values() if isinstance(value, list) for entry in value)


def test_series_visits_every_delay_with_one_rig(short: Scene) -> None:
    """Oracle: counting; the reference and the rays are shared, the edges are not."""
    runs = list(twin.series(short, [0.0, 0.025], repeats=2, seed=9))
    assert [run.name for run in runs] == [f"cooled-3Hz-{delay}ms-run0{run}" for delay in (0, 25) for run in (1, 2)]
    assert [run.trigger_delay_time_set_s for run in runs] == [0, 0, 0.025, 0.025]
    assert len({run.control_slot_ticks[:50].tobytes() for run in runs}) == 4
    assert len({id(run.nonuniformity) for run in runs}) == 1
    anywhere = [
        run.application_slot_ticks[0] for run in twin.series(short, [0.0], repeats=3, seed=9, random_start=True)
    ]
    assert np.ptp(anywhere) > 1e5


def test_other_wheel_speed_keeps_the_scheme_coprime() -> None:
    """Oracle: the paper's T and C at 3 Hz; at 6 Hz delta halves and the frame rate stays near."""
    scene = with_wheel_speed(paper_scene(), 3.0)
    assert (scene.trigger.turn_period_ticks, scene.trigger.camera_period_ticks) == (16_384_000, 1_622_016)
    trigger = with_wheel_speed(paper_scene(), 6.0).trigger
    assert trigger.turn_period_ticks == 8_192_000
    assert math.gcd(trigger.turn_period_ticks, trigger.camera_period_ticks) == 8192
    assert trigger.clock_frequency_hz / trigger.camera_period_ticks == pytest.approx(30.303, rel=0.01)
    with pytest.raises(PlanError, match="0 Hz"):
        with_wheel_speed(paper_scene(), 0.0)


def test_impossible_scenes_are_refused() -> None:
    """Oracle: the message names the number."""
    with pytest.raises(GeometryError, match="8 x 80"):
        paper_scene(8, 80)
    with pytest.raises(GeometryError, match="must increase"):
        ChopperWheel(ring_edges_rad=(0.0, 3.0, 2.0, 4.0))


def test_every_part_of_a_scene_can_be_hashed() -> None:
    """Oracle: hash; rays are kept per scene, so an array in a scene would break it."""
    scene = paper_scene()
    assert all(hash(getattr(scene, field.name)) is not None for field in fields(scene))


def test_opening_follows_the_other_simulator(shared_recordings: Path) -> None:
    """Oracle: fractions of a recording made by another simulator, at angles read crudely off its own edges."""
    folder = shared_recordings / "cooled"
    with h5py.File(folder / "cooled-3Hz-0ms.nxs") as file:
        ticks = file["entry/instrument/trigger_generator"]
        edges, triggers = ticks["application_slot"][:], ticks["camera_trigger"][:200]
        frames = file["entry/instrument/camera/data"][:200].astype(float)
    first = 0 if edges[1:-1:2].mean() - edges[:-2:2].mean() > edges[2::2].mean() - edges[1:-1:2].mean() else 1
    theta = np.interp(triggers, edges[first::2], 2 * math.pi * np.arange(len(edges[first::2])))
    theta += 2 * math.pi * 3 * (371.9e-6 + 125e-6)
    theirs = frames.sum(axis=(1, 2))
    shot = picture(paper_scene(64, 80))
    ours, out = np.empty(200), np.empty((64, 80), np.float32)
    for frame, angle in enumerate(theta):
        expose(shot, np.array([angle]), out=out)
        ours[frame] = out.sum()
    for sums in (theirs, ours):
        sums -= np.percentile(sums, 1)
        sums /= np.percentile(sums, 99)
    assert np.abs(ours - theirs).max() < 0.02


def test_the_owner_of_a_rolled_camera_says_so():
    """Oracle: the nominal angle, which the drawn one differs from by some of its half degree; an upright camera states none."""
    upright = paper_scene()
    rolled = replace(upright, optics=replace(upright.optics, roll_rad=math.radians(12)))
    rig = twin.draw(rolled, seed=3)
    assert rig.measured.camera.roll_rad == Measured(math.radians(12), math.radians(0.5))
    assert 0 < abs(rig.scene.optics.roll_rad - math.radians(12)) < math.radians(2)
    assert twin.draw(upright, seed=3).measured.camera.roll_rad is None
