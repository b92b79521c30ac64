"""Slot angles learned from the timestamps of a wheel whose slots are known."""

import numpy as np
import pytest

from irtiming.physics import slot_orders
from irtiming.reduce.wheel import slot_table
from irtiming.reduce.wheel.edge_train import EdgeTrain, number_edges
from irtiming.reduce.wheel.slot_table import equal_slots, learn_slots

TURN = 2 * np.pi
REGULAR = TURN * np.arange(100) / 100


def _numbered(ticks):
    return number_edges(ticks, period_ticks=49_152_000 / 300, name="control_slot")


def _of_first(deviation, wheel):
    """The deviations in the order of the train: slot of the first edge first, mean zero."""
    first_s = (wheel.control_slot_ticks()[0] - wheel.start) / 49_152_000
    first = round((wheel.theta(first_s) + wheel.gate_separation) / (TURN / 100)) % 100
    rolled = np.roll(deviation, -first)
    return rolled - rolled.mean()


def _wrong_slots(seed=3):
    rng = np.random.default_rng(seed)
    eccentric = 4e-4 * np.sin(REGULAR + 0.7) + 1e-4 * np.sin(2 * REGULAR)
    return REGULAR + eccentric + rng.normal(0, 1e-4, 100)


def test_slot_errors_and_eccentricity_are_recovered_exactly_without_noise(paper_wheel):
    """Oracle: the slot angles that made the ticks; what is left is the clock's tick of 20 ns, 0.4 urad."""
    wheel = paper_wheel(slots=_wrong_slots())
    table = learn_slots(_numbered(wheel.control_slot_ticks()), 100)
    np.testing.assert_allclose(table.deviation_rad, _of_first(wheel.slots - REGULAR, wheel), atol=1e-6)
    assert abs(table.deviation_rad.mean()) < 1e-12


def test_slow_wander_of_the_speed_does_not_leak_into_the_slots(paper_wheel):
    """Oracle: the slot angles that made the ticks; the wheel wanders by 20 mrad over seconds."""
    wheel = paper_wheel(slots=_wrong_slots(), wander=((0.02, 11.0, 0.3), (0.005, 3.7, 1.0)))
    table = learn_slots(_numbered(wheel.control_slot_ticks()), 100)
    beside = table.deviation_rad - _of_first(wheel.slots - REGULAR, wheel)
    assert np.abs(beside).max() < 5e-5
    assert np.abs(beside).max() < 6 * table.u_deviation_rad.max()


def test_stated_uncertainty_is_honest(paper_wheel):
    """Oracle: the scatter of 30 repetitions about the known slots, in units of the stated uncertainty."""
    pulls = []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        wheel = paper_wheel(slots=_wrong_slots(seed), theta_0=float(rng.uniform(0, TURN)))
        ticks = wheel.control_slot_ticks()
        noisy = np.sort(ticks + np.rint(rng.normal(0, 800, ticks.size)).astype(np.int64))
        table = learn_slots(_numbered(noisy), 100)
        pulls.append((table.deviation_rad - _of_first(wheel.slots - REGULAR, wheel)) / table.u_deviation_rad)
    spread = np.std(pulls)
    assert abs(np.mean(pulls)) < 0.05
    assert 0.9 < spread < 1.1  # 3000 pulls know their spread to 1.3 %, a common widening to some more


@pytest.mark.parametrize("turns", [9, 12, 30])
def test_pulls_of_few_turns_are_standard(turns):
    """Oracle: 300 trains whose edges jitter each for itself; rms error of 20 slots over the root of the mean variance."""
    random, n_slots, period = np.random.default_rng(turns), 20, 100_000
    errors, variances = [], []
    for _ in range(300):
        number = np.arange(turns * n_slots)
        ticks = np.rint(period * number + random.normal(0, 200, number.size)).astype(np.int64)
        train = EdgeTrain(ticks=ticks, number=number, n_missing=0, n_spurious=0)
        table = learn_slots(train, n_slots)
        errors.append(np.mean(table.deviation_rad**2))
        variances.append(table.u_deviation_rad[0] ** 2)
    assert np.sqrt(np.mean(errors) / np.mean(variances)) == pytest.approx(1, abs=0.08)


def test_missing_edges_do_little_harm(paper_wheel):
    """Oracle: the slot angles that made the ticks; 40 of 10 200 edges are lost and bridged."""
    wheel = paper_wheel(slots=_wrong_slots())
    ticks = wheel.control_slot_ticks()
    gone = np.random.default_rng(1).choice(np.arange(1, ticks.size - 1), 40, replace=False)
    table = learn_slots(_numbered(np.delete(ticks, gone)), 100)
    beside = table.deviation_rad - _of_first(wheel.slots - REGULAR, wheel)
    assert np.abs(beside).max() < 1.5e-5
    assert np.std(beside) < 3e-6


def test_a_knock_does_little_harm(paper_wheel):
    """Oracle: the same wheel without it; in 4 of 100 turns the wheel runs wild by milliradians, half a turn long each."""
    wheel = paper_wheel(slots=_wrong_slots(), jitter_s=1e-6)
    calm = wheel.control_slot_ticks()
    knocked = calm.copy()
    for first in (1234, 3000, 5555, 8120):
        knocked[first : first + 50] += (20_000 * np.sin(np.linspace(0, np.pi, 50)) ** 2).astype(np.int64)  # 7.7 mrad
    learned = [learn_slots(_numbered(ticks), 100) for ticks in (calm, knocked)]
    moved = learned[1].deviation_rad - learned[0].deviation_rad
    u = learned[0].u_deviation_rad[0]
    assert np.std(moved) < u  # the plain mean would be moved by fifty times as much
    beside = learned[1].deviation_rad - _of_first(wheel.slots - REGULAR, wheel)
    assert np.std(beside) < 1.5 * learned[1].u_deviation_rad[0]
    assert learned[1].u_deviation_rad[0] < 2 * u


def test_deviations_close_the_circle(paper_wheel):
    """Oracle: a turn is a turn; the deviations have mean zero, and so have the rows of their covariance."""
    table = learn_slots(_numbered(paper_wheel(slots=_wrong_slots(), jitter_s=1e-6).control_slot_ticks()), 100)
    assert abs(table.deviation_rad.sum()) < 1e-15
    covariance = slot_orders.covariance_rad2(table.order_variance_rad2, 100)
    np.testing.assert_allclose(covariance.sum(axis=0), 0, atol=1e-20)
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), table.u_deviation_rad)


@pytest.mark.parametrize(("relative", "correlation_time_s"), [(1e-4, 0.5), (1e-3, 0.5), (1e-3, 0.05)])
def test_covariance_holds_a_wander_that_knows_nothing_of_the_slots(spun, relative, correlation_time_s):
    """Oracle: slots of the twin; chi-square of every order over 16 runs of 40 turns, and the rms error against u."""
    chi_squares, errors, u = [], [], []
    for seed in range(16):
        run = spun(seed, turns=40, relative=relative, correlation_time_s=correlation_time_s)
        table = learn_slots(run.train, 100)
        beside = np.roll(table.deviation_rad, run.first_slot) - run.slots
        chi_squares.append(slot_orders.chi_square(beside, table.order_variance_rad2))
        errors.append(np.mean(beside**2))
        u.append(table.u_deviation_rad[0] ** 2)
    by_order = np.mean(chi_squares, axis=0) / 2
    assert 0.4 < by_order[1] < 2.0  # 32 degrees of freedom
    assert 0.7 < by_order[2:10].mean() < 1.4
    assert 0.7 < by_order[10:50].mean() < 1.3
    assert 0.75 < np.sqrt(np.mean(errors) / np.mean(u)) < 1.3


@pytest.mark.parametrize("n_slots", [2, 15, 60])
def test_any_number_of_slots_is_learned(paper_wheel, n_slots):
    """Oracle: the slot angles that made the ticks, on rings with few, an odd and another even number of slots."""
    regular = TURN * np.arange(n_slots) / n_slots
    deviation = np.random.default_rng(2).normal(0, 1e-3, n_slots)
    deviation -= deviation.mean()
    wheel = paper_wheel(slots=regular + deviation)
    ticks = wheel.control_slot_ticks()
    train = number_edges(ticks, period_ticks=49_152_000 / 3 / n_slots, name="control_slot")
    first_s = (ticks[0] - wheel.start) / 49_152_000
    first = round((wheel.theta(first_s) + wheel.gate_separation) / (TURN / n_slots)) % n_slots
    table = learn_slots(train, n_slots)
    np.testing.assert_allclose(np.roll(table.deviation_rad, first), deviation, atol=1e-6)


def test_perfect_wheel_has_no_deviations_and_finite_uncertainties():
    """Oracle: by hand; edges at whole multiples of one number of ticks."""
    ticks = 163_840 * np.arange(2000, dtype=np.int64)
    table = learn_slots(EdgeTrain(ticks=ticks, number=np.arange(2000), n_missing=0, n_spurious=0), 100)
    np.testing.assert_allclose(table.deviation_rad, 0, atol=1e-12)
    assert np.all(np.isfinite(table.u_deviation_rad))
    assert np.all(table.u_deviation_rad < 1e-12)


@pytest.mark.parametrize(("n_edges", "learned"), [(900, True), (899, False), (101, False), (50, False)])
def test_fewer_than_eight_turns_teach_nothing(paper_wheel, n_edges, learned):
    """Oracle: the docstring; a turn is lost half at each end, so 9 turns of edges leave 8 to average."""
    ticks = paper_wheel(slots=_wrong_slots()).control_slot_ticks()[:n_edges]
    table = learn_slots(_numbered(ticks), 100)
    assert bool(np.any(table.deviation_rad != 0)) is learned
    assert table.deviation_rad.shape == table.u_deviation_rad.shape == (100,)


def test_equal_slots_deviate_nowhere():
    """Oracle: the definition."""
    table = equal_slots(60)
    assert table.deviation_rad.tolist() == table.u_deviation_rad.tolist() == [0.0] * 60


def test_a_wheel_that_is_run_backwards_has_its_table_turned():
    """Oracle: the symmetry; 12 turns of 6 slots and the turn that stands beside them, half before and half after, with jitter."""
    n = 13 * 6
    ticks = 1000 * np.arange(n) + np.random.default_rng(4).integers(-40, 41, n)
    forward, back = (
        learn_slots(EdgeTrain(ticks=each, number=np.arange(n), n_missing=0, n_spurious=0), 6)
        for each in (ticks, ticks[-1] - ticks[::-1])
    )
    np.testing.assert_allclose(back.deviation_rad, -forward.deviation_rad[::-1], atol=1e-9)


def test_what_turns_have_in_common_is_no_scatter():
    """Oracle: the same without it; 40 turns of 20 slots, each slot moved by as much in all of them."""
    random = np.random.default_rng(6)
    influence = random.normal(size=(40, 20))
    moved = influence + 5 * random.normal(size=20)
    np.testing.assert_allclose(slot_table._variance_of_mean(moved), slot_table._variance_of_mean(influence))


@pytest.mark.parametrize(("turns", "lags"), [(4, 2), (64, 4), (343, 7)])
def test_variance_of_a_mean_over_turns_is_that_of_newey_and_west(turns, lags):
    """Oracle: Bartlett's weights over pairs of turns, as many lags as the cube root of the turns says, at least two."""
    deviation = np.random.default_rng(5).normal(size=(turns, 8)).cumsum(axis=0)
    wave = (deviation - deviation.mean(axis=0)) @ np.exp(-2j * np.pi * np.arange(8) / 8) / 8**0.5
    apart = np.abs(np.subtract.outer(np.arange(turns), np.arange(turns)))
    weight = np.clip(1 - apart / (lags + 1), 0, None)
    expected = float((wave.conj() @ weight @ wave).real) / turns / (turns - 1 - lags)
    assert slot_table._variance_of_mean(deviation)[1] == pytest.approx(expected, rel=1e-9)


def test_what_was_not_recorded_moves_no_mean_and_what_is_far_moves_it_by_two_deviations():
    """Oracle: by hand; of 20 turns about zero, whose scale is 1.4826 by its median, one is far off and one was not recorded."""
    by_turn = np.array([-1.0, 1.0] * 10)[:, None] * np.ones(3)
    by_turn[3], by_turn[4] = 50.0, 0.0
    weight = np.ones((20, 3))
    weight[5, 1] = 0.0
    mean, influence = slot_table._robust_mean(by_turn, weight, least_scale=1e-3)
    limit = 2 * 1.4826
    assert influence[5, 1] == 0
    assert influence[4] == pytest.approx(-mean * 19 / np.array([19, 18, 19]))
    assert influence[3] == pytest.approx(limit * 19 / np.array([19, 18, 19]))
