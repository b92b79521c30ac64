"""Latencies from made-up stamps of a wheel at several speeds: by hand, and in draws with known jitter."""

import numpy as np
import pytest

from irtiming.errors import EstimationError
from irtiming.estimate import latency
from irtiming.records.rig import Measured
from irtiming.reduce.wheel import gate_register
from irtiming.reduce.wheel.gate_register import register

CLOCK_HZ = 49_152_000
SLOTS = 100
PITCH = 2 * np.pi / SLOTS


def _stamps(rng, speed_hz, angles, late_s, *, jitter_s=60e-9, turns=100):
    """Ticks at which a wheel of constant speed passes angles, shape (n,), stamped late and with jitter."""
    passes = (np.arange(turns)[:, None] + np.sort(np.mod(angles, 2 * np.pi)) / (2 * np.pi)).ravel() / speed_hz
    times = passes + late_s + rng.normal(0, jitter_s, passes.size)
    return np.sort(np.floor(times * CLOCK_HZ).astype(np.int64)) + 10**10


def _wheel(rng):
    """Angles of slots and edges with errors of a real wheel, as they pass their gates."""
    slots = PITCH * np.arange(SLOTS) + rng.normal(0, 0.4e-3, SLOTS) - 0.57
    edges = np.array([0.0, np.pi + 0.3e-3])
    return slots, edges


def _registers(rng, speeds_hz, wheel, *, late_s, slot_late_s, **options):
    slots, edges = wheel
    return [
        register(
            f"{speed:g} Hz",
            edge_ticks=_stamps(rng, speed, edges, late_s, **options),
            slot_ticks=_stamps(rng, speed, slots, slot_late_s, **options),
            clock_frequency_hz=CLOCK_HZ,
            turn_ticks=CLOCK_HZ / speed,
            control_slots=SLOTS,
        )
        for speed in speeds_hz
    ]


def test_phase_of_a_regular_wheel():
    """Oracle: by hand; edges pass 0.3 slots after a slot, and are stamped 5 us later, slots 2 us: 3 us more at 4 Hz."""
    rng = np.random.default_rng(1)
    wheel = PITCH * (np.arange(SLOTS) - 0.3), np.array([0.0, np.pi])
    (found,) = _registers(rng, [4.0], wheel, late_s=5e-6, slot_late_s=2e-6, jitter_s=0.0)
    assert found.wheel_rad_per_s == pytest.approx(8 * np.pi, rel=1e-5)
    assert found.phase_rad.value == pytest.approx(0.3 * PITCH + 8 * np.pi * 3e-6, abs=8 * np.pi * 20e-9)
    assert found.n_edges == pytest.approx(200, abs=2)


def _difference(registers, line="application gate"):
    return latency.over_speeds(registers, line=line, later_than="control gate", pitch_rad=PITCH)


def test_difference_of_the_gates_covers():
    """Oracle: 200 draws of wheel, latencies and jitter at three speeds; pulls of L_a - L_c have rms 1 +- 0.15."""
    rng = np.random.default_rng(2)
    pulls = []
    for _ in range(200):
        one, other = rng.uniform(1e-6, 20e-6, 2)
        found = _difference(
            _registers(rng, [3, 5, 9], _wheel(rng), late_s=one, slot_late_s=other, turns=30)
        ).difference_s
        pulls.append((found.value - (one - other)) / found.standard_uncertainty)
    assert np.sqrt(np.mean(np.square(pulls))) == pytest.approx(1, abs=0.15)


def test_a_photodiode_tells_both_latencies_and_they_cover():
    """Oracle: 200 draws; a diode 0.1 rad beside the gate, 50 ns late, gives L_a and L_c with pulls of rms 1 +- 0.15."""
    rng = np.random.default_rng(3)
    pulls = []
    for _ in range(200):
        wheel, (one, other) = _wheel(rng), rng.uniform(1e-6, 20e-6, 2)
        options = {"slot_late_s": other, "turns": 30}
        application = _difference(_registers(rng, [3, 9], wheel, late_s=one, **options))
        beside = wheel[0], wheel[1] + 0.1
        diode = _difference(_registers(rng, [3, 9], beside, late_s=50e-9, **options), line="photodiode")
        found = latency.of_gates(application, photodiode=diode, known=Measured(50e-9, 10e-9))
        u = found.application_gate_s.standard_uncertainty, found.control_gate_s.standard_uncertainty
        assert found.gates_common_u_s == u[1] < u[0]  # the application gate follows from the control gate
        for number, truth in ((found.application_gate_s, one), (found.control_gate_s, other)):
            pulls.append((number.value - truth) / number.standard_uncertainty)
    assert np.sqrt(np.mean(np.square(pulls))) == pytest.approx(1, abs=0.15)


def test_exchanged_gates_at_one_speed():
    """Oracle: by hand; 7 us and 3 us, and after the exchange 3 us and 7 us: the difference is 4 us, u is that of the place."""
    rng, wheel = np.random.default_rng(4), _wheel(np.random.default_rng(4))
    (before,) = _registers(rng, [3.0], wheel, late_s=7e-6, slot_late_s=3e-6)
    (after,) = _registers(rng, [3.0], wheel, late_s=3e-6, slot_late_s=7e-6)
    found = latency.exchanged(before, after, pitch_rad=PITCH, place_u_rad=20e-6).difference_s
    assert found.value == pytest.approx(4e-6, abs=0.1e-6)
    assert found.standard_uncertainty == pytest.approx(20e-6 / (12 * np.pi), rel=0.1)


def test_a_latency_that_both_gates_have_is_not_seen():
    """Oracle: shift of all stamps by 10 us; speeds alone tell differences only."""
    wheel = _wheel(np.random.default_rng(5))
    found = [
        _difference(
            _registers(np.random.default_rng(6), [3, 9], wheel, late_s=3e-6 + both, slot_late_s=both)
        ).difference_s.value
        for both in (0.0, 10e-6)
    ]
    assert found[0] == pytest.approx(found[1], abs=2e-9)


def test_gates_that_move_between_the_speeds_are_noticed():
    """Oracle: an edge that stands 0.1 mrad elsewhere at one of three speeds is no latency."""
    rng = np.random.default_rng(7)
    wheel = _wheel(rng)
    moved = wheel[0], wheel[1] + 1e-4
    registers = [
        *_registers(rng, [3, 9], wheel, late_s=3e-6, slot_late_s=0.0),
        *_registers(rng, [6], moved, late_s=3e-6, slot_late_s=0.0),
    ]
    assert [one.code for one in _difference(registers).findings] == ["latency-not-proportional"]


def test_one_speed_alone_is_refused():
    """Oracle: a line wants two points."""
    rng = np.random.default_rng(8)
    with pytest.raises(EstimationError, match="two wheel speeds"):
        _difference(_registers(rng, [3.0, 3.1], _wheel(rng), late_s=1e-6, slot_late_s=0.0))


def test_a_trigger_that_is_led_back():
    """Oracle: by hand; 3, 3, 4 and 6 ticks of 1 MHz later, one never came back, one stamp is a stray; few are another signal."""
    trigger = np.array([1000, 2000, 3000, 4000, 5000])
    stamps = np.array([1003, 2003, 2500, 3004, 4006])
    found = latency.of_loop(trigger, stamps, name="x", line="spare", clock_frequency_hz=1e6)
    assert found.counts == ((3, 2), (4, 1), (6, 1))
    assert (found.n_triggers, found.n_missing) == (4, 1)
    assert found.mean_s == pytest.approx(4e-6)
    assert found.spread_s == pytest.approx(1.5**0.5 * 1e-6)
    assert (found.lowest_s, found.highest_s) == pytest.approx((3e-6, 6e-6))
    assert found.latency.trigger_s.value == pytest.approx(2e-6)
    with pytest.raises(
        EstimationError, match="2 of 5 triggers came back at spare, most must: another signal is at that input"
    ):
        latency.of_loop(trigger, stamps[:2], name="x", line="spare", clock_frequency_hz=1e6)
    with pytest.raises(EstimationError, match="no trigger came back"):
        latency.of_loop(trigger, stamps[:0], name="x", line="spare", clock_frequency_hz=1e6)


def test_no_phase_is_known_better_than_the_clock_s_ticks():
    """Oracle: by hand; two edges a turn at 0.2 and 0.4 slots, four times and nine, all alike: ticks of 0.01 slots over root n."""
    of_class = np.repeat([0, 1], [4, 9])
    value, u = gate_register._mean_over_classes(np.where(of_class == 0, 0.2, 0.4), of_class, 0.01)
    assert value == pytest.approx(0.3)
    assert u == pytest.approx(0.01 * np.sqrt(1 / 4 + 1 / 9) / 2)


@pytest.mark.parametrize("slots", [0.42, -0.42])
def test_a_phase_may_have_moved_by_nearly_half_a_slot_between_two_speeds(slots):
    """Oracle: by hand: 0.42 of a slot's pitch on or back at 9 Hz from 3 Hz; more than half would be less the other way."""
    late_s, rng = slots * PITCH / (2 * np.pi * (9 - 3)), np.random.default_rng(7)
    late = {"late_s": max(late_s, 0.0), "slot_late_s": max(-late_s, 0.0)}
    found = _difference(_registers(rng, [3, 9], _wheel(rng), **late)).difference_s
    assert found.value == pytest.approx(late_s, abs=0.1e-6)
