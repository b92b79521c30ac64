"""Clocks from stamps that scatter: against lines that are known, with queues as computers have them."""

import numpy as np
import pytest

from irtiming.apply.clock_model import frame_numbers, line
from irtiming.errors import EstimationError


def _arrivals(rng, n=600, *, jitter_s=5e-5, late=0.05):
    """Frame number, true time, and arrival: noise, and one frame in twenty waits for milliseconds."""
    number = np.flatnonzero(rng.uniform(size=n) > 0.02)
    true_s = 0.0331 * number
    waits = (rng.uniform(size=number.size) < late) * rng.exponential(4e-3, number.size)
    stamp_s = 5.0 + (1 + 2e-5) * true_s + rng.normal(0, jitter_s, number.size) + waits
    return number, true_s, stamp_s


def test_a_clock_is_found_within_its_uncertainty_beside_queues():
    """Oracle: 100 clocks drawn with 50 us of jitter and heavy tails; pulls of the line in the middle and of its rate."""
    rng, level, rate, plain = np.random.default_rng(2), [], [], []
    for _ in range(100):
        _, true_s, stamp_s = _arrivals(rng)
        found = line(true_s, stamp_s)
        middle = np.array([found.middle_s])
        level.append((found.stamp_s(middle)[0] - 5.0 - (1 + 2e-5) * found.middle_s) / found.u_s(middle)[0])
        rate.append((found.rate - 1 - 2e-5) / found.u_rate)
        plain.append(np.polyfit(true_s, stamp_s, 1)[0] - 1 - 2e-5)
    assert np.sqrt(np.mean(np.square(level))) < 1.3
    assert np.sqrt(np.mean(np.square(rate))) == pytest.approx(1, abs=0.25)
    assert found.u_rate < np.std(plain) / 3  # what least squares would have made of the queues
    assert found.jitter_s == pytest.approx(5e-5, rel=0.15)
    assert 0.02 < found.late_share < 0.08


def test_frames_are_counted_where_some_are_lost():
    """Oracle: the numbers that were drawn."""
    number, _, stamp_s = _arrivals(np.random.default_rng(6), late=0.0)
    assert frame_numbers(stamp_s).tolist() == (number - number[0]).tolist()


def test_time_and_stamp_are_each_other_s_inverse():
    """Oracle: there and back."""
    found = line(np.arange(20.0), 3 + 2 * np.arange(20.0))
    assert found.stamp_s(np.array([4.0])) == pytest.approx([11.0])
    assert found.time_s(found.stamp_s(np.array([1.5, 7.0]))) == pytest.approx([1.5, 7.0])


def test_a_clock_that_wanders_says_so():
    """Oracle: a sine of 1 ms that no straight line follows."""
    time_s = np.arange(800) * 0.03
    found = line(
        time_s, time_s + 1e-3 * np.sin(2 * np.pi * time_s / 24) + np.random.default_rng(1).normal(0, 1e-5, 800)
    )
    assert found.wander_s == pytest.approx(1e-3 / 2**0.5, rel=0.6)


@pytest.mark.parametrize(
    ("time_s", "stamp_s", "said"),
    [
        (np.arange(5.0), np.arange(5.0), "there are 5 times and 5 stamps"),
        (np.arange(20.0), -np.arange(20.0), "do not rise"),
    ],
)
def test_what_is_no_clock_is_refused(time_s, stamp_s, said):
    """Oracle: the words of each refusal."""
    with pytest.raises(EstimationError, match=said):
        line(time_s, stamp_s)
