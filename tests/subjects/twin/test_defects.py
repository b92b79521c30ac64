"""Defects of a laboratory in the twin, each against what a loop or a hand can say of it."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from irtiming.errors import PlanError
from irtiming.records.arrays import Pixels
from irtiming.twin import rig as twin
from irtiming.twin.clockwork import spin, tick_streams
from irtiming.twin.defects import Defects, defects_of, with_defects
from irtiming.twin.frames import SimulatedFrames
from irtiming.twin.glare import stray_places, tail_table, veil_of
from irtiming.twin.in_camera import InCamera
from irtiming.twin.kernels import grade, to_rig
from irtiming.twin.noise import Values
from irtiming.twin.optics import Optics
from irtiming.twin.processed_frames import ProcessedFrames
from irtiming.twin.rays import view_of
from irtiming.twin.scene import CameraTiming, ChopperWheel, MaskPlate, Scene, microbolometer_scene, paper_scene
from irtiming.twin.spread import graded_spread, pixel_spread
from irtiming.twin.sway import swayed
from irtiming.twin.upkeep import SelfCorrection, ShutterEvent, Sway
from irtiming.twin.window import centre_s, instants_s, weights

_QUIET = {"noise_dn": 0.0, "gain_spread": 0.0, "offset_spread_dn": 0.0}


def _frames(scene: Scene, *, seed: int = 1) -> np.ndarray:
    return np.concatenate([block.copy() for _, block in twin.simulate(scene, seed=seed).frames.blocks()]).astype(float)


def _short(scene: Scene, n: int = 24) -> Scene:
    return replace(scene, trigger=replace(scene.trigger, n_triggers=n), detector=replace(scene.detector, **_QUIET))


@pytest.fixture(scope="module")
def photon() -> Scene:
    """Twenty-four frames of 64 x 80 pixels without noise or pattern."""
    return _short(paper_scene(64, 80))


@pytest.fixture(scope="module")
def bolometer() -> Scene:
    """The same of a microbolometer."""
    return _short(microbolometer_scene(64, 80))


def test_edges_are_late_by_exactly_the_latency(photon: Scene) -> None:
    """Oracle: the same wheel's timestamps plus 50 and 30 whole ticks."""
    tick_s = 1 / photon.trigger.clock_frequency_hz
    late = with_defects(photon, Defects(late_application_gate_s=50 * tick_s, late_control_gate_s=30 * tick_s))
    motion = spin(photon, seed=3)
    prompt, delayed = (tick_streams(scene, motion, seed=3) for scene in (photon, late))
    for before, after, by in (
        (prompt.application_slot, delayed.application_slot, 50),
        (prompt.application_edges, delayed.application_edges, 50),
        (prompt.control_slot, delayed.control_slot, 30),
    ):
        common = min(before.size, after.size)
        same = [np.abs(after[k : k + common - 2] - before[: common - 2] - by).max() for k in (0, 1)]
        assert min(same) <= 1  # rounding of times near a tick
    assert np.array_equal(prompt.camera_trigger, delayed.camera_trigger)


def test_a_late_trigger_is_a_later_delay(photon: Scene) -> None:
    """Oracle: the frames of a camera whose own delay is that much longer."""
    late = with_defects(photon, Defects(late_trigger_s=0.5e-3))
    longer = replace(photon, timing=replace(photon.timing, trigger_delay_s=photon.timing.trigger_delay_s + 0.5e-3))
    assert np.array_equal(_frames(late), _frames(longer))
    assert not np.array_equal(_frames(late), _frames(photon))


def test_a_fast_clock_counts_more_ticks_in_a_second(photon: Scene) -> None:
    """Oracle: true seconds are ticks / (f (1 + e)): the set delay of 100 ms in ticks lasts 100 ms / (1 + e)."""
    fast = with_defects(photon, Defects(clock_relative_error=1e-3))
    trigger = fast.trigger
    assert trigger.true_frequency_hz == pytest.approx(photon.trigger.clock_frequency_hz * 1.001, rel=1e-15)
    assert twin.simulate(fast, seed=1).clock_frequency_hz == photon.trigger.clock_frequency_hz
    motion = spin(fast, seed=1)
    turns_hz = (motion.angle_rad[-1] - motion.angle_rad[0]) / (motion.time_s[-1] - motion.time_s[0]) / (2 * math.pi)
    assert turns_hz == pytest.approx(3.003, rel=2e-4)
    edges = tick_streams(fast, motion, seed=1).application_slot
    assert np.diff(edges[::2]).mean() == pytest.approx(trigger.turn_period_ticks, rel=2e-4)


def test_beams_aside() -> None:
    """Oracle: tan beta_1 = (d - x) / h and tan beta_2 = (d + x) / (h - dh), by hand."""
    beams = with_defects(paper_scene(64, 80), Defects(lateral_offset_m=0.2e-3)).beams
    assert math.tan(beams.beta_1_rad) == pytest.approx((13.0 - 0.2) / 47.3, rel=1e-12)
    assert math.tan(beams.beta_2_rad) == pytest.approx((13.0 + 0.2) / (47.3 - 5.5), rel=1e-12)


def test_a_tilted_plane_is_projected_as_turned_points_are() -> None:
    """Oracle: points of the plane turned by 3-D rotation matrices, x_image = f X / Z, then distorted about the lens's axis."""
    optics = Optics(
        pixel_pitch_m=0.5e-3, wheel_centre_row_px=66.0, wheel_centre_column_px=88.0, roll_rad=0.03, distortion=-0.04,
        tilt_about_row_rad=0.05, tilt_about_column_rad=-0.03, focal_length_px=300.0,
        lens_centre_row_px=4.0, lens_centre_column_px=-6.0,
    )  # fmt: skip
    view = view_of(ChopperWheel(), MaskPlate(), optics=optics, shape=(120, 160))
    lens = np.array([(120 - 1) / 2 + 4.0, (160 - 1) / 2 - 6.0])
    half_diagonal = math.hypot(120, 160) / 2
    a, b, rho = 0.05, -0.03, 0.03
    about_row = np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])
    about_column = np.array([[math.cos(b), 0, math.sin(b)], [0, 1, 0], [-math.sin(b), 0, math.cos(b)]])
    roll = np.array([[math.cos(rho), -math.sin(rho), 0], [math.sin(rho), math.cos(rho), 0], [0, 0, 1]])
    axle = np.array([view.axle_column, view.axle_row, 300.0])
    for x, y in ((0.0, 0.0), (0.02, -0.01), (-0.015, 0.018), (0.0, -0.02)):
        point = axle + about_column @ about_row @ roll @ np.array([x, y, 0.0]) / optics.pixel_pitch_m
        flat = 300.0 * point[[1, 0]] / point[2]
        seen = lens + flat * (1 - 0.04 * float(flat @ flat) / half_diagonal**2)
        assert to_rig(seen[0], seen[1], view) == pytest.approx((x, y), abs=1e-9)
    assert to_rig(66.0, 88.0, view) == pytest.approx((0, 0), abs=1e-12)


def test_what_is_below_a_tilted_axis_recedes() -> None:
    """Oracle: the sign: a plane that recedes below shows more of itself between two rows there than above."""
    optics = Optics(
        wheel_centre_row_px=59.5, wheel_centre_column_px=79.5, tilt_about_row_rad=0.1, focal_length_px=300.0
    )
    view = view_of(ChopperWheel(), MaskPlate(), optics=optics, shape=(120, 160))
    above, below = to_rig(19.5, 79.5, view)[1], to_rig(99.5, 79.5, view)[1]
    assert below > -above > 0


@pytest.mark.parametrize("blurs", [(0.55, 0.95), (1.0, 0.5)])
def test_elliptical_blur_has_its_variances(blurs: tuple[float, float]) -> None:
    """Oracle: variances of a uniform square and a Gaussian add up along each axis; no covariance."""
    place = pixel_spread(1024, blurs, variants=2).astype(float)
    assert place.var(axis=1) == pytest.approx(np.tile([1 / 12 + blur**2 for blur in blurs], (2, 1)), rel=1e-5)
    assert [np.cov(one.T)[0, 1] for one in place] == pytest.approx([0, 0], abs=1e-6)


@pytest.mark.parametrize(("turn_deg", "sign"), [(45, 1), (-45, -1), (135, -1)])
def test_a_blur_that_is_turned_smears_along_a_diagonal(turn_deg: float, sign: int) -> None:
    """Oracle: by hand: half of both variances along each axis, their difference from upper left to lower right."""
    place = pixel_spread(1024, (0.5, 0.9), turn_rad=math.radians(turn_deg), variants=2).astype(float)
    assert place.var(axis=1) == pytest.approx(np.full((2, 2), 1 / 12 + (0.25 + 0.81) / 2), rel=2e-3)
    assert [np.cov(one.T)[0, 1] for one in place] == pytest.approx([sign * (0.81 - 0.25) / 2] * 2, rel=2e-3)


def test_a_blur_that_grows_is_wider_in_each_step_to_the_corners() -> None:
    """Oracle: variances in the middle of 12 steps by hand; the corner, the middle and a place half way in the right ones."""
    optics = Optics(blur_rows_px=0.5, blur_columns_px=0.9, blur_growth=2.0)
    place = graded_spread(1024, optics, variants=2).astype(float)
    assert place.shape == (12, 2, 1024, 2)
    for step in (0, 5, 11):
        larger = 1 + 2.0 * (step + 0.5) / 12
        expected = [1 / 12 + larger * blur**2 for blur in (0.5, 0.9)]
        assert place[step].var(axis=1) == pytest.approx(np.tile(expected, (2, 1)), rel=1e-5)
    view = view_of(ChopperWheel(), MaskPlate(), optics=optics, shape=(101, 201))
    places = (50, 100), (0, 0), (100, 200), (50, 180)
    assert [grade(*place, view, 32) for place in places] == [0, 31, 31, 16]
    assert graded_spread(64, Optics(), variants=2).shape == (1, 2, 64, 2)


def test_a_blur_that_shrinks_to_nothing_is_refused() -> None:
    """Oracle: by hand; a variance of nought in the corners."""
    with pytest.raises(PlanError, match="it must grow by -0.9 to 20"):
        Optics(blur_growth=-1.0)


@pytest.mark.parametrize("shape", ["gaussian", "exponential"])
def test_the_tail_keeps_all_light_and_has_its_width(shape: str) -> None:
    """Oracle: shares add up to 1; the standard deviation along each axis is the one that was asked for."""
    optics = Optics(glare_share=0.03, glare_px=5.0, glare_shape=shape)
    table, n = tail_table(optics), tail_table(optics).shape[0] // 2
    assert table.sum() == pytest.approx(1, abs=1e-12)
    axis = np.arange(-n, n + 1)
    for side in (0, 1):
        assert math.sqrt(float(table.sum(axis=side) @ axis**2)) == pytest.approx(5.0, rel=0.02)
    places = stray_places(optics, 600, variants=4).astype(float)
    assert places.std(axis=1) == pytest.approx(5.0, rel=0.03)
    assert places.mean(axis=1) == pytest.approx(0, abs=0.15)


def test_the_veil_is_a_sum_over_pixels() -> None:
    """Oracle: the convolution pixel by pixel, with the border gone on with; a uniform image stays as it is."""
    optics = Optics(glare_share=0.2, glare_px=1.5, glare_shape="gaussian")
    veil, table = veil_of(optics, rows_columns=(20, 26)), tail_table(optics)
    assert veil is not None
    signal = np.random.Generator(np.random.SFC64(1)).normal(5000, 800, (20, 26)).astype(np.float32)
    n = table.shape[0] // 2
    wide = np.pad(signal.astype(float), n, mode="edge")
    wanted = np.empty((20, 26))
    for row in range(20):
        for column in range(26):
            wanted[row, column] = (wide[row : row + 2 * n + 1, column : column + 2 * n + 1] * table).sum()
    seen = signal.copy()
    veil.cover(seen)
    assert seen == pytest.approx(0.8 * signal + 0.2 * wanted, abs=0.05)
    flat = np.full((20, 26), 4321.0, np.float32)
    veil.cover(flat)
    assert flat == pytest.approx(4321.0, abs=0.01)


def test_glare_is_the_same_by_frames_and_by_rays(photon: Scene) -> None:
    """Oracle: the other way: a snapshot whose frames are veiled, and a rolling camera whose rays go astray, read at once."""
    glare = with_defects(
        replace(photon, radiance=replace(photon.radiance, narcissus_dn=0.0)),
        Defects(glare_share=0.1, glare_px=3.0, glare_shape="gaussian"),
    )
    rolling = replace(glare, timing=replace(glare.timing, row_delay_s=0.0))
    at_once, by_rays, without = _frames(glare), _frames(rolling), _frames(with_defects(photon, Defects()))
    contrast = np.ptp(without)
    inner = (slice(None), slice(12, -12), slice(12, -12))
    assert np.abs(at_once - by_rays)[inner].max() < 0.05 * contrast
    assert math.sqrt(float(np.mean((at_once - by_rays)[inner] ** 2))) < 0.0015 * contrast
    assert math.sqrt(float(np.mean((at_once - without)[inner] ** 2))) > 0.008 * contrast


@pytest.mark.parametrize("row_delay_s", [None, 0.0])
def test_one_blade_is_warmer(photon: Scene, row_delay_s: float | None) -> None:
    """Oracle: a pixel in the opening that is covered for long shows two levels, apart by the share of the contrast."""
    scene = with_defects(photon, Defects(blade_share=0.012))
    scene = replace(
        scene,
        timing=replace(scene.timing, row_delay_s=row_delay_s),
        trigger=replace(scene.trigger, n_triggers=120),
        radiance=replace(scene.radiance, narcissus_dn=0.0),
    )
    row, column = 14, 40  # at 12 o'clock
    values = _frames(scene)[:, row, column]
    covered = values[values < values.min() + 0.02 * np.ptp(values)]
    levels, times = np.unique(covered, return_counts=True)
    common = np.sort(levels[np.argsort(times)[-2:]])
    contrast_dn = scene.radiance.dn_per_k * (scene.radiance.blackbody_k - scene.radiance.wheel_k)
    assert common[1] - common[0] == pytest.approx(0.012 * contrast_dn, abs=1.1)
    assert np.isin(covered, common).mean() > 0.9
    assert 0.35 < np.mean(covered == common[1]) < 0.65


def test_the_filter_runs_over_all_frames_and_some_are_lost_later(photon: Scene) -> None:
    """Oracle: the recursion in a loop on the frames of the same camera without it."""
    k, plain = 0.3, _frames(photon)
    filtered = replace(with_defects(photon, Defects(filter_share=k)), faults=replace(photon.faults, lost_frames=5))
    recording = twin.simulate(filtered, seed=1)
    before, wanted = plain[0].copy(), []
    for frame in plain:
        before = (1 - k) * frame + k * before
        wanted.append(before)
    found = np.concatenate([block.copy() for _, block in recording.frames.blocks()])
    assert len(found) == len(plain) - 5
    assert np.abs(found - np.array(wanted)[recording.frame_number]).max() <= 1.01  # both are rounded
    assert np.array_equal(recording.frames.pick([7, 2]), found[[7, 2]])


def test_a_weak_filter_is_not_lost_by_rounding() -> None:
    """Oracle: the recursion in a loop over numbers that are not whole, which move by less than half a DN over its share."""
    k, wave = 0.005, 1000.25 + 40 * np.sin(np.arange(60.0))

    def make(index: int, *, signal_dn: Values, out: Pixels | Values) -> None:
        out[...] = wave[index]

    frames = ProcessedFrames(
        detector=SimulatedFrames(shape=(60, 2, 3), make=make), kept=np.arange(60), in_camera=InCamera(filter_share=k)
    )
    before, wanted = wave[0], []
    for value in wave:
        before = (1 - k) * value + k * before
        wanted.append(before)
    found = np.concatenate([block for _, block in frames.blocks()])[:, 1, 2]
    assert np.array_equal(found, np.rint(wanted))
    assert np.count_nonzero(found != np.rint(wave)) > 5


def test_memory_and_mean_of_frames(bolometer: Scene) -> None:
    """Oracle: the sums in a loop on the frames of the same camera without them."""
    plain = _frames(bolometer)
    kept = _frames(with_defects(bolometer, Defects(memory_share=0.2)))
    assert np.abs(kept[1:] - (0.8 * plain[1:] + 0.2 * plain[:-1])).max() <= 1.01
    mean = _frames(with_defects(bolometer, Defects(averaged_frames=3)))
    assert np.abs(mean[2:] - (plain[2:] + plain[1:-1] + plain[:-2]) / 3).max() <= 1.01
    with pytest.raises(PlanError, match="filter of 1"):
        InCamera(filter_share=1.0)


def test_a_window_is_weighed_as_it_is_shaped() -> None:
    """Oracle: the trapezoid and the exponential integrated by hand: their means, and where half has been counted."""
    box = CameraTiming(integration_time_s=200e-6, rise_s=20e-6, fall_s=10e-6)
    table = weights(box)
    assert table.weight.sum() == pytest.approx(1, abs=1e-12)
    centre = (200e-6**2 / 2 + (10e-6**2 - 20e-6**2) / 24) / 200e-6
    assert centre_s(box) == pytest.approx(centre, abs=1e-9)
    tail = replace(box, tail_share=0.04, tail_s=0.3e-3)
    wanted = 0.96 * centre + 0.04 * (200e-6 + 0.3e-3 * (1 - 8 * math.exp(-8) / (1 - math.exp(-8))))
    assert centre_s(tail) == pytest.approx(wanted, abs=2e-9)
    assert instants_s(tail).mean() == pytest.approx(wanted, abs=3e-7)
    assert np.all(np.diff(instants_s(tail)) > 0)
    assert centre_s(CameraTiming(integration_time_s=200e-6)) == 100e-6


def test_levels_sway_by_what_was_asked_for() -> None:
    """Oracle: from the lowest to the highest value within 33 s; another shape in another run, and none without sway."""
    time = np.linspace(0, 33, 400)
    one, other = (swayed(Sway(gain_share=0.03, offset_share=0.02), time, seed=seed) for seed in (1, 2))
    assert np.ptp(one.gain) == pytest.approx(0.03, rel=0.01)
    assert np.ptp(one.offset) == pytest.approx(0.02, rel=0.01)
    assert one.gain[0] == pytest.approx(0, abs=1e-12)
    assert np.abs(one.gain - other.gain).max() > 0.003
    assert not swayed(Sway(), time, seed=1).gain.any()


def test_sway_goes_about_the_wheels_level(photon: Scene) -> None:
    """Oracle: signal' = wheel + (1 + g) (signal - wheel) + o contrast, on the frames of the same camera without it."""
    still = replace(photon, radiance=replace(photon.radiance, narcissus_dn=0.0))
    moved = with_defects(still, Defects(sway_share=0.05))
    sway = swayed(moved.sway, np.arange(24) * 1_622_016 / 49_152_000, seed=1)
    wheel = still.radiance.level_dn(still.radiance.wheel_k)
    contrast = still.radiance.level_dn(still.radiance.blackbody_k) - wheel
    gain, offset = sway.gain[:, None, None], sway.offset[:, None, None]
    assert np.abs(_frames(moved) - (wheel + (1 + gain) * (_frames(still) - wheel) + offset * contrast)).max() < 1.1


def test_a_photon_camera_may_close_a_shutter(photon: Scene) -> None:
    """Oracle: the shutter's level while it is closed, and the jump afterwards; before it nothing changes."""
    event = ShutterEvent(start_s=0.2, duration_s=0.2, level_jump_dn=40.0)
    frames = _frames(replace(photon, correction=SelfCorrection(surface_k=300.15, events=(event,))))
    time, plain = np.arange(24) * 0.033, _frames(photon)
    closed = (time > 0.2) & (time < 0.39)
    assert frames[closed] == pytest.approx(photon.radiance.level_dn(300.15), abs=1)
    assert np.array_equal(frames[time < 0.19], plain[time < 0.19])
    assert frames[time > 0.41] - plain[time > 0.41] == pytest.approx(40, abs=1)


def test_references_may_be_taken_anew(photon: Scene) -> None:
    """Oracle: two recordings have the same references, or not."""
    scene = replace(photon, detector=replace(photon.detector, noise_dn=10.0))
    anew = with_defects(scene, Defects(references_anew=True))
    for one, same in ((scene, True), (anew, False)):
        first, second = (twin.simulate(one, seed=seed).nonuniformity for seed in (1, 2))
        assert first is not None
        assert second is not None
        assert np.array_equal(first.low_dn, second.low_dn) == same


def test_values_go_with_a_power_of_the_signal(bolometer: Scene) -> None:
    """Oracle: the power by hand on the frames of the same camera without it; blackbody at 6000 DN, wheel at 6640."""
    plain, bent = _frames(bolometer), _frames(with_defects(bolometer, Defects(exponent=0.9)))
    low, span = 6000 - 0.2 * 640, 1.4 * 640
    assert np.abs(bent - (low + span * ((plain - low) / span) ** 0.9)).max() <= 1.1  # both are rounded
    assert np.abs(bent - plain).max() > 20
    with pytest.raises(PlanError, match="exponent 9"):
        with_defects(bolometer, Defects(exponent=9.0))


def test_a_stated_integration_time_may_be_off(photon: Scene) -> None:
    """Oracle: the recording's value is longer by the error; the frames are the same."""
    off = with_defects(photon, Defects(count_time_error_s=12.5e-6))
    assert twin.simulate(off, seed=1).integration_time_s == pytest.approx(262.5e-6, rel=1e-12)
    assert np.array_equal(_frames(off), _frames(photon))


def test_the_truth_names_every_defect(photon: Scene) -> None:
    """Oracle: the fields of the record: read back from the scene and from truth.json."""
    asked = Defects(
        **{field.name: 0.01 for field in fields(Defects) if field.name.endswith("_share") or field.name.startswith("tilt")},
        distortion=-0.02, blur_rows_px=0.6, blur_columns_px=0.8, late_trigger_s=1e-6, rise_s=5e-6, averaged_frames=2,
    )  # fmt: skip
    scene = with_defects(photon, asked)
    assert defects_of(scene) == asked
    assert {field.name for field in fields(Defects)} <= set(twin.truth(scene))


def test_defects_that_cannot_be_are_refused(bolometer: Scene, photon: Scene) -> None:
    """Oracle: the message says what and why."""
    with pytest.raises(PlanError, match="which has none"):
        with_defects(bolometer, Defects(tail_share=0.02))
    with pytest.raises(PlanError, match="shorter than the window"):
        with_defects(photon, Defects(rise_s=300e-6))
    with pytest.raises(PlanError, match="blade"):
        Defects(blade_share=2.0)
    with pytest.raises(PlanError, match="glare of 2"):
        with_defects(photon, Defects(glare_share=2.0))
