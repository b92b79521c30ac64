"""Schatz 2023, section 2.3: the trigger scheme and its numbers."""

from fractions import Fraction
from math import gcd

import pytest

from irtiming.plan import sampling
from irtiming.plan.schedule import plan_duration_s, schedule
from irtiming.plan.search import search
from irtiming.plan.wishes import is_prime, wish_around
from irtiming.records.trigger_plan import TriggerScheme, Wish, Wishes

CLOCK_HZ = 49_152_000
ONE_PERCENT = Fraction(1, 100)


@pytest.fixture(scope="module")
def wishes():
    """Return the approximate requirements of the paper: 3 Hz, 30.303 Hz, 1000 samples."""
    return Wishes(
        clock_frequency_hz=CLOCK_HZ,
        wheel_rates_hz=(wish_around(Fraction(3), ONE_PERCENT),),
        frame_rate_hz=wish_around(Fraction("30.303"), ONE_PERCENT),
        samples_per_turn=wish_around(Fraction(1000), ONE_PERCENT),
        longest_uninterrupted_s=Fraction(20 * 60),
        repeats=21,
    )


@pytest.fixture(scope="module")
def scheme(wishes):
    """Return the best scheme for the paper's wishes."""
    return search(wishes).best[0].schemes[0]


def test_the_papers_scheme_comes_first(scheme):
    """Oracle: section 2.3, T/delta = 1000, C/delta = 99, delta = f / 3000 Hz = 16384, T a multiple of 100."""
    assert (scheme.turn_period_ticks, scheme.camera_period_ticks) == (16_384_000, 1_622_016)
    assert scheme.sampling_interval_ticks == 16_384 == CLOCK_HZ // 3000
    assert (scheme.samples_per_turn, scheme.samples_per_frame) == (1000, 99)
    assert scheme.control_slot_period_ticks == 163_840


def test_rates_and_duration_are_those_printed(scheme):
    """Oracle: section 2.3, f/T = 3 Hz, f/C = 30.303 Hz, lcm(T, C)/f = 33 s."""
    assert sampling.wheel_rate_hz(scheme, CLOCK_HZ) == 3
    assert sampling.frame_rate_hz(scheme, CLOCK_HZ) == Fraction(1000, 33)
    assert round(float(sampling.frame_rate_hz(scheme, CLOCK_HZ)), 3) == 30.303
    assert sampling.run_duration_s(scheme, CLOCK_HZ) == 33


def test_the_requirements_of_about_30_hz_and_1000_samples_lead_to_99_samples_per_frame():
    """Oracle: section 2.3; with 3 Hz and 1000 samples exact, 99 is the coprime number nearest to 30 Hz."""
    found = search(
        Wishes(
            clock_frequency_hz=CLOCK_HZ,
            wheel_rates_hz=(wish_around(Fraction(3), Fraction(0)),),
            frame_rate_hz=wish_around(Fraction(30), Fraction(2, 100)),
            samples_per_turn=wish_around(Fraction(1000), Fraction(0)),
        )
    )
    assert {option.schemes[0].samples_per_frame for option in found.best} == {99, 101}


def test_twenty_one_repeats_take_eleven_and_a_half_minutes(scheme, wishes):
    """Oracle: section 3.2.2, "repeated 21 times, taking 11.5 mins", without a correction in between."""
    plan = schedule((scheme,), wishes)
    assert [(run.repeats, run.is_after_correction) for run in plan] == [(21, True)]
    assert plan_duration_s(plan) == 21 * 33
    assert 11.5 <= plan_duration_s(plan) / 60 < 11.6


def test_the_second_sampling_point_is_recorded_at_the_eighth_trigger():
    """Oracle: figure 3, delta = 7 C (mod T); 10 samples in 3 turns is a toy with this property."""
    toy = TriggerScheme(turn_period_ticks=1000, camera_period_ticks=300)
    assert sampling.triggers_to_neighbour(toy) == 7
    assert 7 * toy.camera_period_ticks % toy.turn_period_ticks == toy.sampling_interval_ticks
    assert sampling.sampling_order(toy).tolist() == [0, 3, 6, 9, 2, 5, 8, 1, 4, 7]
    eighth = list(toy)[7]
    assert eighth.sample == 1


def test_an_exact_frame_rate_leads_to_a_prime_number_of_samples():
    """Oracle: section 2.3, last paragraph; 30 Hz of this clock fixes C = 2^16 25 and with it K = 2^a, N odd."""
    found = search(
        Wishes(
            clock_frequency_hz=CLOCK_HZ,
            wheel_rates_hz=(wish_around(Fraction(3), ONE_PERCENT),),
            frame_rate_hz=wish_around(Fraction(30), Fraction(0)),
            samples_per_turn=Wish(wanted=Fraction(1000), lowest=Fraction(500), highest=Fraction(2000)),
        )
    )
    schemes = [option.schemes[0] for option in found.best]
    assert {scheme.camera_period_ticks for scheme in schemes} == {CLOCK_HZ // 30}
    assert is_prime(schemes[0].samples_per_turn)
    assert schemes[0].samples_per_turn == 1279
    assert all(gcd(scheme.samples_per_turn, scheme.samples_per_frame) == 1 for scheme in schemes)
    assert all(scheme.samples_per_turn % 2 == 1 for scheme in schemes)
