"""Covariance of values with inputs in common, and what is fitted with it."""

import numpy as np
import pytest

from irtiming.inference import weighted_line
from irtiming.inference.common_inputs import covariance

OWN, SHARED = 3.0, 4.0


def _alike(n):
    """N values of u = 5, of which 4 comes from one input that all have."""
    return covariance(np.full(n, 5.0), [{"mask": SHARED}] * n)


def test_a_common_input_stays_in_the_mean_and_leaves_the_difference():
    """Oracle: by hand: u of a mean of 4 is sqrt(9/4 + 16), of a difference sqrt(2 * 9)."""
    found = _alike(4)
    assert np.full(4, 0.25) @ found @ np.full(4, 0.25) == pytest.approx(OWN**2 / 4 + SHARED**2)
    apart = np.array([1.0, -1.0, 0.0, 0.0])
    assert apart @ found @ apart == pytest.approx(2 * OWN**2)


def test_inputs_are_told_apart_by_name_and_sign():
    """Oracle: by hand, V_01 = 1*2 - 2*3; an input that only one has is its own; too large ones are scaled to u."""
    found = covariance(np.array([5.0, 6.0, 1.0]), [{"a": 1.0, "b": 2.0}, {"a": 2.0, "b": -3.0}, {"c": 9.0}])
    np.testing.assert_allclose(found, [[25.0, -4.0, 0.0], [-4.0, 36.0, 0.0], [0.0, 0.0, 1.0]], atol=1e-9)


def test_a_slope_is_known_better_than_a_value():
    """Oracle: ordinary least squares: u(slope) = own / sqrt(Sxx); the common input is all in the offset (by hand)."""
    x = np.array([1.0, 2.0, 3.0, 6.0])
    found = weighted_line.line(x, 7 + 0.5 * x, covariance=_alike(4))
    np.testing.assert_allclose(found.coefficients, [7, 0.5])
    sxx = np.sum((x - 3) ** 2)
    assert found.covariance[1, 1] == pytest.approx(OWN**2 / sxx)
    assert found.covariance[0, 0] == pytest.approx(OWN**2 * (1 / 4 + 9 / sxx) + SHARED**2)
    assert (found.chi_squared, found.degrees_of_freedom) == (pytest.approx(0, abs=1e-18), 2)


def test_slopes_of_many_series_scatter_as_stated():
    """Oracle: the law of pulls: 2000 series of settings of microseconds, with own errors and one in common."""
    rng, x = np.random.default_rng(4), np.array([1.0, 2.0, 4.0, 8.0, 9.0]) * 1e-6
    matrix = _alike(5) * 1e-14
    pulls, chi_squared = [], []
    for _ in range(2000):
        y = 4e-4 + 0.5 * x + 1e-7 * (rng.normal(0, OWN, 5) + rng.normal(0, SHARED))
        found = weighted_line.line(x, y, covariance=matrix)
        pulls.append((found.coefficients[1] - 0.5) / np.sqrt(found.covariance[1, 1]))
        chi_squared.append(found.chi_squared)
    assert np.std(pulls) == pytest.approx(1, abs=0.05)
    assert np.mean(chi_squared) == pytest.approx(3, abs=0.2)


def test_a_step_is_found_where_it_is_and_only_then():
    """Oracle: made by hand, a step of 40 after the third setting; and no step in a straight line."""
    x = np.arange(1.0, 8.0)
    found = weighted_line.step(x, 2 * x + 40 * (x > 3), covariance=_alike(7))
    assert found is not None
    assert (found.after, found.before) == (3.0, 4.0)
    assert found.size == pytest.approx(40)
    assert found.p_value < 1e-6
    straight = weighted_line.step(x, 2 * x, covariance=_alike(7))
    assert straight is None or straight.p_value == 1.0
    assert weighted_line.step(x[:3], x[:3], covariance=_alike(3)) is None
