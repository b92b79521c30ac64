"""What the judge of frames is told and when it decides: by hand, with a watch that writes down what it is asked."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.reduce.shutter_judge import ShutterJudge

N = 12


class _Watch:
    """Takes frames whose opening is 5 DN off for suspicious, and those beside them for near an event; looks 2 frames ahead."""

    reach = 2

    def __init__(self):
        self.asked = []

    def judge(self, levels, *, at_start, at_end):
        self.asked.append((levels.quiet_dn.tolist(), at_start, at_end))
        suspicious = np.abs(np.nan_to_num(levels.beside_dn)) > 5
        zone = suspicious.copy()
        zone[1:] |= suspicious[:-1]
        return suspicious, suspicious, zone


@pytest.fixture
def judge():
    """An opening of 2 and 3 pixels, 100 DN above 1000 + k DN; frame 5 of 12 is 10 DN off, of frame 8 no angle is known."""
    quiet = 1000.0 + np.arange(N)
    expected = np.where(np.arange(N) == 8, np.nan, 100.0)
    level = quiet + 100.0 + np.where(np.arange(N) == 5, 10.0, 0.0)
    rows = SimpleNamespace(mask_dn=np.outer(level, [2.0, 3.0]), n_mask=np.array([2, 3]))
    return ShutterJudge(
        _Watch(), expected, rows=rows, quiet=SimpleNamespace(level_dn=quiet, band_dn=np.zeros((N, 1))),
        limits=SimpleNamespace(is_dead=np.zeros(N, bool)), repeats=SimpleNamespace(is_repeated=np.zeros(N, bool)),
    )  # fmt: skip


def _added(judge, first, end):
    judge.add(SimpleNamespace(now=slice(first, end)))


def test_levels_are_those_of_the_openings_pixels_less_the_quiet_ones_and_what_the_angle_demands(judge):
    """Oracle: by hand; sums over 2 and 3 pixels of one level, and none of frames that were not added."""
    _added(judge, 2, 7)
    assert judge.levels.beside_dn[2:7] == pytest.approx([0, 0, 0, 10, 0])
    assert np.isnan(judge.levels.beside_dn[[0, 1, 7, 11]]).all()


def test_frames_are_judged_with_those_before_and_after_them_that_are_known(judge):
    """Oracle: by hand; two frames to either side, none beyond the ends or beyond what was read."""
    _added(judge, 0, N)
    judge.decide(4, 6, n_read=N)
    judge.decide(0, 3, n_read=4)
    judge.decide(9, 12, n_read=N)
    asked = judge._watch.asked
    assert asked[0] == ([1002.0, 1003.0, 1004.0, 1005.0, 1006.0, 1007.0], False, False)
    assert asked[1] == ([1000.0, 1001.0, 1002.0, 1003.0], True, False)
    assert asked[2] == ([1007.0, 1008.0, 1009.0, 1010.0, 1011.0], False, True)


def test_good_frames_are_neither_suspicious_nor_near_an_event_nor_without_an_angle(judge):
    """Oracle: by hand; frame 5 is off and 6 beside it, of 8 no angle is known. What was judged stays with the judge."""
    _added(judge, 0, N)
    good, near = judge.decide(4, 10, n_read=N)
    assert good.tolist() == [True, False, False, True, False, True]
    assert near.tolist() == [False, True, True, False, False, False]
    assert np.flatnonzero(judge.suspicious).tolist() == np.flatnonzero(judge.event).tolist() == [5]
    assert np.flatnonzero(judge.zone).tolist() == [5, 6]
    assert judge.reach == 2
