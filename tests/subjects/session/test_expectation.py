"""A series foretold."""

from dataclasses import replace

import pytest

from irtiming.errors import PlanError
from irtiming.records.series_plan import TriggerWishes
from irtiming.session.expectation import ExpectOrder, expect
from irtiming.session.plan import PlanOrder, plan

WISHES = TriggerWishes(clock_hz="49152000", wheel_hz=("4", "50"), frame_hz="30.303", samples="1000")


def test_a_series_is_foretold_as_the_proposal_of_the_same_series():
    """Oracle: the search for the shortest series, which comes to its numbers by giving out runs one by one."""
    (best,) = plan(PlanOrder(wishes=replace(WISHES, clock_hz=None), wanted=("trigger_delay=0.5us",), most=1)).found.best
    assert len(set(best.runs_of_each)) == 1
    found = expect(ExpectOrder(wishes=replace(WISHES, clock_hz="49152000", repeats=str(best.runs_of_each[0])))).proposal
    assert found.plan.schemes == best.plan.schemes
    assert found.uncertainties[0] == best.uncertainties[0]
    assert found.duration_s == best.duration_s


def test_wishes_without_a_clock_are_refused():
    """Oracle: the message."""
    with pytest.raises(PlanError, match="clock_hz must be given"):
        ExpectOrder(wishes=replace(WISHES, clock_hz=None))
