"""Rolling photon cameras and snapshots with lag: what each response makes of each readout."""

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from irtiming.archive import reader, verify, writer
from irtiming.errors import PlanError
from irtiming.records.recording import CameraType, ReadoutMode
from irtiming.twin import rig as twin
from irtiming.twin import window
from irtiming.twin.cameras import camera_scene
from irtiming.twin.scene import BolometerTiming, CameraTiming, Ripple, Scene, SpeedWander

KINDS: tuple[tuple[CameraType, ReadoutMode], ...] = (
    ("photon", "snapshot"),
    ("photon", "rolling"),
    ("microbolometer", "rolling"),
    ("microbolometer", "snapshot"),
)
ROWS, COLUMNS, N = 64, 80, 40
DELAY_S = 3e-3


def _still(scene: Scene) -> Scene:
    """Without noise, pattern, jitter, wander, blur and mirror image; few frames; the mask is as warm as the wheel."""
    return replace(
        scene,
        detector=replace(scene.detector, noise_dn=0.0, gain_spread=0.0, offset_spread_dn=0.0),
        radiance=replace(scene.radiance, narcissus_dn=0.0, mask_k=scene.radiance.wheel_k, reference_frames=0),
        optics=replace(scene.optics, blur_px=0.0),
        timing=replace(scene.timing, jitter_s=0.0, trigger_delay_s=DELAY_S),
        trigger=replace(scene.trigger, n_triggers=N),
        wander=SpeedWander(relative=0.0, ripples=()),
    )


@pytest.fixture(scope="module")
def photon() -> Scene:
    """Rolling photon camera: 4 ms and 200 us, a wheel with uneven edges."""
    scene = _still(camera_scene("photon", "rolling", rows=ROWS, columns=COLUMNS))
    edges = (0.0, math.pi / 2 + 4e-4, math.pi + 5e-4, 1.5 * math.pi - 3e-4)
    return replace(
        scene,
        wheel=replace(scene.wheel, ring_edges_rad=edges, cutout_errors_rad=(2e-4, -1e-4, 0.0, 3e-4)),
        timing=replace(scene.timing, integration_time_s=4e-3, row_delay_s=200e-6),
    )


@pytest.fixture(scope="module")
def lag() -> Scene:
    """Snapshot camera whose pixels lag by 6 ms."""
    scene = _still(camera_scene("microbolometer", "snapshot", rows=ROWS, columns=COLUMNS))
    return replace(scene, timing=replace(scene.timing, time_constant_s=6e-3))


def _timed(scene: Scene, **timing: float | None) -> Scene:
    return replace(scene, timing=replace(scene.timing, **timing))


def _frames(scene: Scene, *, seed: int = 5) -> np.ndarray:
    blocks = twin.simulate(scene, seed=seed).frames.blocks()
    return np.concatenate([block.copy() for _, block in blocks]).astype(float)


def _light(scene: Scene) -> np.ndarray:
    """Light of each row in pixels that see nothing but the blackbody, shape (frame, row)."""
    radiance = scene.radiance
    wheel, blackbody = radiance.level_dn(radiance.wheel_k), radiance.level_dn(radiance.blackbody_k)
    return (_frames(scene) - wheel).sum(axis=2) / (blackbody - wheel)


def _rate(scene: Scene) -> float:
    return 2 * math.pi * scene.trigger.wheel_hz


def _wheel_angle(scene: Scene, time_s: np.ndarray) -> np.ndarray:
    """Of a wheel that turns evenly, at times after each trigger, shape (n, 1) or (n, row)."""
    period_s = scene.trigger.camera_period_ticks / scene.trigger.clock_frequency_hz
    return scene.trigger.start_angle_rad + _rate(scene) * (np.arange(N)[:, None] * period_s + time_s)


def _open_before(scene: Scene, seen: np.ndarray) -> np.ndarray:
    """By how much a point was open while phi_A + theta - phi grew from 0 to ``seen``, rad: cutouts added up."""
    a0, a1, a2, a3 = scene.wheel.cutout_edges_rad
    turns, rest = np.divmod(seen, 2 * math.pi)
    spans = [(0.0, a0), (a1, a2), (a3, 2 * math.pi + min(a0, 0.0))]
    whole = sum(end - begin for begin, end in spans)
    return turns * whole + sum(np.clip(rest - begin, 0, end - begin) for begin, end in spans)


def _points(scene: Scene, row: int, *, fine: int = 60) -> np.ndarray:
    """Phi of even points of a row that lie in the mask's opening."""
    sub = (np.arange(fine) + 0.5) / fine - 0.5
    optics, mask = scene.optics, scene.mask
    down = (row + sub - optics.wheel_centre_row_px)[:, None] * optics.pixel_pitch_m
    right = (np.arange(COLUMNS)[:, None] + sub).ravel() - optics.wheel_centre_column_px
    x, y = np.broadcast_arrays(right * optics.pixel_pitch_m, down)
    radius, phi = np.hypot(x, y), np.arctan2(y, x)
    inside = (radius >= mask.inner_radius_m) & (radius <= mask.outer_radius_m)
    inside &= np.abs(np.angle(np.exp(1j * (phi - mask.centre_angle_rad)))) <= mask.opening_angle_rad / 2
    return phi[inside]


@pytest.mark.parametrize("row_delay_s", [200e-6, -200e-6])
def test_a_row_is_the_mean_over_its_window(photon: Scene, row_delay_s: float) -> None:
    """Oracle: for 3600 points of each pixel the share of the window in which a cutout lies over them, in closed form."""
    scene = _timed(photon, row_delay_s=row_delay_s)
    light, gate = _light(scene), math.pi / 2 + scene.beams.beta_1_rad
    window = _rate(scene) * 4e-3
    for row in (9, 17, 22):
        begin = gate + _wheel_angle(scene, np.array(DELAY_S + row * row_delay_s)) - _points(scene, row)
        expected = (_open_before(scene, begin + window) - _open_before(scene, begin)).sum(axis=1) / window / 3600
        assert expected.max() - expected.min() > 10
        assert light[:, row] == pytest.approx(expected, abs=0.02)


def _rows_at_once(scene: Scene) -> Iterator[tuple[int, np.ndarray]]:
    """Some rows, each from frames whose rows all begin when that row's turn comes."""
    row_delay_s = scene.timing.row_delay_s or 0.0
    for row in (0, 10, 21, 63):
        later_s = scene.timing.trigger_delay_s + row * row_delay_s
        yield row, _frames(_timed(scene, row_delay_s=0.0, trigger_delay_s=later_s))[:, row]


@pytest.mark.parametrize("row_delay_s", [20e-6, 200e-6, -40e-6])
def test_each_row_is_exposed_at_its_own_time(photon: Scene, row_delay_s: float) -> None:
    """Oracle: the same row of frames whose rows all begin so much later; but for rounding, blur and pattern included."""
    soft = replace(photon, optics=replace(photon.optics, blur_px=0.8))
    scene = _timed(replace(soft, detector=replace(soft.detector, gain_spread=0.02)), row_delay_s=row_delay_s)
    rolling = _frames(scene)
    for row, at_once in _rows_at_once(scene):
        assert rolling[:, row] == pytest.approx(at_once, abs=1.01)
    assert np.abs(rolling - _frames(_timed(scene, row_delay_s=0.0))).max() > 100


@pytest.mark.parametrize("window_rad", [0.01, 0.08, 1.7])
def test_the_passing_wheel_is_counted(photon: Scene, window_rad: float) -> None:
    """Oracle: the open share of a window in closed form, within one instant; per speed, its derivative within a tenth."""
    seen = window.response(photon.wheel, window_rad, instants=(np.arange(500) + 0.5) / 500)
    begin = np.linspace(0, 2 * math.pi, seen.level.size)

    def share(length: float) -> np.ndarray:
        return (_open_before(photon, begin + length) - _open_before(photon, begin)) / length

    assert np.abs(seen.level - share(window_rad)).max() <= 1 / 500 + 1e-9
    assert np.abs(seen.level - share(window_rad)).mean() < 1e-3 * window_rad
    slope = (share(window_rad * 1.001) - share(window_rad * 0.999)) / 0.002
    assert seen.per_speed @ slope / (slope @ slope) == pytest.approx(1, abs=0.1)


def test_without_row_delay_a_rolling_photon_camera_is_a_snapshot(photon: Scene) -> None:
    """Oracle: the snapshot, whose rays are counted frame by frame: rows within 1/20 of a pixel, all together within 1/500."""
    soft = replace(photon, optics=replace(photon.optics, blur_px=0.8))
    apart = _light(_timed(soft, row_delay_s=0.0)) - _light(_timed(soft, row_delay_s=None))
    assert np.abs(apart).max() < 0.05
    assert np.abs(apart.sum(axis=1)).max() < 0.1  # of 1100 pixels in the opening
    assert abs(apart.sum(axis=1).mean()) < 0.02


def test_without_row_delay_a_rolling_camera_with_lag_is_a_snapshot() -> None:
    """Oracle: equality of all frames, with noise, jitter, wander and pattern."""
    scene = camera_scene("microbolometer", rows=ROWS, columns=COLUMNS)
    scene = replace(scene, trigger=replace(scene.trigger, n_triggers=N))
    assert np.array_equal(_frames(_timed(scene, row_delay_s=0.0)), _frames(_timed(scene, row_delay_s=None)))


def test_a_window_is_as_long_as_the_wheel_was_fast(photon: Scene) -> None:
    """Oracle: the snapshot, whose instants are asked for one by one, while the wheel's speed swings by 1 %."""
    fast = replace(photon, wander=SpeedWander(relative=0.0, ripples=(Ripple(order=2, relative=1e-2),)))
    even = _light(_timed(photon, row_delay_s=None))
    rolling, snapshot = (_light(_timed(fast, row_delay_s=delay_s)) for delay_s in (0.0, None))
    assert np.abs(snapshot - even).max() > 0.2
    assert np.abs(rolling - snapshot).max() < 0.05


def test_a_short_window_is_one_instant(photon: Scene) -> None:
    """Oracle: the share of points that are open at that instant."""
    short = _timed(photon, integration_time_s=1e-7)
    light, gate = _light(short), math.pi / 2 + short.beams.beta_1_rad
    a0, a1, a2, a3 = short.wheel.cutout_edges_rad
    for row in (9, 22):
        seen = np.mod(gate + _wheel_angle(short, np.array(DELAY_S + row * 200e-6)) - _points(short, row), 2 * math.pi)
        is_open = (seen < a0) | ((seen >= a1) & (seen < a2)) | (seen >= a3)
        assert light[:, row] == pytest.approx(is_open.sum(axis=1) / 3600, abs=0.02)


def _lagged_share(scene: Scene, time_s: float) -> np.ndarray:
    """Open share of an ideal opening behind a first-order lag: its harmonics over 1 + i k omega tau, shape (frame,)."""
    n, lag_s = 2**15, scene.timing.time_constant_s
    theta = 2 * math.pi * np.arange(n) / n
    seen = math.pi / 2 + scene.beams.beta_1_rad + theta - scene.mask.centre_angle_rad
    half = scene.mask.opening_angle_rad / 2
    share = (_open_before(scene, seen + half) - _open_before(scene, seen - half)) / (2 * half)
    order = np.arange(n // 2 + 1)
    following = np.fft.irfft(np.fft.rfft(share) / (1 + 1j * order * _rate(scene) * lag_s), n)
    return np.interp(
        np.mod(_wheel_angle(scene, np.array(time_s))[:, 0], 2 * math.pi), theta, following, period=2 * math.pi
    )


@pytest.mark.parametrize("time_constant_s", [0.5e-3, 6e-3, 15e-3])
def test_all_rows_of_a_snapshot_lag_alike(lag: Scene, time_constant_s: float) -> None:
    """Oracle: the ideal sector's open share, a trapezium, through eq. (2) in closed form; the area of the sector."""
    scene = _timed(lag, time_constant_s=time_constant_s)
    mask = scene.mask
    area = mask.opening_angle_rad / 2 * (mask.outer_radius_m**2 - mask.inner_radius_m**2)
    share = _light(scene).sum(axis=1) * scene.optics.pixel_pitch_m**2 / area
    expected = _lagged_share(scene, DELAY_S)
    assert np.ptp(expected) > 0.8
    assert share == pytest.approx(expected, abs=6e-4)


def test_a_vanishing_lag_is_a_vanishing_window(lag: Scene) -> None:
    """Oracle: a photon camera of a short window whose middle is one lag before; other rays, so within a hundredth of a row."""
    lagging = _light(_timed(lag, time_constant_s=20e-6))
    timing = CameraTiming(trigger_delay_s=DELAY_S - 20e-6, integration_time_s=1e-7, jitter_s=0.0)
    assert lagging == pytest.approx(_light(replace(lag, timing=timing)), abs=0.04)


@pytest.mark.parametrize(("camera_type", "readout_mode"), KINDS)
def test_a_recording_says_its_kind_and_the_archive_takes_it(
    tmp_path: Path, camera_type: CameraType, readout_mode: ReadoutMode
) -> None:
    """Oracle: the two words, the numbers of the timing, and equality of what was written with what is read."""
    scene = camera_scene(camera_type, readout_mode, rows=32, columns=40)
    scene = replace(scene, trigger=replace(scene.trigger, n_triggers=120))
    made = next(twin.series(scene, [0.0], repeats=1, seed=3))
    writer.write(made, tmp_path / "one.nxs", truth=twin.truth(scene))
    read = reader.read(tmp_path / "one.nxs")
    assert (read.camera_type, read.readout_mode) == (camera_type, readout_mode)
    assert (read.integration_time_s is not None, read.nonuniformity is not None) == (camera_type == "photon",) * 2
    assert np.array_equal(read.frames.pick([0, 119]), made.frames.pick([0, 119]))
    assert [found for found in verify.verify(tmp_path / "one.nxs") if found.severity == "error"] == []
    truth, timing = twin.truth(scene), scene.timing
    assert (truth["camera"], truth["readout_mode"]) == (camera_type, readout_mode)
    own = "integration_time_s" if isinstance(timing, CameraTiming) else "time_constant_s"
    assert truth[own] == getattr(timing, own)
    assert truth.get("row_delay_s") == timing.row_delay_s
    assert (timing.row_delay_s is None) == (readout_mode == "snapshot")


def test_recordings_of_each_kind_have_names_of_their_own() -> None:
    """Oracle: four kinds, four names."""
    names = set()
    for camera_type, readout_mode in KINDS:
        scene = camera_scene(camera_type, readout_mode, rows=16, columns=16)
        scene = replace(scene, trigger=replace(scene.trigger, n_triggers=2))
        names.add(next(twin.series(scene, [0.0], repeats=1, seed=1)).name)
    assert names == {"cooled-3Hz-0ms", "cmos-3Hz-0ms", "bolo-3Hz-0ms", "lagging-3Hz-0ms"}


def test_references_may_be_left_out(photon: Scene) -> None:
    """Oracle: none with no frames of them, and so many as were asked for; the frames are the same."""
    with_some = replace(photon, radiance=replace(photon.radiance, reference_frames=7))
    some, none = (twin.simulate(scene, seed=2) for scene in (with_some, photon))
    assert none.nonuniformity is None
    assert some.nonuniformity is not None
    assert some.nonuniformity.n_frames == 7
    assert np.array_equal(some.frames.pick([3, 11]), none.frames.pick([3, 11]))


@pytest.mark.parametrize(("camera_type", "readout_mode"), KINDS)
def test_rigs_are_drawn_about_their_timing(camera_type: CameraType, readout_mode: ReadoutMode) -> None:
    """Oracle: mean and spread over 200 rigs are nominal and tolerance, within four standard errors; a snapshot stays one."""
    nominal, spread = camera_scene(camera_type, readout_mode, rows=32, columns=40), twin.Tolerances()
    timings = [twin.draw(nominal, seed=seed).scene.timing for seed in range(200)]
    wanted = {"trigger_delay_s": spread.trigger_delay_s if camera_type == "photon" else spread.bolometer_delay_s}
    if isinstance(nominal.timing, BolometerTiming):
        wanted["time_constant_s"] = spread.time_constant_s
    if readout_mode == "rolling":
        wanted["row_delay_s"] = spread.row_delay_s
    for name, sigma in wanted.items():
        values = np.array([getattr(timing, name) for timing in timings])
        assert values.mean() == pytest.approx(getattr(nominal.timing, name), abs=4 * sigma / math.sqrt(200))
        assert values.std() == pytest.approx(sigma, rel=4 / math.sqrt(400))
    assert {timing.row_delay_s is None for timing in timings} == {readout_mode == "snapshot"}


def test_rows_that_take_longer_than_a_frame_are_refused(photon: Scene) -> None:
    """Oracle: 64 rows of 500 us and a window of 4 ms are 36 ms, more than 33 ms; 64 of 450 us are 32.8 ms."""
    _frames(_timed(photon, row_delay_s=450e-6))
    with pytest.raises(
        PlanError, match="64 rows every 500 us for 4 ms each takes 36 ms, longer than the camera period"
    ):
        _frames(_timed(photon, row_delay_s=-500e-6))
