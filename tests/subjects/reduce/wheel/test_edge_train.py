"""Numbering of edges: what is missing, doubled, spurious or jittered, and what must be refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from irtiming.errors import ReductionError
from irtiming.reduce.wheel.edge_train import number_edges
from irtiming.units import counted

PERIOD = 163_840
STARTS = (0, -5_000_000_000, 2**47 - 1000, -(2**47))


def _regular(n=1000, start=7_000_000):
    return start + PERIOD * np.arange(n, dtype=np.int64)


def _numbered(ticks, **options):
    return number_edges(ticks, **({"period_ticks": PERIOD, "name": "control_slot"} | options))


@pytest.mark.parametrize("start", STARTS)
def test_regular_edges_are_counted(start):
    """Oracle: by hand; nothing is missing, wherever the counter starts."""
    ticks = _regular(start=start)
    train = _numbered(ticks)
    assert train.number.tolist() == list(range(1000))
    assert train.ticks.tolist() == ticks.tolist()
    assert (train.n_missing, train.n_spurious) == (0, 0)
    assert train.findings("control_slot", recording="run") == ()


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("gone", [[500], [1], [998], [20, 21], [20, 22, 24], list(range(300, 318))])
def test_missing_edges_leave_their_numbers_free(start, gone):
    """Oracle: the edges that were taken out, by their index."""
    train = _numbered(np.delete(_regular(start=start), gone))
    assert train.number.tolist() == [i for i in range(1000) if i not in gone]
    assert (train.n_missing, train.n_spurious) == (len(gone), 0)
    assert f"{counted(len(gone), 'edge')} missing" in train.findings("control_slot", recording="run")[0].what


@pytest.mark.parametrize("at", [0, 1, 3, 500, 990, 998, 999])
@pytest.mark.parametrize("later", [0, 1, 800, 60_000, 82_000, 110_000])
def test_an_added_edge_is_dropped_wherever_it_is(at, later):
    """Oracle: the added edge; the regular ones keep number and tick."""
    ticks = _regular()
    train = _numbered(np.insert(ticks, at + 1, ticks[at] + later))
    assert train.number.tolist() == list(range(1000))
    assert train.ticks.tolist() == ticks.tolist()
    assert (train.n_missing, train.n_spurious) == (0, 1)
    (finding,) = train.findings("control_slot", recording="run")
    assert (finding.code, finding.severity, finding.recording) == ("edges-out-of-place", "warning", "run")
    assert finding.what == (
        "control_slot: 0 edges missing (bridged by interpolation), 1 doubled or spurious (dropped), of 1000"
    )


def test_an_edge_before_the_first_is_dropped():
    """Oracle: by hand; a pulse a third of a period before the first true edge."""
    ticks = _regular()
    train = _numbered(np.insert(ticks, 0, ticks[0] - PERIOD // 3))
    assert train.ticks.tolist() == ticks.tolist()
    assert train.n_spurious == 1


def test_jitter_and_slow_wander_are_followed():
    """Oracle: the generated numbers; 5 % jitter per edge and a speed that wanders by 10 % in all."""
    rng = np.random.default_rng(5)
    n = 3000
    phase = np.cumsum(1 + 0.05 * np.sin(np.arange(n) / 200))
    ticks = np.rint(PERIOD * (phase + rng.normal(0, 0.02, n))).astype(np.int64)
    gone = rng.choice(np.arange(1, n - 1), 25, replace=False)
    train = _numbered(np.delete(ticks, gone))
    assert train.number.tolist() == sorted(set(range(n)) - set(gone.tolist()))


@pytest.mark.parametrize("last", [1.45, 0.6])
def test_a_speed_that_drifts_beyond_the_tolerance_is_followed(last):
    """Oracle: the generated numbers; periods that go from 1 to 1.45 or 0.6 of the nominal one, a step far beyond 25 %."""
    n = 3000
    ticks = np.rint(PERIOD * np.cumsum(np.linspace(1, last, n))).astype(np.int64)
    gone = [700, 1500, 2500, 2900]
    train = _numbered(np.delete(ticks, gone))
    assert train.number.tolist() == sorted(set(range(n)) - set(gone))
    assert (train.n_missing, train.n_spurious) == (4, 0)


def test_spurious_edge_beside_a_missing_one_is_not_taken_for_it():
    """Oracle: by hand; edge 400 is gone and a pulse 0.4 periods later stands in its stead."""
    ticks = _regular()
    ticks[400] += 2 * PERIOD // 5
    train = _numbered(ticks)
    assert train.number.tolist() == [i for i in range(1000) if i != 400]
    assert (train.n_missing, train.n_spurious) == (1, 1)


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_numbering_survives_a_few_random_losses_and_additions(data):
    """Oracle: the generated numbers; a few edges lost and a few pulses added anywhere, jitter of a percent."""
    n = 400
    start = data.draw(st.integers(-(2**47), 2**47))
    seed = data.draw(st.integers(0, 2**32 - 1))
    lost = data.draw(st.sets(st.integers(0, n - 1), max_size=4))
    added = data.draw(st.lists(st.tuples(st.integers(0, n - 1), st.floats(0.3, 0.7)), max_size=3))
    jitter = np.random.default_rng(seed).uniform(-0.01, 0.01, n)
    ticks = start + np.rint(PERIOD * (np.arange(n) + jitter)).astype(np.int64)
    true = np.array([i for i in range(n) if i not in lost])
    pulses = np.array([ticks[i] + int(share * PERIOD) for i, share in added], np.int64)
    train = _numbered(np.sort(np.concatenate([ticks[true], pulses])))
    assert train.ticks.tolist() == ticks[true].tolist()
    assert train.number.tolist() == (true - true[0]).tolist()


@pytest.mark.parametrize("at", [0, 500, 999])
def test_doubled_edges_within_jitter_keep_the_numbers(at):
    """Oracle: the count; which of two edges 1 us apart is kept moves the angle by 1 us of one slot only."""
    ticks = np.insert(_regular(), at + 1, _regular()[at] + 49)
    train = _numbered(ticks)
    assert train.number.tolist() == list(range(1000))
    assert np.abs(train.ticks - _regular()).max() <= 49


def test_edges_that_run_backwards_are_refused():
    """Oracle: by hand; edge 11 is earlier than edge 10."""
    ticks = _regular()
    ticks[11] = ticks[10] - 5
    with pytest.raises(ReductionError, match=r"control_slot runs backwards after edge 10 .* one unwrapped counter"):
        _numbered(ticks)


def test_counter_that_wraps_is_refused():
    """Oracle: recording-format; a 32-bit counter that wraps runs backwards, and must be unwrapped by the writer."""
    with pytest.raises(ReductionError, match=r"runs backwards"):
        _numbered(np.mod(_regular(start=2**32 - 50 * PERIOD), 2**32))


@pytest.mark.parametrize("speed", [0.5, 0.7, 1.4, 2.0])
def test_wrong_rotation_speed_is_refused(speed):
    """Oracle: the edges come at 1 / speed of the period that the rotation speed asks for."""
    with pytest.raises(ReductionError, match=r"the rotation speed asks for .* correct rotation_speed"):
        _numbered(_regular(), period_ticks=PERIOD * speed)


def test_too_few_edges_are_refused():
    """Oracle: the limit of 8 in the module."""
    assert _numbered(_regular(8)).number.size == 8
    with pytest.raises(
        ReductionError, match=r"control_slot holds 7 edges, at least 8 are needed; check that the light"
    ):
        _numbered(_regular(7))
    with pytest.raises(ReductionError, match=r"holds 0 edges"):
        _numbered(np.array([], np.int64))


def test_too_many_wrong_edges_are_refused():
    """Oracle: the limit of 2 %; 2 % are repaired, 2.5 % are not."""
    every = np.arange(10, 1000, 40)
    repaired = _numbered(np.delete(_regular(), every[:19]))
    assert repaired.n_missing == 19
    with pytest.raises(
        ReductionError, match=r"25 edges missing and 0 doubled or spurious of 975, at most 2% can be rep"
    ):
        _numbered(np.delete(_regular(), every))


def test_missing_and_spurious_edges_count_together():
    """Oracle: by hand; 12 that are missing and 12 that are spurious are 24 of 1000, more than 2 % though neither is."""
    ticks = np.delete(_regular(), np.arange(10, 1000, 82)[:12])
    added = ticks[40:1000:78][:12] + PERIOD // 2
    with pytest.raises(ReductionError, match=r"12 edges missing and 12 doubled or spurious of 1000"):
        _numbered(np.sort(np.concatenate([ticks, added])))


def test_lost_rhythm_is_refused_by_name():
    """Oracle: by hand; a burst of noise, then edges at half a period beside their places."""
    ticks = _regular()
    ticks[500:] += PERIOD // 2
    with pytest.raises(ReductionError, match=r"control_slot loses its rhythm after tick 88756160: .* 1.50"):
        _numbered(ticks)


@pytest.mark.parametrize(
    ("asked", "cure"),
    [
        (1.0, r"edges are missing, doubled or spurious among the 28 there are: check the light gate"),
        (0.5, "correct rotation_speed"),
    ],
)
def test_few_edges_with_gaps_are_no_wrong_speed(asked, cure):
    """Oracle: by hand; of 32 edges every eighth is gone: no 8 follow each other at the speed that is asked for, or at half."""
    ticks = np.delete(_regular(32), np.arange(3, 32, 8))
    period = asked * float(np.median(np.diff(ticks)))
    with pytest.raises(ReductionError, match=cure):
        number_edges(ticks, period_ticks=period, name="application_slot")
