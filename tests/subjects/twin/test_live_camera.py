"""A camera that is triggered while the wheel turns: the frames of a recording, one at a time."""

import time
from dataclasses import replace

import numpy as np
import pytest

from irtiming.twin import rig as twin
from irtiming.twin.cameras import camera_scene
from irtiming.twin.clockwork import TickStreams
from irtiming.twin.driven_wheel import DrivenWheel
from irtiming.twin.live_camera import LiveCamera
from irtiming.twin.scene import RadiativeExchange, microbolometer_scene, paper_scene
from irtiming.twin.upkeep import Drift, SelfCorrection, ShutterEvent

CLOCK_HZ = 48_000_000
SLOT = 160_000  # cycles at 3 turns a second
TURN = 100 * SLOT
PERIOD = 1_584_000  # 30.3 Hz
STEP = 240_000  # 5 ms


class Bench:
    """Turns a wheel by hand and triggers a camera, as a simulated trigger generator does."""

    def __init__(self, scene, **options):
        self.wheel = DrivenWheel(scene, clock_frequency_hz=CLOCK_HZ, seed=3, remembers=True)
        self.camera = LiveCamera(scene, self.wheel, clock_frequency_hz=CLOCK_HZ, seed=11, **options)
        self.frames = []
        self.cycle = 0

    def turn(self, cycles, *, slot=SLOT, triggers=()):
        triggers, end = np.asarray(triggers, dtype=np.int64), self.cycle + cycles
        while self.cycle < end:
            until = min(self.cycle + STEP, end)
            self.wheel.turn(until, slot_period_cycles=slot)
            now = triggers[(triggers >= self.cycle) & (triggers < until)]
            if now.size:
                self.camera.trigger(now)
            self.cycle = until

    def begin(self, **options):
        self.camera.begin(self.frames.append, **({"trigger": "line"} | options))

    def wait_for(self, n, *, limit_s=20.0):
        until = time.monotonic() + limit_s
        while len(self.frames) < n and time.monotonic() < until:
            time.sleep(0.005)
        assert len(self.frames) == n

    def taken(self, triggers, *, more=3 * PERIOD):
        """Frames of these triggers."""
        self.turn(int(triggers[-1]) + more - self.cycle, triggers=triggers)
        self.wait_for(len(triggers))
        return np.stack([frame.pixels for frame in self.frames])


def _at_speed(scene):
    """The scene with the numbers of the bench."""
    trigger = replace(
        scene.trigger,
        clock_frequency_hz=float(CLOCK_HZ),
        turn_period_ticks=TURN,
        camera_period_ticks=PERIOD,
        n_triggers=40,
    )
    return replace(scene, trigger=trigger)


def _recorded(bench, scene, triggers, *, seed=11):
    nothing = np.empty(0, dtype=np.int64)
    ticks = TickStreams(
        camera_trigger=triggers, control_slot=nothing, application_slot=nothing, application_edges=nothing
    )
    run = replace(scene, trigger=replace(scene.trigger, n_triggers=len(triggers)))
    recording = twin.recorded(run, bench.wheel.motion_from(int(triggers[0])), ticks=ticks, seed=seed)
    return recording.frames.pick(list(range(len(triggers))))


def _are_the_same(frames, recorded):
    """Whether but for some last digits of a float32."""
    assert frames.shape == recorded.shape
    off = np.abs(frames.astype(int) - recorded.astype(int))
    assert off.max() <= 1
    assert np.count_nonzero(off) <= 1e-4 * off.size


EVENTS = (
    ShutterEvent(start_s=0.2, duration_s=0.15, kind="closed"),
    ShutterEvent(start_s=0.7, duration_s=0.2, kind="frozen"),
)
BOLOMETER = microbolometer_scene(48, 64)
ROLLING_PHOTON = camera_scene("photon", "rolling", rows=48, columns=64)
SNAPSHOT_LAG = camera_scene("microbolometer", "snapshot", rows=48, columns=64)
KINDS = pytest.mark.parametrize(
    "scene",
    [paper_scene(64, 80), BOLOMETER, ROLLING_PHOTON, SNAPSHOT_LAG],
    ids=["photon", "microbolometer", "rolling photon", "snapshot lag"],
)


@pytest.mark.parametrize(
    "scene",
    [
        paper_scene(64, 80),
        BOLOMETER,
        replace(BOLOMETER, timing=replace(BOLOMETER.timing, row_delay_s=-50e-6)),
        replace(BOLOMETER, correction=SelfCorrection(events=EVENTS), drift=Drift(per_second_dn=3.0, settling_dn=20.0)),
        replace(BOLOMETER, timing=replace(BOLOMETER.timing, radiative=RadiativeExchange(scene_time_constant_s=30e-3))),
        replace(ROLLING_PHOTON, timing=replace(ROLLING_PHOTON.timing, integration_time_s=4e-3)),
        SNAPSHOT_LAG,
    ],
    ids=[
        "photon",
        "microbolometer",
        "last row first",
        "shutter and drift",
        "radiating pixels",
        "rolling photon",
        "snapshot lag",
    ],
)
def test_frames_are_those_of_a_recording_with_the_same_wheel_and_triggers(scene):
    """Oracle: `twin.rig.recorded`, which makes all frames at the end."""
    scene = _at_speed(twin.draw(scene, seed=5).scene)
    triggers = TURN + PERIOD * np.arange(40)
    bench = Bench(scene)
    with bench.camera:
        bench.turn(TURN // 2)
        bench.begin()
        frames = bench.taken(triggers)
    assert bench.camera.triggers_ignored == 0
    assert [frame.moment.number for frame in bench.frames] == list(range(40))
    _are_the_same(frames, _recorded(bench, scene, triggers))


def test_a_second_acquisition_counts_anew_and_has_noise_of_its_own():
    """Oracle: the recording with the next seed."""
    scene = _at_speed(paper_scene(32, 40))
    bench = Bench(scene)
    with bench.camera:
        for run in range(2):
            bench.frames.clear()
            bench.begin()
            triggers = bench.cycle + PERIOD * np.arange(1, 6)
            frames = bench.taken(triggers)
            bench.camera.end()
            assert [frame.moment.number for frame in bench.frames] == list(range(5))
            _are_the_same(frames, _recorded(bench, scene, triggers, seed=11 + run))


def test_nothing_comes_without_an_acquisition_or_from_another_kind_of_trigger():
    """Oracle: counting: one frame for the one command, none for edges before, between and after."""
    bench = Bench(paper_scene(32, 40))
    with bench.camera:
        bench.turn(PERIOD, triggers=[PERIOD // 2])
        bench.begin(trigger="software")
        bench.turn(PERIOD, triggers=[bench.cycle + 5])
        bench.camera.trigger_now()
        bench.turn(PERIOD)
        bench.wait_for(1)
        bench.camera.end()
        bench.turn(PERIOD, triggers=[bench.cycle + 5])
        time.sleep(0.05)
    assert len(bench.frames) == 1


@KINDS
def test_a_frame_leaves_when_its_last_row_is_read_and_not_before(scene):
    """Oracle: by hand: trigger delay, and integration time or all row delays, in cycles of 48 MHz."""
    timing = replace(scene.timing, jitter_s=0.0)
    rows_s = (timing.row_delay_s or 0.0) * (scene.detector.rows - 1)
    last_s = timing.trigger_delay_s + rows_s + getattr(timing, "integration_time_s", 0.0)
    bench = Bench(replace(scene, timing=timing))
    with bench.camera:
        bench.turn(PERIOD)
        bench.begin()
        trigger = bench.cycle
        bench.turn(STEP // 100, triggers=[trigger])
        bench.turn(round(last_s * CLOCK_HZ) - STEP // 100 - 10)
        time.sleep(0.05)
        assert not bench.frames
        bench.turn(20)
        bench.wait_for(1)
    moment = bench.frames[0].moment
    assert moment.trigger_cycle == trigger
    assert abs(moment.start_cycle - trigger - timing.trigger_delay_s * CLOCK_HZ) <= 1
    assert abs(moment.end_cycle - trigger - last_s * CLOCK_HZ) <= 1


def test_a_trigger_while_rows_are_read_is_ignored():
    """Oracle: by hand: 48 rows of 38.76 us take 1.86 ms; of triggers 1.5 ms apart every other one counts."""
    bench = Bench(BOLOMETER)
    with bench.camera:
        bench.begin()
        bench.turn(10 * PERIOD, triggers=PERIOD + 72_000 * np.arange(10))
        bench.wait_for(5)
    assert bench.camera.triggers_ignored == 5
    assert [frame.moment.trigger_cycle for frame in bench.frames] == [PERIOD + 144_000 * k for k in range(5)]


def test_a_trigger_while_rows_still_integrate_is_ignored():
    """Oracle: by hand: 47 row delays of 20 us and a window of 1 ms take 1.94 ms; of triggers 1.5 ms apart every other one."""
    bench = Bench(replace(ROLLING_PHOTON, timing=replace(ROLLING_PHOTON.timing, integration_time_s=1e-3)))
    with bench.camera:
        bench.begin()
        bench.turn(10 * PERIOD, triggers=PERIOD + 72_000 * np.arange(10))
        bench.wait_for(5)
    assert bench.camera.triggers_ignored == 5


def test_a_camera_that_triggers_itself_keeps_its_rate():
    """Oracle: 48 MHz over 50 Hz."""
    bench = Bench(paper_scene(32, 40))
    with bench.camera:
        bench.begin(trigger="none", frame_rate_hz=50.0)
        for _ in range(40):
            bench.turn(480_000)
            time.sleep(0.004)
        bench.wait_for(20)
    assert set(np.diff([frame.moment.trigger_cycle for frame in bench.frames])) == {960_000}


@KINDS
def test_before_a_wheel_that_stands_all_frames_are_alike(scene):
    """Oracle: the angle: where a wheel came to rest 45 degrees further, other pixels are open; noise apart, nothing moves."""
    scene = replace(scene, detector=replace(scene.detector, noise_dn=0.0))
    bench = Bench(scene)
    with bench.camera:
        bench.begin()
        bench.turn(10 * PERIOD, slot=0, triggers=PERIOD * np.arange(1, 4))
        bench.wait_for(3)
        bench.turn(TURN // 8)
        turned = bench.wheel.angle_at(np.array(bench.cycle))
        stands = bench.cycle
        bench.turn(10 * PERIOD, slot=0, triggers=stands + PERIOD * np.arange(1, 4))
        bench.wait_for(6)
    assert turned - bench.wheel.angle_at(np.array(0)) == pytest.approx(np.pi / 4, rel=1e-3)
    assert bench.wheel.angle_at(np.array(bench.cycle)) == turned
    pixels = [frame.pixels for frame in bench.frames]
    for frame in pixels[1:3]:
        assert np.array_equal(frame, pixels[0])
    for frame in pixels[4:]:
        assert np.array_equal(frame, pixels[3])
    assert np.count_nonzero(pixels[3] != pixels[0]) > 0.05 * pixels[0].size


@KINDS
def test_another_blackbody_temperature_is_that_of_a_scene_with_it(scene):
    """Oracle: the recording of a scene whose blackbody has this temperature from the beginning."""
    scene, warmer_k = _at_speed(scene), scene.radiance.blackbody_k + 1.5
    bench = Bench(scene, blackbody_k=lambda cycle: warmer_k if cycle > 2 * TURN else scene.radiance.blackbody_k)
    warm = replace(scene, radiance=replace(scene.radiance, blackbody_k=warmer_k))
    with bench.camera:
        bench.turn(TURN)
        bench.begin()
        triggers = TURN + PERIOD * np.arange(30)
        frames = bench.taken(triggers)
    late = np.array([frame.moment.start_cycle > 2 * TURN for frame in bench.frames])
    assert 0 < late.sum() < late.size
    _are_the_same(frames[late], _recorded(bench, warm, triggers)[late])
    _are_the_same(frames[~late], _recorded(bench, scene, triggers)[~late])


def test_a_lens_for_another_speed_is_as_good_as_one_that_was_traced_for_it():
    """Oracle: the recording at that speed, whose lens is traced for it: within a DN; one blade is warmer."""
    radiance = replace(BOLOMETER.radiance, blade_share=0.2)
    scene = _at_speed(replace(BOLOMETER, detector=replace(BOLOMETER.detector, noise_dn=0.0), radiance=radiance))
    bench = Bench(scene)
    slow = replace(scene, trigger=replace(scene.trigger, turn_period_ticks=2 * TURN))
    with bench.camera:
        bench.turn(TURN, slot=2 * SLOT)
        bench.begin()
        triggers = TURN + PERIOD * np.arange(10)
        bench.turn(int(triggers[-1]) + 3 * PERIOD - TURN, slot=2 * SLOT, triggers=triggers)
        bench.wait_for(10)
    frames = np.stack([frame.pixels for frame in bench.frames])
    assert np.abs(frames.astype(int) - _recorded(bench, slow, triggers)).max() <= 1


def test_the_bare_blackbody_is_even_and_has_its_level():
    """Oracle: the level of the radiance at that temperature; the spread of gain and noise of the detector."""
    scene = paper_scene(64, 80)
    bench = Bench(scene, blackbody_k=lambda cycle: 290.0)
    with bench.camera:
        bench.camera.bare_blackbody = True
        bench.begin()
        frame = bench.taken(PERIOD * np.arange(1, 2))[0]
    level, detector = scene.radiance.level_dn(290.0), scene.detector
    spread = np.hypot(np.hypot(detector.offset_spread_dn, detector.noise_dn), detector.gain_spread * level)
    assert frame.mean() == pytest.approx(level, abs=5 * spread / np.sqrt(frame.size))
    assert frame.std() == pytest.approx(spread, rel=0.05)


def test_it_keeps_up_with_many_triggers_and_holds_their_source_back_when_it_cannot():
    """Oracle: counting: as many frames as triggers, in order, though they were told much faster than real time."""
    bench = Bench(paper_scene(64, 80))
    with bench.camera:
        bench.begin()
        triggers = PERIOD * np.arange(1, 301)
        bench.turn(310 * PERIOD, triggers=triggers)
        bench.wait_for(300)
    assert [frame.moment.trigger_cycle for frame in bench.frames] == triggers.tolist()
