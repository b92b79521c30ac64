"""Search: against brute force and PARI/GP, and what it says of impossible wishes."""

import random
import re
import shutil
import subprocess
from dataclasses import replace
from fractions import Fraction
from math import floor, gcd

import pytest

from irtiming.errors import PlanError, UnitError
from irtiming.plan.candidates import MOST_PAIRS
from irtiming.plan.search import search
from irtiming.plan.wishes import exact_number, exact_seconds, ratio, whole_number, wish_around
from irtiming.records.trigger_plan import TriggerScheme, Wish, Wishes

ONE_PERCENT = Fraction(1, 100)


def _random_wishes(number, seed):
    """Small clocks, so that every T and C within the limits can be tried."""
    chance = random.Random(seed)
    tolerances = (Fraction(0), Fraction(1, 50), Fraction(1, 10), Fraction(1, 4))
    found = []
    while len(found) < number:
        clock = chance.randint(100, 4000)
        turn, camera = chance.randint(5, 400), chance.randint(1, 300)
        if chance.random() < 0.5:  # a wish that whole ticks can meet exactly, half of the time
            wheel, frame = Fraction(clock, turn), Fraction(clock, camera)
        else:
            wheel, frame = (
                Fraction(round(1000 * clock / turn) or 1, 1000),
                Fraction(round(10 * clock / camera) or 1, 10),
            )
        found.append(
            Wishes(
                clock_frequency_hz=clock,
                wheel_rates_hz=(wish_around(wheel, chance.choice(tolerances)),),
                frame_rate_hz=wish_around(frame, chance.choice(tolerances)),
                samples_per_turn=wish_around(Fraction(chance.randint(1, 80)), chance.choice(tolerances)),
                control_slots=chance.choice((1, 2, 3, 4, 6, 10)),
                longest_uninterrupted_s=chance.choice((None, Fraction(chance.randint(1, 40)))),
                trigger_delays_s=(Fraction(0), Fraction(chance.randint(0, 100), 1000)),
            )
        )
    return found


def _brute_force(wishes):
    """Every admissible (T, C) with its rank key, by trying all and applying the four conditions as written."""
    clock, slots = wishes.clock_frequency_hz, wishes.control_slots
    (wheel,), frame, samples = wishes.wheel_rates_hz, wishes.frame_rate_hz, wishes.samples_per_turn
    turns = [
        turn for turn in range(1, int(clock / wheel.lowest) + 1)
        if turn % slots == 0 and wheel.lowest * turn <= clock <= wheel.highest * turn
    ]  # fmt: skip
    cameras = [
        camera for camera in range(1, int(clock / frame.lowest) + 1)
        if frame.lowest * camera <= clock <= frame.highest * camera
    ]  # fmt: skip
    delay = max(round(time * clock) for time in wishes.trigger_delays_s)
    longest = wishes.longest_uninterrupted_s
    found = []
    for turn in turns:
        for camera in cameras:
            number = turn // gcd(turn, camera)
            fits = longest is None or number * camera + delay <= longest * clock
            if samples.lowest <= number <= samples.highest and fits:
                used = (
                    _share(turn, clock / wheel.highest, clock / wheel.wanted, clock / wheel.lowest)
                    + _share(camera, clock / frame.highest, clock / frame.wanted, clock / frame.lowest)
                    + _share(number, samples.lowest, samples.wanted, samples.highest)
                )
                found.append((used, number * camera, turn, camera))
    return sorted(found)


def _share(value, lowest, wanted, highest):
    if value == wanted:
        return Fraction(0)
    return (value - wanted) / (highest - wanted) if value > wanted else (wanted - value) / (wanted - lowest)


def _found(wishes):
    try:
        options = search(wishes, most=10**6)
    except PlanError:
        return [], 0
    return [(option.used_tolerance, option.schemes[0]) for option in options.best], options.n_options


def test_random_wishes_agree_with_brute_force_in_number_members_and_order():
    """Oracle: all T and all C within the limits, tried one by one; ranks by exact fractions."""
    possible = 0
    for wishes in _random_wishes(400, seed=1):
        expected = _brute_force(wishes)
        found, number = _found(wishes)
        assert number == len(expected), wishes
        assert [
            (used, s.samples_per_turn * s.camera_period_ticks, s.turn_period_ticks, s.camera_period_ticks)
            for used, s in found
        ] == expected, wishes
        possible += bool(expected)
    assert 100 < possible < 300


def test_the_nearest_wish_that_is_named_works():
    """Oracle: search again with the wish that the message names; it then finds a scheme."""
    named = 0
    for wishes in _random_wishes(300, seed=2):
        try:
            search(wishes)
        except PlanError as error:
            message = str(error)
            assert "\n" not in message
            advice = re.search(r"the nearest that works is (.*)", message)
            if advice is None:
                assert "leave" in message or "widen several limits" in message or "does not fit" in message
                continue
            search(_as_advised(wishes, advice[1]))
            named += 1
    assert named > 100


def _as_advised(wishes, advice):
    """Replace what the message names by exact wishes."""
    if match := re.search(r"wheel rate of (\S+) Hz", advice):
        wishes = replace(wishes, wheel_rates_hz=(_exactly(match[1]),))
    if match := re.search(r"frame rate of (\S+) Hz", advice):
        wishes = replace(wishes, frame_rate_hz=_exactly(match[1]))
    if match := re.search(r"(\S+) samples per turn", advice):
        wishes = replace(wishes, samples_per_turn=_exactly(match[1]))
    return wishes


def _exactly(text):
    return wish_around(exact_number(text, "the wish"), Fraction(0))


@pytest.mark.skipif(shutil.which("gp") is None, reason="PARI/GP is not installed (Debian: pari-gp)")
def test_random_wishes_and_the_papers_agree_with_pari_gp():
    """Oracle: PARI/GP 2.15, which the paper used, on its own rational numbers; one process for all cases."""
    tight = Fraction(1, 10_000)
    cases = [
        *_random_wishes(150, seed=3),
        _paper_wishes(samples=Fraction(1000), frame="30.303", tolerance=tight),
        replace(
            _paper_wishes(samples=Fraction(1000), frame="30", tolerance=ONE_PERCENT),
            frame_rate_hz=wish_around(Fraction(30), Fraction(0)),
            samples_per_turn=Wish(wanted=Fraction(1000), lowest=Fraction(500), highest=Fraction(2000)),
        ),
    ]
    script = (
        "a(f,s,wl,wh,rl,rh,nl,nh,l)={my(v=List(),t,n);"
        "forstep(t=s*ceil(f/wh/s),floor(f/wl),s,for(c=max(1,ceil(f/rh)),floor(f/rl),"
        "n=t/gcd(t,c);if(n>=nl&&n<=nh&&(l<0||lcm(t,c)<=l),listput(v,[t,c]))));print(Vec(v))};\n"
    )
    script += "".join(_gp_call(wishes) for wishes in cases)
    done = subprocess.run(["gp", "-q", "-f"], input=script, capture_output=True, text=True, timeout=60, check=True)
    lines = done.stdout.split("\n")[: len(cases)]
    for wishes, line in zip(cases, lines, strict=True):
        expected = [(int(turn), int(camera)) for turn, camera in re.findall(r"\[(\d+), (\d+)\]", line)]
        found = [(s.turn_period_ticks, s.camera_period_ticks) for _, s in _found(wishes)[0]]
        assert sorted(found) == sorted(expected), wishes


def _gp_call(wishes):
    (wheel,), frame, samples = wishes.wheel_rates_hz, wishes.frame_rate_hz, wishes.samples_per_turn
    clock, longest = wishes.clock_frequency_hz, -1
    if wishes.longest_uninterrupted_s is not None:
        delay = max(round(time * clock) for time in wishes.trigger_delays_s)
        longest = max(0, floor(wishes.longest_uninterrupted_s * clock) - delay)
    numbers = (wheel.lowest, wheel.highest, frame.lowest, frame.highest, samples.lowest, samples.highest, longest)
    return f"a({clock},{wishes.control_slots},{','.join(map(str, numbers))})\n"


def _paper_wishes(samples=Fraction(1000), frame="30.303", tolerance=ONE_PERCENT, wheels=("3",)):
    return Wishes(
        clock_frequency_hz=49_152_000,
        wheel_rates_hz=tuple(wish_around(Fraction(wheel), tolerance) for wheel in wheels),
        frame_rate_hz=wish_around(Fraction(frame), tolerance),
        samples_per_turn=wish_around(samples, tolerance),
    )


def test_a_great_number_is_counted_and_the_best_of_all_still_come_first():
    """Oracle: brute force over T and C within 0.05 %; further away a scheme uses 0.005 of 10 % limits or more."""
    wishes = _paper_wishes(tolerance=Fraction(1, 10))
    found = search(wishes, most=8)
    assert found.n_options > 300_000
    near = [
        (turn, camera)
        for turn in range(16_376_000, 16_392_001, 100)
        for camera in range(1_621_200, 1_622_830)
        if 900 <= turn // gcd(turn, camera) <= 1100
    ]
    clock, (wheel,), frame = wishes.clock_frequency_hz, wishes.wheel_rates_hz, wishes.frame_rate_hz
    expected = sorted(
        (
            _share(turn, clock / wheel.highest, clock / wheel.wanted, clock / wheel.lowest)
            + _share(camera, clock / frame.highest, clock / frame.wanted, clock / frame.lowest)
            + _share(turn // gcd(turn, camera), Fraction(900), Fraction(1000), Fraction(1100)),
            turn,
            camera,
        )
        for turn, camera in near
    )
    assert found.best[-1].used_tolerance < Fraction("0.0045")
    assert [
        (option.used_tolerance, option.schemes[0].turn_period_ticks, option.schemes[0].camera_period_ticks)
        for option in found.best
    ] == expected[:8]


def test_several_wheel_speeds_share_the_camera_period_where_possible():
    """Oracle: each scheme admissible by itself, one C, and no shared C is missed for small clocks."""
    found = search(_paper_wishes(wheels=("2", "3", "4")))
    assert found.shares_camera_period
    assert found.is_complete
    for option in found.best:
        assert len({scheme.camera_period_ticks for scheme in option.schemes}) == 1
    alone = [search(_paper_wishes(wheels=(wheel,)), most=10**5) for wheel in ("2", "3", "4")]
    periods = [{option.schemes[0].camera_period_ticks for option in each.best} for each in alone]
    assert found.n_options == len(set.intersection(*periods))
    assert found.n_schemes == tuple(each.n_options for each in alone)


def test_wheel_speeds_without_a_common_camera_period_get_their_own():
    """Oracle: by hand; 10 samples exactly: C = 300 serves T = 1000 only, and C = 297 T = 990 only."""
    wishes = Wishes(
        clock_frequency_hz=99_000,
        wheel_rates_hz=(wish_around(Fraction(99), Fraction(0)), wish_around(Fraction(100), Fraction(0))),
        frame_rate_hz=Wish(wanted=Fraction(330), lowest=Fraction(329), highest=Fraction(334)),
        samples_per_turn=wish_around(Fraction(10), Fraction(0)),
        control_slots=10,
    )
    found = search(wishes)
    assert not found.shares_camera_period
    assert found.n_options == 1
    assert [(s.turn_period_ticks, s.camera_period_ticks) for s in found.best[0].schemes] == [(1000, 300), (990, 297)]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"samples_per_turn": wish_around(Fraction(5), Fraction(0))}, ["samples per frame", "never a whole number"]),
        ({"frame_rate_hz": wish_around(Fraction("30.303"), Fraction(0))}, ["no whole C", "1000/33 Hz"]),
        ({"frame_rate_hz": wish_around(Fraction(30), Fraction(0))}, ["no multiple of the 100 control slots"]),
        ({"wheel_rates_hz": (wish_around(Fraction("3.1"), Fraction(0)),)}, ["is a multiple of the 100 control slots"]),
        ({"wheel_rates_hz": (wish_around(Fraction(2_000_000), Fraction(0)),)}, ["491520 Hz at most"]),
        ({"longest_uninterrupted_s": Fraction(20)}, ["32.353858 s", "20 s are left", "12.353858 s more"]),
        ({"longest_uninterrupted_s": Fraction(1), "trigger_delays_s": (Fraction(2),)}, ["delay of 2 s", "1 s"]),
        ({"samples_per_turn": wish_around(Fraction(8), Fraction(0)), "control_slots": 1}, ["nearest"]),
    ],
)
def test_an_impossible_wish_names_the_constraint_that_fails(changes, words):
    """Oracle: by hand from the four conditions of admissibility."""
    with pytest.raises(PlanError) as caught:
        search(replace(_paper_wishes(), **changes))
    message = str(caught.value)
    assert "\n" not in message
    assert all(word in message for word in words), message


def test_more_time_as_advised_makes_the_plan_possible():
    """Oracle: 20 s and the 12.353858 s that the message asks for."""
    wishes = replace(_paper_wishes(), longest_uninterrupted_s=Fraction("32.353858"))
    assert search(wishes).n_options >= 1
    with pytest.raises(PlanError, match="leave"):
        search(replace(wishes, longest_uninterrupted_s=Fraction("32.353856")))


def test_limits_too_wide_to_search_are_refused_and_not_cut():
    """Oracle: a million numbers of samples are more pairs than the stated bound."""
    samples = Wish(wanted=Fraction(1000), lowest=Fraction(1), highest=Fraction(10**6))
    with pytest.raises(PlanError, match=str(MOST_PAIRS)):
        search(replace(_paper_wishes(), samples_per_turn=samples))


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: exact_number("three", "the wheel rate"), UnitError, "'three'"),
        (lambda: exact_number("nan", "the wheel rate"), UnitError, "'nan'"),
        (lambda: exact_number("inf", "the wheel rate"), UnitError, "'inf'"),
        (lambda: exact_number("1/0", "the wheel rate"), UnitError, "1/0"),
        (lambda: exact_number("1e999999999", "the wheel rate"), UnitError, "not a number"),
        (lambda: exact_number("0", "the wheel rate"), PlanError, "greater than 0"),
        (lambda: exact_number("-3", "the wheel rate"), PlanError, "greater than 0"),
        (lambda: whole_number("1000.5", "samples"), UnitError, "whole"),
        (lambda: exact_seconds("20 parsec", "the delay"), UnitError, "20 parsec"),
        (lambda: exact_seconds("25", "the delay"), UnitError, "has no unit; write it such as '25 ms'"),
        (lambda: exact_seconds("-1 s", "the delay"), PlanError, "negative"),
        (lambda: ratio("100%", "the tolerance"), PlanError, "below 100%"),
        (lambda: ratio("a bit", "the tolerance"), UnitError, "a bit"),
        (lambda: search(_paper_wishes(), most=0), PlanError, "at least 1"),
        (lambda: replace(_paper_wishes(), clock_frequency_hz=0), PlanError, "clock frequency"),
        (lambda: replace(_paper_wishes(), repeats=-1), PlanError, "repeats"),
        (lambda: replace(_paper_wishes(), wheel_rates_hz=()), PlanError, "wheel rate"),
        (lambda: replace(_paper_wishes(), trigger_delays_s=()), PlanError, "trigger delay"),
        (lambda: replace(_paper_wishes(), trigger_delays_s=(Fraction(-1),)), PlanError, "advanced"),
        (lambda: replace(_paper_wishes(), longest_uninterrupted_s=Fraction(0)), PlanError, "positive"),
        (lambda: _paper_wishes(samples=Fraction(10**9)), PlanError, "10000000 at most"),
        (lambda: Wish(wanted=3.0, lowest=Fraction(2), highest=Fraction(4)), PlanError, "not exact"),
        (lambda: Wish(wanted=Fraction(5), lowest=Fraction(2), highest=Fraction(4)), PlanError, "order"),
        (lambda: TriggerScheme(turn_period_ticks=1050, camera_period_ticks=3), PlanError, "1000 and 1100"),
        (lambda: TriggerScheme(turn_period_ticks=0, camera_period_ticks=3), PlanError, "at least 1"),
    ],
)
def test_a_bad_number_is_refused_in_one_clear_line(call, error, words):
    """Oracle: the message names the value or the limit."""
    with pytest.raises(error) as caught:
        call()
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
