"""Schedule: repeats, delays and wheel speeds between two non-uniformity corrections."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from irtiming.errors import PlanError
from irtiming.plan.schedule import plan_duration_s, run_length_ticks, schedule
from irtiming.plan.wishes import wish_around
from irtiming.records.trigger_plan import TriggerScheme, Wishes

CLOCK_HZ = 1000
SCHEME = TriggerScheme(turn_period_ticks=1000, camera_period_ticks=300)  # a run of 3000 ticks, 3 s
SLOWER = TriggerScheme(turn_period_ticks=2000, camera_period_ticks=300)  # a run of 6000 ticks, 6 s


def _wishes(longest=None, delays=("0",), repeats=1):
    one = wish_around(Fraction(1), Fraction(0))
    return Wishes(
        clock_frequency_hz=CLOCK_HZ,
        wheel_rates_hz=(one,),
        frame_rate_hz=one,
        samples_per_turn=one,
        longest_uninterrupted_s=None if longest is None else Fraction(longest),
        trigger_delays_s=tuple(Fraction(delay) for delay in delays),
        repeats=repeats,
    )


@pytest.mark.parametrize(
    ("wishes", "expected"),
    [
        # repeats and (delay in ticks, repeats, corrected before) of each run, worked out by hand for runs of 3 s
        (_wishes(), [(0, 1, True)]),
        (_wishes(repeats=7), [(0, 7, True)]),
        (_wishes(longest=21, repeats=7), [(0, 7, True)]),
        (_wishes(longest="20.999", repeats=7), [(0, 4, True), (0, 3, True)]),
        (_wishes(longest=6, repeats=5), [(0, 2, True), (0, 2, True), (0, 1, True)]),
        (_wishes(longest=20, repeats=2, delays=("0", "0.025")), [(0, 2, True), (25, 2, False)]),
        (_wishes(longest=12, repeats=2, delays=("0", "0.025")), [(0, 2, True), (25, 2, True)]),
        (_wishes(longest="12.025", repeats=2, delays=("0", "0.025")), [(0, 2, True), (25, 2, False)]),
        (_wishes(repeats=2, delays=("0.0006",)), [(1, 2, True)]),
    ],
)
def test_runs_fit_between_corrections(wishes, expected):
    """Oracle: worked out by hand; a run lasts 3 s and its delay."""
    plan = schedule((SCHEME,), wishes)
    assert [(run.trigger_delay_ticks, run.repeats, run.is_after_correction) for run in plan] == expected


def test_wheel_speeds_follow_each_other():
    """Oracle: by hand; 3 s + 6 s fit into 9 s, 9.1 s of the next delay do not."""
    plan = schedule((SCHEME, SLOWER), _wishes(longest=9, delays=("0", "0.1")))
    assert [(run.scheme, run.trigger_delay_ticks, run.is_after_correction) for run in plan] == [
        (SCHEME, 0, True),
        (SCHEME, 100, False),
        (SLOWER, 0, True),
        (SLOWER, 100, True),
    ]
    assert plan_duration_s(plan) == Fraction("18.2")


def test_a_run_longer_than_the_time_between_corrections_is_refused():
    """Oracle: 3 s and 25 ms against 3 s."""
    with pytest.raises(PlanError, match=r"3\.025 s, but only 3 s"):
        schedule((SCHEME,), _wishes(longest=3, delays=("0", "0.025")))


@settings(deadline=None)
@given(
    repeats=st.integers(1, 60),
    longest=st.integers(7, 60),
    delays=st.lists(st.integers(0, 900), min_size=1, max_size=4),
)
def test_every_repeat_is_made_once_and_no_correction_comes_late(repeats, longest, delays):
    """Oracle: repeats add up for each wheel speed and delay; time since a correction never exceeds the limit."""
    wishes = _wishes(longest=longest, repeats=repeats, delays=[Fraction(delay, 1000) for delay in delays])
    plan = schedule((SCHEME, SLOWER), wishes)
    assert sum(run.repeats for run in plan) == 2 * len(delays) * repeats
    since = 0
    for number, run in enumerate(plan):
        length = run_length_ticks(run.scheme, repeats=run.repeats, trigger_delay_ticks=run.trigger_delay_ticks)
        assert run.is_after_correction or number > 0
        since = length if run.is_after_correction else since + length
        assert since <= longest * CLOCK_HZ
