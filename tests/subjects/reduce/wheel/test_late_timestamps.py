"""Edges that are timestamped late and a clock that is off, put into the ticks of a wheel whose angle is known at all times."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.physics import latency
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.rig import Clock, Latency, Measured
from irtiming.reduce.wheel.slots_on_track import table_of, with_common_zero, with_slots
from irtiming.reduce.wheel.wheel_angles import track

TURN = 2 * np.pi
CLOCK_HZ = 49_152_000
GATE_S, SLOT_S, TRIGGER_S = 400e-6, 150e-6, 60e-6  # large, so that the rounding to ticks does not matter
STATED = Latency(application_gate_s=Measured(GATE_S), control_gate_s=Measured(SLOT_S), trigger_s=Measured(TRIGGER_S))


def _late(wheel, recorded, *, rate_hz=3.0):
    """Recording of the wheel with late edges; triggers keep their timestamps."""
    slots = wheel.control_slot_ticks() + round(SLOT_S * CLOCK_HZ)
    edges = wheel.application_slot_ticks() + round(GATE_S * CLOCK_HZ)
    return recorded(wheel, control_slot_ticks=slots, application_slot_ticks=edges, rotation_speed_hz=rate_hz)


def _delay_s(wheel, found, ticks):
    """Delay that a camera without any seems to have: it exposes when the trigger is at its connector."""
    true = wheel.theta((ticks - wheel.start) / CLOCK_HZ + TRIGGER_S)
    beside = np.angle(np.exp(1j * (true - wheel_angle_rad(0.0, found, at_ticks=ticks))))
    return float(np.mean(beside)) / found.angular_frequency_rad_per_s


@pytest.fixture
def wheels(paper_wheel):
    """The same wheel at 3 and at 8 Hz."""
    slots = TURN * np.arange(100) / 100 + np.random.default_rng(1).normal(0, 2e-4, 100)
    return [paper_wheel(rate_hz=hz, slots=slots, theta_0=1.0, jitter_s=1e-7) for hz in (3.0, 8.0)]


@pytest.mark.parametrize("k", [0, 1])
def test_stated_latencies_are_taken_off(wheels, recorded, rig, k):
    """Oracle: theta(t) that made the ticks, 60 us after each trigger; the gates where they stand."""
    wheel = wheels[k]
    recording = _late(wheel, recorded, rate_hz=wheel.rate_hz)
    found = track(recording, replace(rig, latency=STATED))
    ticks = recording.camera_trigger_ticks
    assert _delay_s(wheel, found, ticks[ticks < recording.control_slot_ticks[-1]]) == pytest.approx(0, abs=0.1e-6)
    mean_slot = float(np.mean(wheel.slots - TURN * np.arange(100) / 100))
    assert found.gate_separation_rad == pytest.approx(wheel.gate_separation - mean_slot, abs=5e-6)
    assert track(recording, replace(rig, latency=STATED), slots="equal").ahead_rad == 0


def test_the_slots_of_another_table_keep_the_latencies(wheels, recorded, rig):
    """Oracle: the track itself; its own table put under it again changes nothing."""
    found = track(_late(wheels[0], recorded), replace(rig, latency=STATED))
    again = with_slots(found, table_of(found))
    np.testing.assert_allclose(again.edge_angle_rad, found.edge_angle_rad, atol=2e-6)
    assert again.gate_separation_rad == pytest.approx(found.gate_separation_rad, abs=2e-6)


@pytest.mark.parametrize("common", [False, True])
def test_what_is_left_of_latencies_that_nobody_stated(wheels, recorded, rig, common):
    """Oracle: delays by brute force against `latency.effects_s`, with each its own register, and with one for both speeds.

    The angle beta_1 has no part in it: s = 0.
    """
    made = [_late(wheel, recorded, rate_hz=wheel.rate_hz) for wheel in wheels]
    found = [track(one, rig) for one in made]
    if common:  # as uncertain as if their references were worse, so that they count as equal
        found = with_common_zero([replace(one, u_gate_separation_rad=1.0) for one in found])
        assert found[0].register_rad_per_s == pytest.approx(TURN * 5.5, rel=1e-3)
    for wheel, one, recording in zip(wheels, found, made, strict=True):
        omega = one.angular_frequency_rad_per_s
        told = latency.effects_s(
            angular_frequency_rad_per_s=omega, register_rad_per_s=one.register_rad_per_s or omega, gates_rad_per_s=0.0,
            per_separation=0.0,
        )  # fmt: skip
        expected = GATE_S * told["application_gate"] + SLOT_S * told["control_gate"] + TRIGGER_S * told["trigger"]
        ticks = recording.camera_trigger_ticks
        ticks = ticks[ticks < recording.control_slot_ticks[-1]]
        assert _delay_s(wheel, one, ticks) == pytest.approx(expected, abs=0.3e-6)


def test_effects_of_latencies_by_hand():
    """Oracle: the docstring; one speed, s = 1/2: half of each gate and all of the trigger path."""
    told = latency.effects_s(
        angular_frequency_rad_per_s=20.0, register_rad_per_s=20.0, gates_rad_per_s=20.0, per_separation=0.5
    )
    assert told == {"application_gate": 0.5, "control_gate": 0.5, "trigger": 1.0}


def test_a_stated_clock_makes_si_seconds(paper_wheel, recorded, rig):
    """Oracle: by hand; a clock that is 1000 ppm fast counts more ticks a second; the set delay is in its own time."""
    fast = replace(rig, clock=Clock(relative_error=Measured(1e-3)))
    wheel = paper_wheel()
    recording = recorded(wheel)
    found = track(recording, fast)
    assert found.clock_frequency_hz == pytest.approx(CLOCK_HZ * 1.001)
    assert found.angular_frequency_rad_per_s == pytest.approx(
        track(recording, rig).angular_frequency_rad_per_s * 1.001, rel=1e-9
    )
    ticks = recording.camera_trigger_ticks
    by_ticks = wheel_angle_rad(0.0, found, at_ticks=ticks + CLOCK_HZ // 10)
    np.testing.assert_allclose(wheel_angle_rad(0.0, found, at_ticks=ticks, set_s=0.1), by_ticks, atol=1e-9)
    np.testing.assert_allclose(wheel_angle_rad(0.1 / 1.001, found, at_ticks=ticks), by_ticks, atol=1e-9)
    assert track(recording, fast, slots="equal").clock_frequency_hz == CLOCK_HZ


def test_the_whole_slots_are_counted_without_latencies(paper_wheel, recorded, rig):
    """Oracle: by hand; gates 9.001 slots apart, the application gate 20 us earlier than the control gate, are 8.995 by ticks."""
    wheel = paper_wheel(gate_separation=9.001 * TURN / 100)
    slots = wheel.control_slot_ticks() + round(20e-6 * CLOCK_HZ)
    recording = recorded(wheel, control_slot_ticks=slots)
    stated = replace(rig, latency=Latency(control_gate_s=Measured(20e-6)))
    assert track(recording, stated).gate_separation_rad == pytest.approx(9.001 * TURN / 100, abs=1e-5)
    assert track(recording, rig).gate_separation_rad == pytest.approx((8.995 + 1) * TURN / 100, abs=1e-4)
