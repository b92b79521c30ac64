"""Calibration of a wheel from the twin's timestamps, whose slots, edges and ripple are known."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.physics import slot_orders
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.wheel_track import WheelTrack
from irtiming.reduce.wheel import pooled_slots
from irtiming.reduce.wheel.wheel_angles import both_tracks, track
from irtiming.reduce.wheel.wheel_calibration import calibrate, from_recordings

TURN = 2 * np.pi
RIPPLE = 5e-4
PER_RAD_US = 1e6 / (TURN * 3)


class _Run:
    def __init__(self, run, rig=None, sha256=None):
        self.name, self.track = run.recording.name, track(run.recording, rig or run.rig)
        self.sha256 = run.recording.sha256 if sha256 is None else sha256


def _error_us(calibration, run):
    return float(np.std(calibration.slot_deviation_rad - run.slots)) * PER_RAD_US


def _from(runs):
    return from_recordings([run.recording for run in runs], runs[0].rig)


def test_two_speeds_take_the_ripple_off(spun):
    """Oracle: slots of the twin; ripple of 0.05 % and 0.03 %, 20 us at 3 Hz, a quarter of it at 6 Hz, both: 1/50."""
    runs = [spun(1, ripple=RIPPLE, turns=100), spun(2, ripple=RIPPLE, turns=100, hz=6.0)]
    slow, fast, both = _from(runs[:1]), _from(runs[1:]), _from(runs)
    assert _error_us(slow, runs[0]) == pytest.approx(19.7, rel=0.1)
    assert _error_us(fast, runs[0]) == pytest.approx(19.7 / 4, rel=0.1)
    assert _error_us(both, runs[0]) < 0.5
    assert slow.ripple is None
    u_us = slot_orders.u_slot_rad(both.order_variance_rad2, 100) * PER_RAD_US
    assert _error_us(both, runs[0]) < 2.5 * u_us
    amplitude = slot_orders.amplitude_rad(both.ripple.deviation_rad)
    assert amplitude[1] == pytest.approx(RIPPLE, rel=0.03)
    assert amplitude[2] == pytest.approx(0.6 * RIPPLE / 2, rel=0.03)
    assert [s.n_turns for s in both.speeds] == [pytest.approx(103, abs=2)] * 2
    assert [s.rotation_speed_hz for s in both.speeds] == [pytest.approx(3, rel=1e-4), pytest.approx(6, rel=1e-4)]


def test_edges_and_gates_are_free_of_the_ripple(spun):
    """Oracle: ring edges and beams of the twin, within three uncertainties; the angle at a trigger is the true one."""
    runs = [spun(k, ripple=RIPPLE, turns=60, hz=hz) for k, hz in enumerate((3.0, 3.0, 6.0, 6.0))]
    found = _from(runs)
    beside = np.array(found.application_edges_rad) - runs[0].scene.wheel.ring_edges_rad
    assert np.all(np.abs(beside[1:]) < 3.5 * np.array(found.u_application_edges_rad[1:]))
    assert found.application_edges_rad[0] == 0
    beams = runs[0].scene.beams
    slots_mean = np.mean(runs[0].scene.wheel.control_slot_errors_rad)
    separation = beams.beta_1_rad + beams.beta_2_rad
    assert abs(found.gate_separation_rad - separation) < 3 * found.u_gate_separation_rad
    assert found.gate_separation_rad == pytest.approx(separation - slots_mean, abs=2e-5)
    tracks, _ = pooled_slots.pool([_Run(run) for run in runs])
    for run, placed in zip(runs, tracks, strict=True):
        angles = wheel_angle_rad(0.0, placed, at_ticks=run.recording.control_slot_ticks)
        at_slots = np.array(angles) + separation
        slot = np.mod(run.first_slot + np.arange(angles.size), 100)
        true = TURN * slot / 100 + np.array(run.scene.wheel.control_slot_errors_rad)[slot]
        wrong = np.angle(np.exp(1j * (at_slots - true)))
        assert np.std(wrong) < 5e-6
        assert placed.application_edges_rad == pytest.approx(found.application_edges_rad, abs=3e-5)


def test_pooled_runs_of_one_speed_are_honest(spun):
    """Oracle: slots of six wheels of the twin, five runs of 30 turns each; chi-square of the table over all orders."""
    per_order = []
    for rig_seed in range(6):
        runs = [spun(10 * rig_seed + k, turns=30, relative=1e-3, rig_seed=rig_seed + 20) for k in range(5)]
        found = from_recordings([run.recording for run in runs], runs[0].rig, reference_edge="automatic")
        per_order.append(slot_orders.chi_square(found.slot_deviation_rad - runs[0].slots, found.order_variance_rad2))
        assert found.warnings == ()
        assert found.speeds[0].n_turns == sum(_from([run]).speeds[0].n_turns for run in runs)
    mean = np.mean(per_order, axis=0) / 2
    assert 0.3 < mean[1:4].mean() < 1.9
    assert 0.7 < mean[4:50].mean() < 1.4


def test_more_runs_know_the_slots_better(spun):
    """Oracle: the slots of the twin; u falls as the root of the runs and so does the error."""
    runs = [spun(k, turns=30, relative=1e-3) for k in range(9)]
    one, nine = _from(runs[:1]), _from(runs)
    u = [slot_orders.u_slot_rad(found.order_variance_rad2, 100) for found in (one, nine)]
    assert u[1] == pytest.approx(u[0] / 3, rel=0.35)
    assert _error_us(nine, runs[0]) < 0.6 * _error_us(one, runs[0])


def test_a_single_recording_keeps_its_own_table(spun):
    """Oracle: the table that the track has learned."""
    run = _Run(spun(3))
    (pooled,), found = pooled_slots.pool([run])
    np.testing.assert_allclose(pooled.slot_deviation_rad, run.track.slot_deviation_rad, atol=1e-15)
    np.testing.assert_allclose(pooled.edge_angle_rad, run.track.edge_angle_rad, atol=1e-12)
    assert pooled.u_gate_separation_rad == pytest.approx(run.track.u_gate_separation_rad)
    assert pooled.application_edges_rad == pytest.approx(run.track.application_edges_rad, abs=1e-12)
    assert found.ripple is None


def test_too_few_turns_teach_nothing_but_an_earlier_calibration_helps(spun):
    """Oracle: by hand; 6 turns keep equal slots, with a calibration they get its slots."""
    short, long = spun(4, turns=4), spun(5, turns=40)
    (alone,), nothing = pooled_slots.pool([_Run(short)])
    assert nothing is None
    assert np.all(alone.slot_deviation_rad == 0)
    with pytest.raises(ReductionError, match=r"none of 3 Hz, seed 4 holds the 9 turns that are needed"):
        calibrate([_Run(short)])
    before = _from([long])
    (helped,), found = pooled_slots.pool([_Run(short)], before=before)
    np.testing.assert_allclose(helped.slot_deviation_rad, before.slot_deviation_rad, atol=1e-15)
    assert found.names == before.names


def test_an_earlier_calibration_counts_by_its_weight_and_once(spun):
    """Oracle: the calibration of all recordings together; one that is in both counts once."""
    runs = [spun(k, turns=30, relative=1e-3) for k in range(4)]
    before = _from(runs[:3])
    _, found = pooled_slots.pool([_Run(runs[3])], before=before)
    together = _from(runs)
    u = slot_orders.u_slot_rad(together.order_variance_rad2, 100)
    assert np.std(found.slot_deviation_rad - together.slot_deviation_rad) < 0.6 * u
    assert slot_orders.u_slot_rad(found.order_variance_rad2, 100) == pytest.approx(u, rel=0.2)
    _, again = pooled_slots.pool([_Run(runs[0]), _Run(runs[2])], before=before)
    np.testing.assert_allclose(again.slot_deviation_rad, before.slot_deviation_rad, atol=1e-15)
    assert again.names == before.names


@pytest.mark.parametrize("hz", [3.0, 6.0])
def test_the_calibration_of_another_wheel_is_left_out(spun, hz):
    """Oracle: by hand; two wheels drawn apart, at the same speed or at another one."""
    before, run = _from([spun(1, rig_seed=8, hz=hz)]), _Run(spun(2, rig_seed=9))
    (placed,), found = pooled_slots.pool([run], before=before)
    assert "the wheel calibration does not fit the recordings at 3 Hz" in found.warnings[0]
    assert "another wheel?" in found.warnings[0]
    np.testing.assert_allclose(placed.slot_deviation_rad, run.track.slot_deviation_rad, atol=1e-15)


def test_a_ripple_does_not_make_it_another_wheel(spun):
    """Oracle: by hand; the same wheel, its ripple four times as large at the lower speed."""
    before = _from([spun(1, hz=6.0, ripple=RIPPLE)])
    run = spun(2, ripple=RIPPLE)
    _, found = pooled_slots.pool([_Run(run)], before=before)
    assert found.warnings == ()
    assert _error_us(found, run) < 1.0


def _paper_run(name, *, scatter_rad=0.0, separation=0.5, edges=None, u_edges=None, hz=3.0, turns=12):
    """A run by hand: 20 slots of known table, a gate separation with its own scatter, edges as given."""
    deviation = 1e-4 * np.cos(np.arange(20)) - np.mean(1e-4 * np.cos(np.arange(20)))
    variance = np.full(11, 4e-10)
    u_slot, mean = np.sqrt(4e-10 * 19 / 20), np.sqrt(np.mean(deviation**2) / 20)
    number = np.arange(20 * turns)
    alpha = TURN * number / 20 + deviation[number % 20]
    placed = WheelTrack(
        edge_ticks=np.rint(1e7 * alpha).astype(np.int64),
        edge_angle_rad=alpha - separation,
        clock_frequency_hz=1e7 * TURN * hz,
        angular_frequency_rad_per_s=TURN * hz,
        gate_separation_rad=separation,
        u_gate_separation_rad=float(np.sqrt(scatter_rad**2 + u_slot**2 + mean**2)),
        slot_deviation_rad=deviation,
        u_slot_deviation_rad=np.full(20, u_slot),
        order_variance_rad2=variance,
        application_edges_rad=edges,
        u_application_edges_rad=u_edges,
    )
    return SimpleNamespace(name=name, sha256=name, track=placed)


def test_uncertainties_of_gates_and_edges_by_hand():
    """Oracle: by hand; of four alike recordings their own scatter halves, register and slots beside two edges are common."""
    edges, u_edges = (0.0, 1.6, 3.2, 4.7), (1e-5, 2e-5, 3e-5, 4e-5)
    scatters = (5e-5, 5e-5, 5e-5, 11e-5)
    runs = [_paper_run(str(k), scatter_rad=s, edges=edges, u_edges=u_edges) for k, s in enumerate(scatters)]
    found = calibrate(runs)
    u_slot = np.sqrt(4e-10 * 19 / 20 / 4)  # the table of four is twice as good
    mean = np.sqrt(np.mean(runs[0].track.slot_deviation_rad ** 2) / 20)
    own = np.sqrt(3 * 5e-5**2 + 11e-5**2) / 4
    assert found.u_gate_separation_rad == pytest.approx(np.sqrt(own**2 + u_slot**2 + mean**2), rel=1e-3)
    expected = np.hypot(np.array(u_edges) / 2, np.sqrt(2) * u_slot * np.array([0, 1, 1, 1]))
    np.testing.assert_allclose(found.u_application_edges_rad, expected, rtol=1e-3)
    assert found.application_edges_rad == pytest.approx(edges, abs=1e-9)


def test_recordings_that_scatter_more_than_each_says_widen_the_mean():
    """Oracle: by hand; separations and edges at -1, 0 and +1 times 3e-4: standard deviation of the mean 3e-4 / sqrt(3)."""
    steps = 3e-4 * np.array([-1.0, 0.0, 1.0])
    runs = [
        _paper_run(str(k), scatter_rad=1e-6, separation=0.5 + s, edges=(0.0, 1.6 + s, 3.2, 4.7), u_edges=(1e-7,) * 4)
        for k, s in enumerate(steps)
    ]
    found = calibrate(runs)
    register = np.sqrt(4e-10 * 19 / 20 / 3 + np.mean(runs[0].track.slot_deviation_rad ** 2) / 20)
    assert found.gate_separation_rad == pytest.approx(0.5, abs=1e-9)
    assert found.u_gate_separation_rad == pytest.approx(np.hypot(3e-4 / np.sqrt(3), register), rel=1e-3)
    assert found.u_application_edges_rad[1] == pytest.approx(
        np.hypot(3e-4 / np.sqrt(3), np.sqrt(2 * 4e-10 * 19 / 20 / 3)), rel=1e-3
    )


def _turned(run):
    """The same recording with the other application edge as reference."""
    chosen = track(run.recording, run.rig).edge_angle_rad
    return next(
        other
        for other in (track(run.recording, run.rig, reference_edge=edge) for edge in ("first", "second"))
        if np.abs(np.angle(np.exp(1j * (other.edge_angle_rad[0] - chosen[0])))) > 1
    )


@pytest.mark.parametrize("hz", [3.0, 6.0])
def test_a_reference_edge_told_differently_is_seen_in_the_slots(spun, hz):
    """Oracle: by hand; the slots of one recording are turned by 50 of 100, at the same speed or at another one."""
    runs = [_Run(spun(1, turns=60)), _Run(spun(2, turns=30, hz=hz))]
    runs[1].track = _turned(spun(2, turns=30, hz=hz))
    before = calibrate(runs[:1])
    (placed,), found = pooled_slots.pool(runs[1:], before=before)
    assert "they fit after half a turn: the reference edge was chosen differently" in found.warnings[0]
    np.testing.assert_allclose(placed.slot_deviation_rad, runs[1].track.slot_deviation_rad, atol=1e-15)
    tracks, together = pooled_slots.pool(runs)
    if hz == 3.0:
        assert "the recordings at 3 Hz show different slots" in together.warnings[0]
    else:
        assert "at 6 Hz show other slots than those at 3 Hz, in orders that no ripple reaches" in together.warnings[0]
        assert "they fit after half a turn" in together.warnings[0]
        for run, placed in zip(runs, tracks, strict=True):
            np.testing.assert_allclose(placed.slot_deviation_rad, run.track.slot_deviation_rad, atol=1e-15)


def test_recordings_of_two_wheels_are_told(spun):
    """Oracle: by hand."""
    found = _from([spun(1, rig_seed=8), spun(2, rig_seed=8), spun(3, rig_seed=9)])
    assert len(found.warnings) == 1
    assert "the recordings at 3 Hz show different slots" in found.warnings[0]


def test_another_number_of_slots_is_refused(spun, paper_wheel, recorded, rig):
    """Oracle: by hand; a ring of 98 slots, a calibration of 100."""
    before = _from([spun(1)])
    recording = recorded(paper_wheel(slots=TURN * np.arange(98) / 98 + np.random.default_rng(1).normal(0, 1e-4, 98)))
    other = replace(rig, wheel=replace(rig.wheel, control_slots=98))
    run = _Run(spun(2))
    run.name, run.track = "ring of 98", track(recording, other)
    with pytest.raises(ReductionError, match=r"the wheel calibration: 100, ring of 98: 98.*serves one wheel only"):
        pooled_slots.pool([run], before=before)


def test_a_recording_given_twice_is_refused(spun):
    """Oracle: by hand; counted twice it would make the uncertainty too small."""
    run = spun(1)
    with pytest.raises(ReductionError, match=r"is given twice \(sha256 1-3\.0"):
        _from([run, run])
    with pytest.raises(ReductionError, match=r"no recording given"):
        from_recordings([], run.rig)
    with pytest.raises(ReductionError, match=r"name it for one recording at a time"):
        from_recordings([run.recording, spun(2).recording], run.rig, reference_edge="first")


def test_both_tracks_are_those_of_each(spun):
    """Oracle: `track`, asked twice."""
    run = spun(1)
    learned, equal = both_tracks(run.recording, run.rig)
    np.testing.assert_array_equal(learned.edge_angle_rad, track(run.recording, run.rig).edge_angle_rad)
    np.testing.assert_array_equal(equal.edge_angle_rad, track(run.recording, run.rig, slots="equal").edge_angle_rad)
