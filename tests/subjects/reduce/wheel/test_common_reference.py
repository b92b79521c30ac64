"""The reference edge of a wheel whose half turns one recording cannot tell apart, from the slots of another."""

import numpy as np
import pytest

from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.choices import Choices
from irtiming.reduce.wheel import common_reference
from irtiming.reduce.wheel.wheel_angles import tells_reference, track

TURN = 2 * np.pi
CLOCK_HZ = 49_152_000
CLEAR, ALIKE = (0.0, 1.57, np.pi + 1.5e-4, 4.71), (0.0, 1.57, np.pi, 4.71)


def _slots(size_rad, *, seed=3):
    return TURN * np.arange(100) / 100 + np.random.default_rng(seed).normal(0, size_rad, 100)


@pytest.mark.parametrize("theta_0", [1.0, 2.5, 4.0, 5.5])
def test_the_slots_tell_which_edge_it_is(paper_wheel, recorded, rig, theta_0):
    """Oracle: theta(t) that made the ticks; the other edge is half a turn off. Both recordings begin anywhere in a turn."""
    slots = _slots(2e-4)
    known = track(recorded(paper_wheel(edges=CLEAR, slots=slots, theta_0=0.3)), rig)
    wheel = paper_wheel(edges=ALIKE, slots=slots, theta_0=theta_0, jitter_s=2e-6)
    recording = recorded(wheel)
    assert not tells_reference(recording)
    found = common_reference.named(recording, [known], rig=rig, choices=Choices())
    assert found.reference_edge in ("first", "second")
    ticks = recording.control_slot_ticks[100:-100]
    true = wheel.theta((ticks - wheel.start) / CLOCK_HZ)
    off = wheel_angle_rad(0.0, track(recording, rig, reference_edge=found.reference_edge), at_ticks=ticks) - true
    assert np.abs(np.angle(np.exp(1j * off))).max() < 1e-3


def test_slots_without_a_pattern_or_of_another_wheel_leave_it_open(paper_wheel, recorded, rig):
    """Oracle: a law; slots that are regular look alike from both edges, and those of another wheel like neither."""
    recording = recorded(paper_wheel(edges=ALIKE, slots=_slots(2e-4), jitter_s=2e-6))
    regular = recorded(paper_wheel(edges=ALIKE, slots=_slots(0.0), jitter_s=2e-6))
    for one, slots in ((recording, _slots(2e-4, seed=4)), (regular, _slots(0.0)), (recording, _slots(0.0))):
        known = track(recorded(paper_wheel(edges=CLEAR, slots=slots)), rig)
        assert common_reference.named(one, [known], rig=rig, choices=Choices()) == Choices()
    assert common_reference.named(recording, [], rig=rig, choices=Choices()) == Choices()


def test_an_edge_that_was_named_or_is_told_stays(paper_wheel, recorded, rig):
    """Oracle: what the owner says, and what the recording itself says."""
    slots = _slots(2e-4)
    clear, alike = (recorded(paper_wheel(edges=edges, slots=slots, jitter_s=2e-6)) for edges in (CLEAR, ALIKE))
    known = track(clear, rig)
    for edge in ("first", "second"):
        chosen = Choices(reference_edge=edge)
        assert common_reference.named(alike, [known], rig=rig, choices=chosen) is chosen
    assert common_reference.named(clear, [known], rig=rig, choices=Choices()).reference_edge == "automatic"


def test_recordings_that_tell_it_come_first(paper_wheel, recorded):
    """Oracle: the rule; the others follow in their order."""
    clear, alike = (recorded(paper_wheel(edges=edges, jitter_s=2e-6)) for edges in (CLEAR, ALIKE))
    assert common_reference.clear_first([alike, clear, alike]) == [clear, alike, alike]
