"""Clock and latencies of simulated rigs, from their timestamps alone: the twin against the two estimates."""

import math
from dataclasses import replace

import numpy as np
import pytest

from irtiming.estimate import clock, latency
from irtiming.reduce.wheel.gate_register import register
from irtiming.twin.clockwork import spin, tick_streams
from irtiming.twin.rig import draw
from irtiming.twin.scene import paper_scene, with_wheel_speed

PITCH = 2 * math.pi / 100


def _registered(scene, speed_hz, seed):
    scene = with_wheel_speed(scene, speed_hz, frame_hz=30.303, samples=1000)
    ticks = tick_streams(scene, spin(scene, seed=seed), seed=seed)
    trigger = scene.trigger
    found = register(
        f"{speed_hz:g} Hz", edge_ticks=ticks.application_slot, slot_ticks=ticks.control_slot,
        clock_frequency_hz=trigger.clock_frequency_hz, turn_ticks=trigger.turn_period_ticks, control_slots=100,
    )  # fmt: skip
    return found, ticks


def test_error_of_the_clock_and_difference_of_the_gates_cover():
    """Oracle: error and latencies that were put into 20 drawn rigs, at 3 and 9 Hz; pulls stay within 4, their rms within 1.5."""
    clocks, gates = [], []
    for seed in range(20):
        random = np.random.default_rng(seed)
        error, late_a, late_c = random.uniform(-5e-5, 5e-5), *random.uniform(1e-6, 20e-6, 2)
        scene = draw(paper_scene(16, 16), seed=seed).scene
        scene = replace(
            scene,
            trigger=replace(scene.trigger, clock_relative_error=error),
            beams=replace(scene.beams, late_application_gate_s=late_a, late_control_gate_s=late_c),
        )
        (slow, ticks), (fast, _) = (_registered(scene, speed, seed) for speed in (3.0, 9.0))
        found = latency.over_speeds([slow, fast], line="a", later_than="c", pitch_rad=PITCH).difference_s
        gates.append((found.value - (late_a - late_c)) / found.standard_uncertainty)
        seen = clock.estimate(ticks.spare, name="x", clock_frequency_hz=scene.trigger.clock_frequency_hz).relative_error
        clocks.append((seen.value - error) / seen.standard_uncertainty)
    for pulls in (clocks, gates):
        assert np.max(np.abs(pulls)) < 4
        assert math.sqrt(np.mean(np.square(pulls))) == pytest.approx(1, abs=0.5)
