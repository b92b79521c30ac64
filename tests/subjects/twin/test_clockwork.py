"""Edges and ticks of the twin's wheel."""

import math
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from irtiming.twin.beams import Beams
from irtiming.twin.clockwork import first_tick_after, first_trigger_ticks, spin, tick_streams
from irtiming.twin.rig import draw
from irtiming.twin.scene import ChopperWheel, EdgeFaults, Faults, Ripple, Scene, SpeedWander

_STEADY = SpeedWander(relative=0.0, ripples=())
_TURN = 16_384_000


@pytest.fixture
def steady() -> Scene:
    return Scene(wander=_STEADY, beams=replace(Beams(), jitter_s=0.0))


def test_steady_wheel_turns_at_the_reference_rate(steady: Scene) -> None:
    """Oracle: theta = start + 2 pi 3 Hz t."""
    motion = spin(steady, seed=1)
    assert motion.angle_at(np.array([0.0, 10.0])) == pytest.approx([1.0, 1.0 + 60 * math.pi], abs=1e-9)


def test_ticks_are_the_first_clock_cycle_after_the_moment() -> None:
    """Oracle: by hand, a clock of 49.152 MHz whose count at time zero is known."""
    trigger = Scene().trigger
    zero = first_trigger_ticks(trigger)
    cycle = 1 / trigger.clock_frequency_hz
    ticks = first_tick_after(np.array([0.2, 1.5, -0.5, -1.2]) * cycle, trigger) - zero
    assert ticks.tolist() == [1, 2, 0, -1]


def test_edges_pass_the_application_gate_at_their_angles(steady: Scene) -> None:
    """Oracle: at constant speed the intervals are alpha_1, alpha_2 - alpha_1 ... times T / 2 pi, within a tick."""
    alpha = (0.0, 1.5712, 3.1420, 4.7120)
    scene = replace(steady, wheel=ChopperWheel(ring_edges_rad=alpha))
    ticks = tick_streams(scene, spin(scene, seed=1), seed=1)
    angle = np.mod(1.0 + (ticks.application_edges - ticks.camera_trigger[0]) * 2 * math.pi / _TURN, 2 * math.pi)
    away = np.abs(np.exp(1j * angle[:, None]) - np.exp(1j * np.array(alpha)))
    assert away.min(axis=1).max() < 2 * 2 * math.pi / _TURN
    assert np.isin(ticks.application_slot, ticks.application_edges).all()
    edge = away[np.isin(ticks.application_edges, ticks.application_slot)].argmin(axis=1)
    assert set(edge) == {0, 2}


def test_slots_pass_the_control_gate_before_the_application_gate(steady: Scene) -> None:
    """Oracle: from the reference edge to the next slot takes (ceil - dbeta 50 / pi) slot pitches, by hand."""
    ticks = tick_streams(steady, spin(steady, seed=1), seed=1)
    reference = ticks.application_slot[2]  # an ideal wheel: either edge will do
    following = ticks.control_slot[ticks.control_slot > reference][0] - reference
    between = math.atan(13 / 47.3) + math.atan(13 / (47.3 - 5.5))
    slots = between * 50 / math.pi
    assert math.floor(slots) == 9
    assert following == pytest.approx((math.ceil(slots) - slots) * _TURN / 100, abs=1.5)


def test_ripple_and_wander_stay_within_their_size() -> None:
    """Oracle: a ripple r cos(n theta) moves the angle by r / n; a phase-locked walk stays near rate * s * lock."""
    ripple = replace(_STEADY, ripples=(Ripple(order=2, relative=2e-5),))
    motion = spin(Scene(wander=ripple), seed=1)
    lag = motion.angle_rad - 1.0 - 6 * math.pi * motion.time_s
    assert np.ptp(lag) == pytest.approx(2 * 2e-5 / 2, rel=0.02)
    motion = spin(Scene(wander=SpeedWander(relative=1e-4, lock_time_s=0.5, ripples=())), seed=2)
    lag = motion.angle_rad - 1.0 - 6 * math.pi * motion.time_s
    assert 0.5 < lag.std() / (6 * math.pi * 1e-4 * 0.5) < 2
    speed = np.diff(motion.angle_rad) / np.diff(motion.time_s) / (6 * math.pi) - 1
    assert 0.5 < speed.std() / 1e-4 < 2


def test_jitter_has_the_stated_spread(steady: Scene) -> None:
    """Oracle: second differences of evenly spaced times with jitter s have the standard deviation s sqrt 6."""
    scene = replace(steady, beams=replace(steady.beams, jitter_s=0.4e-6))
    ticks = tick_streams(scene, spin(scene, seed=1), seed=3)
    spread_s = np.diff(ticks.control_slot, 2).std() / 49.152e6
    assert spread_s == pytest.approx(0.4e-6 * math.sqrt(6), rel=0.05)


def test_faults_change_the_number_of_edges(steady: Scene) -> None:
    """Oracle: counting; a doubled edge comes within 12 microseconds of its first."""
    whole = tick_streams(steady, spin(steady, seed=1), seed=1).control_slot
    faults = Faults(control_slot=EdgeFaults(missing=5, doubled=3, spurious=2))
    hurt = tick_streams(replace(steady, faults=faults), spin(steady, seed=1), seed=1).control_slot
    assert len(hurt) == len(whole) - 5 + 3 + 2
    assert len(np.setdiff1d(whole, hurt)) == 5
    assert (np.diff(hurt) < 12e-6 * 49.152e6).sum() >= 3
    assert (np.diff(hurt) >= 0).all()


def test_same_seed_same_ticks_and_runs_differ(steady: Scene) -> None:
    """Oracle: equality of arrays."""
    scene = replace(steady, wander=SpeedWander(), beams=Beams())
    first, again, other = (tick_streams(scene, spin(scene, seed=s), seed=s) for s in (1, 1, 2))
    assert np.array_equal(first.control_slot, again.control_slot)
    assert not np.array_equal(first.control_slot[:100], other.control_slot[:100])


def test_streams_resemble_the_recorded_ones(shared_recordings: Path) -> None:
    """Oracle: another simulator's recording: the same channels, counts and sizes of irregularity."""
    scene = draw(Scene(), seed=4).scene
    ours = tick_streams(scene, spin(scene, seed=1), seed=1)
    with h5py.File(shared_recordings / "cooled" / "cooled-3Hz-0ms.nxs") as file:
        theirs = {name: ticks[:] for name, ticks in file["entry/instrument/trigger_generator"].items() if ticks.shape}
    assert np.array_equal(np.diff(ours.camera_trigger), np.diff(theirs["camera_trigger"]))
    for name in ("control_slot", "application_slot", "application_edges"):
        a, b = getattr(ours, name), theirs[name]
        assert len(a) == pytest.approx(len(b), rel=0.02)
        assert np.diff(a).mean() == pytest.approx(np.diff(b).mean(), rel=1e-3)
        assert 0.1 < np.diff(a).std() / np.diff(b).std() < 10
