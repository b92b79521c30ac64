"""Laws of equivalent-time sampling that hold for every scheme."""

from dataclasses import replace
from fractions import Fraction
from math import gcd, lcm

from hypothesis import given, settings
from hypothesis import strategies as st

from irtiming.errors import PlanError
from irtiming.plan import sampling
from irtiming.plan.candidates import limits_in_ticks
from irtiming.plan.search import search
from irtiming.plan.wishes import as_text, exact_number, wish_around
from irtiming.records.trigger_plan import TriggerScheme, Wishes


@st.composite
def _schemes(draw):
    slots = draw(st.integers(1, 12))
    turn = slots * draw(st.integers(1, 400))
    return TriggerScheme(turn_period_ticks=turn, camera_period_ticks=draw(st.integers(1, 5000)), control_slots=slots)


@st.composite
def _wishes(draw):
    tolerance = draw(st.sampled_from([Fraction(1, 50), Fraction(1, 10)]))
    return Wishes(
        clock_frequency_hz=draw(st.integers(1000, 20_000)),
        wheel_rates_hz=(wish_around(Fraction(draw(st.integers(1, 40))), tolerance),),
        frame_rate_hz=wish_around(Fraction(draw(st.integers(1, 200))), tolerance),
        samples_per_turn=wish_around(Fraction(draw(st.integers(2, 60))), tolerance),
        control_slots=draw(st.integers(1, 12)),
    )


@settings(deadline=None)
@given(_schemes())
def test_every_sample_of_the_turn_is_visited_exactly_once(scheme):
    """Oracle: n -> n K mod N is a permutation when K and N are coprime."""
    assert sorted(trigger.sample for trigger in scheme) == list(range(scheme.samples_per_turn))
    assert gcd(scheme.samples_per_turn, scheme.samples_per_frame) == 1


@settings(deadline=None)
@given(_schemes())
def test_triggers_are_equidistant_and_fold_onto_multiples_of_delta(scheme):
    """Oracle: n C modulo T is sample times delta, by the definition of the sampling order."""
    triggers = list(scheme)
    assert [trigger.ticks for trigger in triggers] == [n * scheme.camera_period_ticks for n in range(len(triggers))]
    for trigger in triggers:
        assert trigger.ticks % scheme.turn_period_ticks == trigger.sample * scheme.sampling_interval_ticks
    assert [trigger.sample for trigger in triggers] == sampling.sampling_order(scheme).tolist()


@settings(deadline=None)
@given(_schemes())
def test_a_run_ends_when_wheel_and_camera_meet_again(scheme):
    """Oracle: lcm(T, C) = N C = K T."""
    length = lcm(scheme.turn_period_ticks, scheme.camera_period_ticks)
    assert sampling.run_period_ticks(scheme) == length
    assert length == scheme.samples_per_turn * scheme.camera_period_ticks
    assert length == scheme.samples_per_frame * scheme.turn_period_ticks


@settings(deadline=None)
@given(_schemes())
def test_the_neighbour_of_a_sample_comes_after_the_inverse_of_k(scheme):
    """Oracle: m C = delta modulo T, and no smaller positive m does it."""
    later = sampling.triggers_to_neighbour(scheme)
    turn, camera = scheme.turn_period_ticks, scheme.camera_period_ticks
    assert (later * camera - scheme.sampling_interval_ticks) % turn == 0
    assert 0 <= later < scheme.samples_per_turn


@settings(deadline=None, max_examples=60)
@given(_wishes(), st.integers(2, 5))
def test_a_faster_clock_keeps_every_scheme(wishes, factor):
    """Oracle: multiplying f, T and C by one factor changes no rate, no N and no K, so no used tolerance."""
    try:
        slow = search(wishes, most=10**6)
    except PlanError:
        return
    fast = search(replace(wishes, clock_frequency_hz=wishes.clock_frequency_hz * factor), most=10**6)
    ranked = {
        (s.turn_period_ticks, s.camera_period_ticks): option.used_tolerance
        for option in fast.best
        for s in option.schemes
    }
    for option in slow.best:
        (scheme,) = option.schemes
        times = (scheme.turn_period_ticks * factor, scheme.camera_period_ticks * factor)
        assert ranked[times] == option.used_tolerance


@settings(deadline=None, max_examples=60)
@given(_wishes())
def test_ranking_never_improves_and_stays_within_the_tolerances(wishes):
    """Oracle: the used tolerance is a sum of three shares, and the list is sorted by it."""
    try:
        found = search(wishes, most=10**6)
    except PlanError:
        return
    used = [option.used_tolerance for option in found.best]
    assert used == sorted(used)
    assert 0 <= used[0] <= used[-1] <= 3
    assert len(used) == found.n_options
    limits = limits_in_ticks(wishes, wishes.wheel_rates_hz[0])
    for option in found.best:
        (scheme,) = option.schemes
        assert limits.turn.lowest <= scheme.turn_period_ticks <= limits.turn.highest


@settings(deadline=None)
@given(st.fractions(min_value=Fraction(1, 10**6), max_value=10**9, max_denominator=10**12))
def test_text_of_a_fraction_reads_back_exactly(number):
    """Oracle: round trip."""
    assert exact_number(as_text(number), "a number") == number
