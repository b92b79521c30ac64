"""The line through stamps that scatter: against brute force, against lines that are known, with queues as computers have them."""

from itertools import combinations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.stats import norm

from irtiming.errors import EstimationError
from irtiming.inference.stamp_line import grid, median_line, numbered


def _arrivals(rng, n=600, *, jitter_s=5e-5, late=0.05):
    """Frame number, true time, and arrival: noise, and one frame in twenty waits for milliseconds."""
    number = np.flatnonzero(rng.uniform(size=n) > 0.02)
    true_s = 0.0331 * number
    waits = (rng.uniform(size=number.size) < late) * rng.exponential(4e-3, number.size)
    stamp_s = 5.0 + (1 + 2e-5) * true_s + rng.normal(0, jitter_s, number.size) + waits
    return number, true_s, stamp_s


def _median_latency(jitter_s=5e-5, late=0.05, wait_s=4e-3):
    """Of noise and waits, by the distribution of their sum on a fine grid of waits."""
    shares = (np.arange(4000) + 0.5) / 4000
    waits = -wait_s * np.log1p(-shares)

    def beyond_half(at):
        return (1 - late) * norm.cdf(at / jitter_s) + late * np.mean(norm.cdf((at - waits) / jitter_s)) - 0.5

    return brentq(beyond_half, -1e-3, 1e-3)


@pytest.mark.parametrize("step_s", [0.0, 1e-3], ids=["smooth", "stamps in whole steps"])
def test_no_line_through_two_stamps_has_less_deviation(step_s):
    """Oracle: brute force over all pairs of stamps, one of whose lines is the best; tails, few stamps, many that are equal."""
    rng = np.random.default_rng(4)
    for n in (8, 9, 17, 24, 31):
        x = np.sort(rng.choice(60, n, replace=False)).astype(float)
        stamp_s = 3.0 + 0.03 * x + rng.standard_gamma(0.5, n) * 5e-3
        if step_s:
            stamp_s = np.floor(stamp_s / step_s) * step_s
        found = median_line(x, stamp_s)
        least = min(
            np.abs(stamp_s - stamp_s[i] - (stamp_s[k] - stamp_s[i]) / (x[k] - x[i]) * (x - x[i])).sum()
            for i, k in combinations(range(n), 2)
        )
        assert np.abs(stamp_s - found.stamp_s(x)).sum() == pytest.approx(least, rel=1e-9)
        assert found.deviation_s == pytest.approx(stamp_s - found.stamp_s(x), abs=1e-12)


def test_a_clock_is_found_within_its_uncertainty_beside_queues():
    """Oracle: 100 clocks drawn with 50 us of jitter and heavy tails; pulls of the median in the middle and of the rate."""
    rng, level, rate, plain = np.random.default_rng(2), [], [], []
    for _ in range(100):
        _, true_s, stamp_s = _arrivals(rng)
        found = median_line(true_s, stamp_s)
        true_there = 5.0 + (1 + 2e-5) * found.middle + _median_latency()
        level.append((found.at_middle_s - true_there) / found.u_at_middle_s)
        rate.append((found.rate - 1 - 2e-5) / found.u_rate)
        plain.append(np.polyfit(true_s, stamp_s, 1)[0] - 1 - 2e-5)
    assert np.sqrt(np.mean(np.square(level))) == pytest.approx(0.9, abs=0.25)  # u is the larger of two ways to tell it
    assert np.sqrt(np.mean(np.square(rate))) == pytest.approx(0.9, abs=0.25)
    assert found.u_rate < np.std(plain) / 3  # what least squares would have made of the queues
    assert found.jitter_s == pytest.approx(5e-5, rel=0.15)
    assert 0.02 < found.late_share < 0.08


def test_half_of_the_arrivals_are_later_whatever_the_tail():
    """Oracle: the meaning of a median; tails that are ten times longer leave the line where it is."""
    rng = np.random.default_rng(12)
    x, late = np.arange(401.0), rng.standard_gamma(2.0, 401) * 4e-4
    found = median_line(x, 0.03 * x + late)
    late_ones = found.deviation_s > 1e-9
    longer = median_line(x, 0.03 * x + late + np.where(late_ones, 9 * found.deviation_s, 0.0))
    assert abs(np.count_nonzero(late_ones) - np.count_nonzero(found.deviation_s < -1e-9)) <= 2
    assert longer.stamp_s(x) == pytest.approx(found.stamp_s(x), abs=1e-9)


def test_frames_are_counted_where_some_are_lost():
    """Oracle: the numbers that were drawn."""
    number, _, stamp_s = _arrivals(np.random.default_rng(6), late=0.0)
    assert numbered(stamp_s).tolist() == (number - number[0]).tolist()


def test_steps_after_late_frames_make_the_period_no_shorter():
    """Oracle: the numbers that the times were made of; every fourth frame is late by 0.4 periods, and 30 are lost at once."""
    number = np.concatenate([np.arange(60), np.arange(90, 150)])
    late = np.where(number % 4 == 2, 0.4, 0.0)
    assert np.array_equal(numbered(number + late), number)


def test_arrivals_alone_count_the_frames_that_were_lost():
    """Oracle: the numbers that the times were made of: hiccups of 20 ms among frames every 33 ms, and three gaps."""
    random = np.random.default_rng(2)
    number = np.delete(np.arange(300), [50, 51, 120, 250])
    late = random.gamma(2.0, 0.4e-3, number.size) + np.where(random.random(number.size) < 0.03, 15e-3, 0)
    assert np.array_equal(numbered(33.1234e-3 * number + late), number)


def test_the_median_of_normal_stamps_is_as_uncertain_as_theory_says():
    """Oracle: pi / 2 times the variance of the mean (Kendall); quantiles of the normal distribution, spread over the places."""
    n = 2001
    beside = norm.ppf((np.arange(n) + 0.5) / n)[(np.arange(n) * 811) % n]
    found = median_line(np.arange(float(n)), 100.0 * np.arange(n) + beside)
    assert found.u_at_middle_s == pytest.approx(np.sqrt(np.pi / 2 / n), rel=0.02)


def test_place_and_stamp_are_each_other_s_inverse():
    """Oracle: there and back."""
    found = median_line(np.arange(20.0), 3 + 2 * np.arange(20.0))
    assert found.stamp_s(np.array([4.0])) == pytest.approx([11.0])
    assert found.x_of(found.stamp_s(np.array([1.5, 7.0]))) == pytest.approx([1.5, 7.0])


def test_a_clock_that_wanders_says_so():
    """Oracle: a sine of 1 ms that no straight line follows."""
    time_s = np.arange(800) * 0.03
    wander_s = 1e-3 * np.sin(2 * np.pi * time_s / 6)
    found = median_line(time_s, time_s + wander_s + np.random.default_rng(1).normal(0, 1e-5, 800))
    assert found.wander_s == pytest.approx(1e-3 / 2**0.5, rel=0.2)
    assert found.bend > 3


@pytest.mark.parametrize(
    ("x", "stamp_s", "said"),
    [
        (np.arange(5.0), np.arange(5.0), "there are 5 places and 5 stamps"),
        (np.arange(20.0), -np.arange(20.0), "do not rise"),
        (np.zeros(20), np.arange(20.0), "all 20 stamps are of one frame"),
    ],
)
def test_what_is_no_line_is_refused(x, stamp_s, said):
    """Oracle: the words of each refusal."""
    with pytest.raises(EstimationError, match=said):
        median_line(x, stamp_s)


def test_what_is_no_grid_is_refused():
    """Oracle: random times, which are on no grid."""
    with pytest.raises(EstimationError, match="half of the stamps are further than"):
        grid(np.arange(200), np.sort(np.random.default_rng(1).uniform(0, 9, 200)))
