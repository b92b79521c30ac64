"""Strobe of a simulated camera that runs free, as the trigger generator's camera input sees it."""

import time
from dataclasses import replace

import numpy as np

from irtiming.gateware.register_map import Channel
from irtiming.twin.devices.free_strobe import FreeStrobe
from irtiming.twin.driven_wheel import DrivenWheel
from irtiming.twin.free_running import FreeRunning
from irtiming.twin.live_camera import LiveCamera
from irtiming.twin.scene import paper_scene

CLOCK_HZ, SLOT, STEP = 48_000_000, 160_000, 240_000


def test_each_frame_has_its_strobe_and_none_is_left_out():
    """Oracle: when each delivered frame began, plus 600 us; a period of 48 MHz over 50 Hz; pulses of 1 ms; silence before."""
    scene, free = paper_scene(32, 40), FreeRunning(strobe_jitter_s=0.0)
    scene = replace(scene, free=free)
    wheel = DrivenWheel(scene, clock_frequency_hz=CLOCK_HZ, seed=3)
    camera = LiveCamera(scene, wheel, clock_frequency_hz=CLOCK_HZ, seed=11)
    bench = FreeStrobe(wheel, camera, free=free, clock_frequency_hz=CLOCK_HZ, seed=1)
    frames, cycles, levels = [], [], []

    def turn(n_steps):
        for _ in range(n_steps):
            now.append(now[-1] + STEP)
            pin = bench.turn(now[-1], slot_period_cycles=SLOT)[Channel.CAMERA_INPUT]
            cycles.extend(pin.cycle.tolist())
            levels.extend(pin.level.tolist())

    now = [0]
    with camera:
        turn(20)
        assert cycles == []
        camera.begin(frames.append, trigger="none", frame_rate_hz=50.0)
        turn(200)
        until = time.monotonic() + 20
        while len(frames) < 48 and time.monotonic() < until:
            time.sleep(0.005)
        assert camera.cycle_now(speed=1.0) >= now[-1]
    begun = np.array([frame.moment.trigger_cycle for frame in frames])
    rises, falls = np.array(cycles)[0::2], np.array(cycles)[1::2]
    assert set(levels[0::2]) == {1}
    assert set(np.diff(begun)) == {960_000}
    assert np.array_equal(rises[: begun.size], begun + 28_800)
    assert set(falls - rises[: falls.size]) == {48_000}
    assert begun.size >= 48
