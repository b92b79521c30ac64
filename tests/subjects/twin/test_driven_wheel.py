"""The wheel before a simulated device: every edge once, at the speed that is asked for, however time is cut."""

import numpy as np
import pytest

from irtiming.gateware.register_map import Channel
from irtiming.twin.driven_wheel import DrivenWheel
from irtiming.twin.scene import paper_scene

CLOCK_HZ = 48_000_000
SLOT = 160_000  # cycles at 3 turns a second
LINES = (Channel.CONTROL_SLOT, Channel.APPLICATION_SLOT)


def _wheel(**options):
    return DrivenWheel(paper_scene(16, 20), clock_frequency_hz=CLOCK_HZ, seed=4, **options)


def _turned(wheel, cuts, slot=SLOT):
    """Cycles and levels of each line over several calls, joined."""
    parts = [wheel.turn(cut, slot_period_cycles=slot) for cut in cuts]
    return {
        line: tuple(np.concatenate([getattr(part[line], name) for part in parts]) for name in ("cycle", "level"))
        for line in LINES
    }


def test_every_edge_comes_once_across_the_seams():
    """Oracle: counting: 150 turns in blocks of some 40 have 100 slots and 4 edges each, at regular places."""
    turned = _turned(_wheel(), [150 * 100 * SLOT])
    rising = turned[Channel.CONTROL_SLOT][0][turned[Channel.CONTROL_SLOT][1] == 1]
    assert abs(rising.size - 15_000) <= 1
    assert np.all(np.abs(np.diff(rising) - SLOT) < 0.03 * SLOT)
    edges, levels = turned[Channel.APPLICATION_SLOT]
    assert abs(edges.size - 600) <= 1
    assert np.all(np.abs(np.diff(edges) - 25 * SLOT) < 0.1 * SLOT)
    assert np.all(np.diff(levels) != 0)


@pytest.mark.parametrize("remembers", [False, True])
def test_it_turns_the_same_however_time_is_cut(remembers):
    """Oracle: the same wheel asked once."""
    end = 90 * 100 * SLOT
    cuts = [*np.sort(np.random.default_rng(1).integers(0, end, 300)).tolist(), end]
    once, often = _turned(_wheel(), [end]), _turned(_wheel(remembers=remembers), cuts)
    for line in LINES:
        assert np.array_equal(once[line], often[line])


def test_the_level_before_a_piece_is_the_one_that_the_piece_before_left():
    """Oracle: the changes so far, by hand."""
    wheel, level = _wheel(), dict.fromkeys(LINES, 0)
    for cut in range(0, 100 * SLOT, 7_000):
        for line, changes in wheel.turn(cut, slot_period_cycles=SLOT).items():
            assert changes.initial == level[line]
            level[line] = int(changes.level[-1]) if changes.level.size else level[line]


def test_it_stands_without_a_reference_and_before_one_that_no_wheel_follows():
    """Oracle: no changes at all; 1000 turns a second are too many."""
    turned = _turned(_wheel(), [10**8], slot=0)
    assert all(turned[line][0].size == 0 for line in LINES)
    turned = _turned(_wheel(), [10**8], slot=479)
    assert all(turned[line][0].size == 0 for line in LINES)


def test_it_takes_up_a_new_speed_where_it_is():
    """Oracle: by hand: twice the slots in the second half, and an angle without a jump."""
    wheel = _wheel(remembers=True)
    slow = _turned(wheel, [10_000 * SLOT])[Channel.CONTROL_SLOT]
    fast = _turned(wheel, [20_000 * SLOT], slot=SLOT // 2)[Channel.CONTROL_SLOT]
    assert np.median(np.diff(slow[0][slow[1] == 1])) == pytest.approx(SLOT, rel=1e-3)
    assert np.median(np.diff(fast[0][fast[1] == 1])) == pytest.approx(SLOT / 2, rel=1e-3)
    assert fast[0][0] >= 10_000 * SLOT
    motion = wheel.motion_from(10_000 * SLOT)
    assert np.all(np.diff(motion.time_s) > 0)
    assert np.abs(np.diff(motion.angle_rad)).max() < 2 * np.pi * 6 * 110e-6
    assert motion.angle_at(np.array(1e-3)) > motion.angle_at(np.array(-1e-3))
