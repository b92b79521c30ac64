"""The twin's microbolometer camera: rows in their order, shutter, drift, and what it records and tells."""

import math
from dataclasses import replace
from pathlib import Path

import h5py
import hdf5plugin  # noqa: F401  registers the filters of the recordings
import numpy as np
import pytest

from irtiming.archive import reader, writer
from irtiming.errors import GeometryError, PlanError
from irtiming.twin import rig as twin
from irtiming.twin.nodes import trace_nodes
from irtiming.twin.scene import (
    BolometerTiming,
    Faults,
    Scene,
    SpeedWander,
    microbolometer_scene,
    paper_scene,
    with_wheel_speed,
)
from irtiming.twin.upkeep import Drift, SelfCorrection, ShutterEvent
from irtiming.twin.views import settling_s

_PERIOD_S = 0.033
_TAU_S = 4.819e-3


@pytest.fixture(scope="module")
def short() -> Scene:
    """60 frames of 64 x 80 pixels without noise and pattern."""
    scene = microbolometer_scene(64, 80)
    return replace(
        scene,
        optics=replace(scene.optics, rays_along_pixel=8),
        detector=replace(scene.detector, noise_dn=0.0, gain_spread=0.0, offset_spread_dn=0.0),
        timing=replace(BolometerTiming(), jitter_s=0.0),
        trigger=replace(scene.trigger, n_triggers=60),
        wander=SpeedWander(relative=0.0, ripples=()),
    )


def _all_frames(scene: Scene, *, seed: int = 5) -> np.ndarray:
    blocks = twin.simulate(scene, seed=seed).frames.blocks()
    return np.concatenate([block.copy() for _, block in blocks]).astype(float)


def _hub(frames: np.ndarray) -> np.ndarray:
    """A corner of the image, which sees nothing but solid wheel; mean of each frame."""
    return frames[:, -5:, :5].mean(axis=(1, 2))


@pytest.mark.parametrize("row_delay_s", [38.76e-6, 200e-6, -150e-6])
def test_each_row_is_read_at_its_own_time(short: Scene, row_delay_s: float) -> None:
    """Oracle: the same row of frames that are read at one time, so much later: blur included; negative is bottom up."""
    rolling = _all_frames(replace(short, timing=replace(short.timing, row_delay_s=row_delay_s)))
    for row in (0, 7, 20, 63):
        later_s = short.timing.trigger_delay_s + row * row_delay_s
        at_once = replace(short, timing=replace(short.timing, row_delay_s=0.0, trigger_delay_s=later_s))
        assert rolling[:, row] == pytest.approx(_all_frames(at_once)[:, row], abs=1.01)


def test_extra_delay_shows_a_later_wheel(short: Scene) -> None:
    """Oracle: a delay of two camera periods shows frame i + 2 at trigger i."""
    set_s = 2 * short.trigger.camera_period_ticks / short.trigger.clock_frequency_hz
    late = replace(short, trigger=replace(short.trigger, trigger_delay_time_set_s=set_s))
    assert _all_frames(late)[:-2] == pytest.approx(_all_frames(short)[2:], abs=1.01)


def test_lag_spreads_an_edge_and_keeps_its_sum(short: Scene) -> None:
    """Oracle: the mean over a whole turn is that without lag; a step has reached 1 - 1/e after tau."""
    n, lags = 250, (20e-6, _TAU_S)
    timings = [replace(short.timing, row_delay_s=0.0, trigger_delay_s=4e-3, time_constant_s=tau_s) for tau_s in lags]
    trigger = with_wheel_speed(short, 3.0, samples=n).trigger
    quick, lagging = (_all_frames(replace(short, timing=timing, trigger=trigger)) for timing in timings)
    assert quick.mean(axis=0) == pytest.approx(lagging.mean(axis=0), abs=1.0)
    phase = np.argsort(np.arange(n) * trigger.camera_period_ticks % trigger.turn_period_ticks)
    delay = _shift(quick.sum(axis=(1, 2))[phase], lagging.sum(axis=(1, 2))[phase]) / 3
    assert delay == pytest.approx(_TAU_S, rel=0.02)


def _shift(before: np.ndarray, after: np.ndarray) -> float:
    """Turns by which the second harmonic of a lagging series lies behind: arctan(2 omega tau) / 2, made linear."""
    phase = np.angle(np.fft.rfft(before)[2] / np.fft.rfft(after)[2])
    return float(np.tan(phase) / (4 * math.pi))


def test_lost_frames_leave_gaps_and_nothing_else(short: Scene) -> None:
    """Oracle: the frames that arrive equal those of the run without loss, noise included."""
    noisy = replace(short, detector=replace(short.detector, noise_dn=5.0))
    torn = twin.simulate(replace(noisy, faults=Faults(lost_frames=4)), seed=5)
    assert torn.frames.shape == (56, 64, 80)
    assert np.array_equal(torn.frames.pick(list(range(56))), _all_frames(noisy)[torn.frame_number])


def test_blocks_and_picked_frames_are_the_same(short: Scene) -> None:
    """Oracle: equality, with noise, jitter and a shutter."""
    events = (ShutterEvent(start_s=0.5, duration_s=0.1),)
    scene = replace(microbolometer_scene(64, 80), trigger=short.trigger, correction=SelfCorrection(events=events))
    assert np.array_equal(twin.simulate(scene, seed=5).frames.pick([40, 3, 59]), _all_frames(scene)[[40, 3, 59]])
    assert not np.array_equal(_all_frames(scene, seed=6)[0], _all_frames(scene)[0])


def _shuttered(scene: Scene, *events: ShutterEvent) -> Scene:
    return replace(scene, correction=replace(scene.correction, events=events))


def _settled(time_s: np.ndarray, events: tuple[ShutterEvent, ...], levels: tuple[float, float]) -> np.ndarray:
    """A pixel behind solid wheel at these times, by hand: from one exponential to the next."""
    wheel, surface = levels
    result, value, since = np.full_like(time_s, wheel), wheel, -math.inf
    for event in events:
        end_s = event.start_s + event.duration_s
        for begin, target in ((event.start_s, surface), (end_s, wheel)):
            towards = surface if target == wheel else wheel
            value = towards + (value - towards) * math.exp(-(begin - since) / _TAU_S)
            later, since = time_s >= begin, begin
            result[later] = target + (value - target) * np.exp(-(time_s[later] - begin) / _TAU_S)
    return result


@pytest.mark.parametrize(
    "events",
    [
        ((0.5, 0.3),),
        ((-0.2, 0.25), (1.9, 0.6)),
        ((0.4991, 0.0153), (0.5221, 0.004), (0.53, 0.0101), (0.5402, 0.02)),
        ((-9.0, 8.99),),
    ],
)
def test_closed_shutter_is_entered_and_left_with_lag(short: Scene, events: tuple[tuple[float, float], ...]) -> None:
    """Oracle: exponentials by hand for a pixel that sees solid wheel, row by row, also for events in quick succession."""
    shut = tuple(ShutterEvent(start_s=a, duration_s=b, level_jump_dn=0.0) for a, b in events)
    flat = replace(short, radiance=replace(short.radiance, narcissus_dn=0.0))
    frames = _all_frames(_shuttered(flat, *shut))
    radiance = flat.radiance
    levels = (radiance.level_dn(radiance.wheel_k), radiance.level_dn(flat.correction.surface_k))
    time_s = np.arange(60)[:, None] * _PERIOD_S + flat.timing.trigger_delay_s + np.arange(64) * flat.timing.row_delay_s
    expected = _settled(time_s.ravel(), shut, levels).reshape(time_s.shape)
    assert frames[:, :, 0] == pytest.approx(expected, abs=0.6)


def test_pixels_in_the_opening_come_back_to_the_scene(short: Scene) -> None:
    """Oracle: a run without shutter, from 20 time constants after it on; inside, the surface alone."""
    free, shut = _all_frames(short), _all_frames(_shuttered(short, ShutterEvent(start_s=0.6, level_jump_dn=7.0)))
    time_s = np.arange(60) * _PERIOD_S
    before, inside, after = time_s < 0.59, (time_s > 0.7) & (time_s < 1.19), time_s > 1.2 + 20 * _TAU_S
    assert np.array_equal(shut[before], free[before])
    assert set(np.unique(shut[inside])) == {short.radiance.level_dn(303.15)}
    assert shut[after] == pytest.approx(free[after] + 7.0, abs=0.01)
    going = (time_s > 1.2) & (time_s < 1.2 + 2 * _TAU_S)
    assert (np.abs(shut[going] - free[going] - 7).max(axis=(1, 2)) > 50).all()


@pytest.mark.parametrize(("start", "last"), [(-0.5, 0), (0.5, 15), (1.95, 59)])
def test_frozen_camera_repeats_its_last_frame(short: Scene, start: float, last: int) -> None:
    """Oracle: equality with the frame before, noise included; before the run there is one that nobody asked for."""
    noisy = replace(short, detector=replace(short.detector, noise_dn=5.0))
    event = ShutterEvent(start_s=start, duration_s=0.62, kind="frozen", level_jump_dn=0.0)
    free, stuck = _all_frames(noisy), _all_frames(_shuttered(noisy, event))
    time_s = np.arange(60) * _PERIOD_S
    held = (time_s >= start) & (time_s < start + 0.62)
    assert np.array_equal(stuck[~held], free[~held])
    if start < 0:
        assert (stuck[held] == stuck[0]).all()
        assert not np.array_equal(stuck[0], free[0])
    else:
        assert (stuck[held] == free[last]).all()


def test_correction_draws_offsets_anew_and_moves_the_level(short: Scene) -> None:
    """Oracle: two independent patterns of 4 DN differ by 4 sqrt 2; the mean jumps by what was asked; dead stay dead."""
    detector = replace(short.detector, offset_spread_dn=4.0, gain_spread=0.01, dead_pixels=9)
    events = (ShutterEvent(start_s=0.5, duration_s=0.2, level_jump_dn=8.0), ShutterEvent(start_s=1.0, duration_s=0.2))
    scene = _shuttered(replace(short, detector=detector), *events)
    free = _all_frames(replace(short, detector=replace(detector, offset_spread_dn=0.0)))
    shut, other = _all_frames(scene), _all_frames(scene, seed=6)
    dead = (shut[10] == 0) | (shut[10] == 65535)
    assert dead.sum() == 9
    left = shut - free
    assert left[10][~dead].std() == pytest.approx(4.0, rel=0.05)
    for before, after, jump in ((10, 28, 8.0), (28, 45, 5.0)):
        step = (left[after] - left[before])[~dead]
        assert step.std() == pytest.approx(4 * math.sqrt(2), rel=0.05)
        assert step.mean() == pytest.approx(jump, abs=0.3)
        assert (left[after] - left[before])[dead].max() == 0
    assert np.array_equal(shut[10], other[10])
    assert not np.array_equal(shut[28], other[28])


def test_no_gain_error_is_seen_at_the_shutter(short: Scene) -> None:
    """Oracle: a one-point correction: even where it was made, uneven by 1% of the way from there."""
    scene = replace(short, detector=replace(short.detector, gain_spread=0.01))
    frames = _all_frames(_shuttered(scene, ShutterEvent(start_s=0.5, duration_s=0.5)))
    assert frames[20].std() < 0.1
    outside = frames[5][:, -4:]
    assert outside.std() == pytest.approx(0.01 * 80 * (303.15 - 296.15), rel=0.15)


def test_drift_is_a_line_and_a_settling(short: Scene) -> None:
    """Oracle: 3 DN/s t + 40 DN exp(-t / 0.5 s), by hand."""
    drift = Drift(per_second_dn=3.0, settling_dn=40.0, settling_time_s=0.5)
    time_s = np.arange(60) * _PERIOD_S
    moved = _hub(_all_frames(replace(short, drift=drift))) - _hub(_all_frames(short))
    assert moved == pytest.approx(3 * time_s + 40 * np.exp(-time_s / 0.5), abs=0.51)


def test_row_noise_moves_whole_rows(short: Scene) -> None:
    """Oracle: standard deviations over frames of a row's mean and of pixels about it."""
    noisy = replace(short, detector=replace(short.detector, row_noise_dn=3.0))
    moved = _all_frames(noisy) - _all_frames(short)
    assert moved.mean(axis=2).std() == pytest.approx(3.0, rel=0.05)
    assert np.ptp(moved, axis=2).max() <= 1


def test_counterclockwise_is_the_mirror_image(short: Scene) -> None:
    """Oracle: the picture reflected in the vertical through the axle, with the axle in the middle of the image."""
    mask = replace(short.mask, centre_angle_rad=math.radians(-70), centre_x_m=3e-4)
    mirrored = replace(mask, centre_angle_rad=math.pi - mask.centre_angle_rad, centre_x_m=-3e-4)
    wheel = replace(short.wheel, rotation="counterclockwise")
    one, other = _all_frames(replace(short, mask=mask)), _all_frames(replace(short, mask=mirrored, wheel=wheel))
    difference = one - other[:, :, ::-1]
    assert np.abs(difference).mean() < 1.0
    assert difference.sum(axis=(1, 2)) == pytest.approx(0, abs=200)  # of 800 000 DN


def test_drawn_cameras_differ_as_their_tolerances_say() -> None:
    """Oracle: mean and standard deviation over 300 rigs against the tolerances, 4 standard errors."""
    nominal, spread = microbolometer_scene(64, 80), twin.Tolerances()
    timings = [twin.draw(nominal, seed=seed).scene.timing for seed in range(300)]
    for name, sigma in (
        ("trigger_delay_s", spread.bolometer_delay_s),
        ("time_constant_s", spread.time_constant_s),
        ("row_delay_s", spread.row_delay_s),
    ):
        drawn = np.array([getattr(timing, name) for timing in timings])
        assert drawn.mean() == pytest.approx(getattr(nominal.timing, name), abs=4 * sigma / math.sqrt(300))
        assert drawn.std() == pytest.approx(sigma, rel=4 / math.sqrt(600))
    assert twin.draw(nominal, seed=3) == twin.draw(nominal, seed=3)
    photon, bolometer = (twin.draw(scene, seed=3).scene for scene in (paper_scene(64, 80), nominal))
    assert photon.wheel.ring_edges_rad == bolometer.wheel.ring_edges_rad


def test_truth_says_what_can_be_measured(short: Scene) -> None:
    """Oracle: the scene; the names of the other simulator's truth are among ours."""
    events = (ShutterEvent(start_s=1.0), ShutterEvent(start_s=2.0, kind="frozen"))
    truth = twin.truth(_shuttered(short, *events))
    assert truth["camera"] == "microbolometer"
    assert (truth["trigger_delay_s"], truth["time_constant_s"], truth["row_delay_s"]) == (3.872e-3, 4.819e-3, 38.76e-6)
    assert truth["shutter_start_s"] == [1.0, 2.0]
    assert truth["shutter_kind"] == "closed frozen"
    assert not {"integration_time_s", "exposure_midpoint_delay_s"} & set(truth)
    theirs = {"control_slot_angles_rad", "beta_1_rad", "beta_2_rad", "wheel_centre_row_column_px"}
    assert theirs <= set(truth)


def test_recording_goes_through_a_file(short: Scene, tmp_path: Path) -> None:
    """Oracle: what was written; no integration time, no reference, 16 bits, rolling."""
    scene = _shuttered(short, ShutterEvent(start_s=0.5))
    (recording,) = twin.series(scene, [0.025], repeats=1, seed=9)
    assert recording.name == "bolo-3Hz-25ms"
    writer.write(recording, tmp_path / "bolo.nxs", truth=twin.truth(scene))
    back = reader.read(tmp_path / "bolo.nxs")
    assert (back.camera_type, back.readout_mode, back.bit_depth) == ("microbolometer", "rolling", 16)
    assert back.integration_time_s is None
    assert back.nonuniformity is None
    assert back.frames.shape == (60, 64, 80)
    assert np.array_equal(back.frames.pick([0, 30]), recording.frames.pick([0, 30]))


def test_opening_of_the_paper_has_193_rows() -> None:
    """Oracle: section 3.2.4, 193 sets of individual pixel rows within the cutout; rows that see it by half."""
    nodes = trace_nodes(microbolometer_scene(), 0.05)
    pixel = np.repeat(nodes.pixel, np.diff(nodes.first_node))
    light = np.bincount(pixel, weights=np.where(nodes.behind == 0, nodes.share, 0), minlength=480 * 640)
    assert (light.reshape(480, 640).max(axis=1) > 0.5).sum() == pytest.approx(193, abs=2)


def test_values_are_those_of_a_real_camera(short: Scene) -> None:
    """Oracle: 80 DN per kelvin about 6000 DN at 15 degC, wheel 8 K warmer; a warm camera in the middle of the wheel."""
    frames = _all_frames(short)
    assert frames.min() == pytest.approx(6000, abs=2)
    assert np.median(frames) == pytest.approx(6640, abs=40)
    assert frames[:, 28:36, 36:44].max() > 6640 + 80


def test_impossible_scenes_are_refused(short: Scene) -> None:
    """Oracle: the message names the number and the cure."""
    with pytest.raises(GeometryError, match="8 x 80"):
        microbolometer_scene(8, 80)
    with pytest.raises(PlanError, match=r"0.0 s; .*check the unit"):
        BolometerTiming(time_constant_s=0.0)
    with pytest.raises(PlanError, match=r"64 rows every 600 us takes 38.4 ms, longer than the camera period of 33 ms"):
        twin.simulate(replace(short, timing=replace(short.timing, row_delay_s=-600e-6)), seed=1)
    with pytest.raises(PlanError, match=r"at 1.5 s after one from 1 s for 0.6 s"):
        SelfCorrection(events=(ShutterEvent(start_s=1.0), ShutterEvent(start_s=1.5)))
    with pytest.raises(PlanError, match="must be positive"):
        SelfCorrection(events=(ShutterEvent(start_s=1.0, duration_s=0.0),))
    photon = paper_scene(64, 80)
    with pytest.raises(PlanError, match="pixels without lag in a photon camera"):
        settling_s(photon)


def test_opening_follows_the_other_simulator(shared_recordings: Path) -> None:
    """Oracle: sums of frames of a recording made by another simulator, at angles read crudely off its own edges."""
    with h5py.File(shared_recordings / "bolo" / "bolo-3Hz-0ms.nxs") as file:
        ticks = file["entry/instrument/trigger_generator"]
        edges, triggers = ticks["application_slot"][:], ticks["camera_trigger"][:]
        frames = file["entry/instrument/camera/data"][:].astype(float)
    first = 0 if edges[1:-1:2].mean() - edges[:-2:2].mean() > edges[2::2].mean() - edges[1:-1:2].mean() else 1
    turns = np.interp(triggers, edges[first::2], np.arange(len(edges[first::2])))
    level = frames[:, :10, :10].mean(axis=(1, 2))  # solid wheel: drift, and two corrections of the camera
    some = slice(221, 621)  # after the second correction
    turns, frames, level = turns[some], frames[some], level[some]
    whole = level > 6000
    scene = microbolometer_scene(120, 160)
    scene = replace(
        scene,
        mask=replace(scene.mask, inner_radius_m=12.3e-3, outer_radius_m=36e-3),
        optics=replace(scene.optics, wheel_centre_row_px=60.4, wheel_centre_column_px=79.6),
        timing=BolometerTiming(trigger_delay_s=2.318e-3, time_constant_s=6.12e-3, row_delay_s=96.5e-6),
        trigger=replace(scene.trigger, start_angle_rad=2 * math.pi * turns[0], n_triggers=len(turns)),
        radiance=replace(scene.radiance, mask_k=scene.radiance.wheel_k),
        wander=SpeedWander(relative=0.0, ripples=()),
    )
    ours, theirs = _all_frames(scene).mean(axis=(1, 2))[whole], frames.mean(axis=(1, 2))[whole] - level[whole]
    for sums in (theirs, ours):
        low, high = np.percentile(sums, [5, 95])
        sums -= low
        sums /= high - low
    assert abs(_mean_lag_us(turns[whole], theirs, ours)) < 150
    assert np.abs(ours - theirs).max() < 0.03


def _mean_lag_us(turns: np.ndarray, theirs: np.ndarray, ours: np.ndarray) -> float:
    """How much later ours is, from the second harmonic, us at 3 Hz."""
    wave = np.exp(-2j * 2 * math.pi * turns)
    return float(np.angle((theirs * wave).sum() / (ours * wave).sum()) / (4 * math.pi) / 3 * 1e6)
