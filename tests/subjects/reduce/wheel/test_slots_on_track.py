"""Tracks that get another slot table: angles, register and uncertainties by hand."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.records.wheel_track import WheelTrack
from irtiming.reduce.wheel.slot_table import SlotTable
from irtiming.reduce.wheel.slots_on_track import table_of, with_common_zero, with_slots

TURN = 2 * np.pi
N = 20
PER_SLOT = 10_000


def _table(seed=1, size_rad=1e-4, u_rad=2e-5):
    deviation = np.random.default_rng(seed).normal(0, size_rad, N)
    return SlotTable(deviation_rad=deviation - deviation.mean(), order_variance_rad2=np.full(N // 2 + 1, u_rad**2))


def _track(table, *, separation=0.5, scatter_rad=3e-5, jitter_rad=0.0, turns=9):
    """Constant speed; the slots' angles are those of the table."""
    number = np.arange(turns * N)
    alpha = TURN * number / N + table.deviation_rad[number % N] + jitter_rad
    return WheelTrack(
        edge_ticks=1000 + np.rint(alpha / TURN * N * PER_SLOT).astype(np.int64),
        edge_angle_rad=alpha - separation,
        clock_frequency_hz=1e6,
        angular_frequency_rad_per_s=TURN * 1e6 / N / PER_SLOT,
        gate_separation_rad=separation,
        u_gate_separation_rad=float(np.hypot(scatter_rad, table.u_register_rad)),
        slot_deviation_rad=table.deviation_rad,
        u_slot_deviation_rad=table.u_deviation_rad,
        order_variance_rad2=table.order_variance_rad2,
        application_edges_rad=(0.0, 1.6, 3.2, 4.7),
    )


def test_register_is_the_mean_of_the_slots_and_the_table_at_one_place():
    """Oracle: by hand; slots of 1e-4 rms have a mean of 1e-4 / sqrt(20), beside it the table's u of a single slot."""
    table = _table(u_rad=0.0)
    assert table.u_register_rad == pytest.approx(np.sqrt(np.mean(table.deviation_rad**2)) / np.sqrt(N))
    flat = SlotTable(deviation_rad=np.zeros(N), order_variance_rad2=np.full(N // 2 + 1, 1e-10))
    assert flat.u_register_rad == pytest.approx(np.sqrt(1e-10 * (N - 1) / N))  # order 0 is none
    both = _table()
    assert both.u_register_rad == pytest.approx(np.hypot(table.u_register_rad, both.u_deviation_rad[0]))


def test_register_is_that_of_many_wheels():
    """Oracle: 4000 wheels whose 20 slots are wrong each for itself; angle 0 is that of edge 0, the table's mean is zero."""
    wrong = np.random.default_rng(2).normal(0, 1e-4, (4000, N))
    stated = [
        SlotTable(deviation_rad=row - row.mean(), order_variance_rad2=np.zeros(11)).u_register_rad for row in wrong
    ]
    pulls = wrong.mean(axis=1) / np.array(stated)
    assert np.std(pulls) == pytest.approx(1, abs=0.08)


def test_another_table_moves_each_edge_by_its_own_slot():
    """Oracle: by hand; the wheel passes slot j at 2 pi j / 20 plus the new deviation, zero stays at the reference edge."""
    old, new = _table(1), _table(2, u_rad=4e-5)
    before = _track(old)
    found = with_slots(before, new)
    slot = np.arange(found.edge_ticks.size) % N
    alpha = TURN * np.arange(found.edge_ticks.size) / N + new.deviation_rad[slot]
    np.testing.assert_allclose(found.edge_angle_rad + found.gate_separation_rad, alpha, atol=1e-12)
    at_zero = np.interp(TURN * np.arange(8), before.edge_angle_rad, before.edge_ticks)
    np.testing.assert_allclose(
        np.interp(at_zero, found.edge_ticks, found.edge_angle_rad), TURN * np.arange(8), atol=1e-9
    )
    assert found.slot_deviation_rad is new.deviation_rad
    assert found.order_variance_rad2 is new.order_variance_rad2
    np.testing.assert_array_equal(found.u_slot_deviation_rad, new.u_deviation_rad)


def test_the_register_is_that_of_the_new_table():
    """Oracle: by hand; what the track's own edges scatter stays, the register of the old table goes."""
    new = _table(2, u_rad=4e-5)
    found = with_slots(_track(_table(1), scatter_rad=3e-5), new)
    assert found.u_gate_separation_rad == pytest.approx(np.hypot(3e-5, new.u_register_rad))
    exact = replace(_track(_table(1)), u_gate_separation_rad=0.0)
    assert with_slots(exact, new).u_gate_separation_rad == pytest.approx(new.u_register_rad)


def test_a_clock_may_have_begun_long_ago():
    """Oracle: the same track on a clock that has just begun; nanoseconds since 1970 are more than a double tells apart."""
    track, new = _track(_table(1)), _table(2)
    late = replace(track, edge_ticks=track.edge_ticks + 1_764_000_000_000_000_000)
    found, expected = with_slots(late, new), with_slots(track, new)
    assert found.gate_separation_rad == expected.gate_separation_rad
    np.testing.assert_array_equal(found.edge_angle_rad, expected.edge_angle_rad)


def test_an_angle_that_is_not_known_stays_so():
    """Oracle: the one that was taken out; the others are as they would be."""
    whole = _track(_table(1))
    angle = whole.edge_angle_rad.copy()
    angle[33] = np.nan
    found = with_slots(replace(whole, edge_angle_rad=angle), _table(2))
    other = with_slots(whole, _table(2))
    assert np.flatnonzero(np.isnan(found.edge_angle_rad)).tolist() == [33]
    known = np.arange(angle.size) != 33
    np.testing.assert_allclose(found.edge_angle_rad[known], other.edge_angle_rad[known], atol=1e-9)


def test_application_edges_stand_on_the_new_slots():
    """Oracle: by hand; each edge moves by what the slots beside it move, less what edge 0 does; none stay none."""
    old, new = _table(1), _table(2)
    before = _track(old, separation=0.5)
    change = np.append(new.deviation_rad - old.deviation_rad, new.deviation_rad[0] - old.deviation_rad[0])
    place = (np.array(before.application_edges_rad) + 0.5) / TURN * N
    low = place.astype(int)
    moved = change[low] + (place - low) * (change[low + 1] - change[low])
    expected = np.array(before.application_edges_rad) + moved - moved[0]
    assert with_slots(before, new).application_edges_rad == pytest.approx(expected, abs=1e-12)
    assert with_slots(replace(before, application_edges_rad=None), new).application_edges_rad is None


def test_the_common_zero_is_the_weighted_mean():
    """Oracle: by hand; scatters of 10 and 20 urad weigh 4 to 1, u is the root of 1 / (1 / 100 + 1 / 400), and the register."""
    table = _table()
    tracks = [_track(table, separation=0.5, scatter_rad=1e-5), _track(table, separation=0.5 + 3e-5, scatter_rad=2e-5)]
    found = with_common_zero(tracks)
    common = 0.5 + 3e-5 / 5
    assert [t.gate_separation_rad for t in found] == pytest.approx([common] * 2, abs=1e-12)
    u = np.hypot(1e-5 / np.sqrt(1 + 1 / 4), table.u_register_rad)
    assert [t.u_gate_separation_rad for t in found] == pytest.approx([u] * 2, rel=1e-6)
    for before, after in zip(tracks, found, strict=True):
        slots = before.edge_angle_rad + before.gate_separation_rad
        np.testing.assert_allclose(after.edge_angle_rad + common, slots, atol=1e-12)


def test_pulls_of_the_common_zero_are_standard():
    """Oracle: 400 draws of five recordings with their own scatters about one angle."""
    random, table = np.random.default_rng(3), _table(u_rad=0.0, size_rad=0.0)
    scatters = np.array([1e-5, 2e-5, 1.5e-5, 4e-5, 1e-5])
    pulls = []
    tracks = [_track(table, scatter_rad=s, turns=2) for s in scatters]
    for _ in range(400):
        moved = [
            replace(t, gate_separation_rad=0.5 + s * random.normal()) for t, s in zip(tracks, scatters, strict=True)
        ]
        found = with_common_zero(moved)[0]
        pulls.append((found.gate_separation_rad - 0.5) / found.u_gate_separation_rad)
    assert np.std(pulls) == pytest.approx(1, abs=0.12)
    assert abs(np.mean(pulls)) < 0.2


@pytest.mark.parametrize(("apart", "is_common"), [(4.9, True), (5.2, False)])
def test_gates_that_were_moved_keep_their_own_angles(apart, is_common):
    """Oracle: the limit of 5 standard uncertainties from the mean, in the module; two alike and one beside them."""
    table = _table()
    u = 1e-5
    beside = 0.5 + apart * u * 3 / 2  # the mean of three is a third of the way
    tracks = [_track(table, separation=s, scatter_rad=u) for s in (0.5, 0.5, beside)]
    found = with_common_zero(tracks)
    assert (len({t.gate_separation_rad for t in found}) == 1) is is_common
    assert is_common or found == tracks
    assert with_common_zero(tracks[:1]) == tracks[:1]


def test_slots_that_are_uncertain_each_for_itself_have_one_variance():
    """Oracle: by hand; a track that tells no orders has the mean square of its 20 slots' uncertainties in each of 0 to 10."""
    track = replace(_track(_table()), order_variance_rad2=None, u_slot_deviation_rad=np.full(N, 3e-5))
    np.testing.assert_allclose(table_of(track).order_variance_rad2, [9e-10] * 11)


def test_the_zero_is_that_of_all_turns():
    """Oracle: by hand; the zero lies between slots 1 and 2, and in the fourth of nine turns, where an edge is lost, 1 and 3."""
    old, new = _table(1), _table(2)
    whole = _track(old)
    kept = np.arange(9 * N) != 3 * N + 2
    before = replace(whole, edge_ticks=whole.edge_ticks[kept], edge_angle_rad=whole.edge_angle_rad[kept])
    place, change = TURN * np.arange(4) / N + old.deviation_rad[:4], (new.deviation_rad - old.deviation_rad)[:4]
    usual, other = (np.interp(0.5, place[[1, k]], change[[1, k]]) for k in (2, 3))
    assert abs(other - usual) > 1e-5
    assert with_slots(before, new).gate_separation_rad == pytest.approx(0.5 + (8 * usual + other) / 9, abs=1e-12)
