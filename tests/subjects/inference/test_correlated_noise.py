"""Whether residuals are white, and how much wider correlated ones make a mean: against sums written out and many draws."""

import numpy as np
import pytest
from scipy import stats

from irtiming.inference.correlated_noise import ljung_box_p_value, variance_inflation


def _autoregressive(random, phi, n):
    """Each value phi of the one before and noise, in its steady state."""
    values, out = random.normal() / np.sqrt(1 - phi**2), np.empty(n)
    for k in range(n):
        out[k] = values
        values = phi * values + random.normal()
    return out


def test_probability_is_that_of_ljung_and_box():
    """Oracle: the statistic of Biometrika 65 (1978) 297 written out term by term, and scipy's chi-square tail."""
    residual = np.random.default_rng(1).normal(size=60) + 3.0
    mean, n, total = residual.sum() / 60, 60, 0.0
    below = sum((value - mean) ** 2 for value in residual)
    for lag in range(1, 21):
        above = sum((residual[t] - mean) * (residual[t - lag] - mean) for t in range(lag, n))
        total += (above / below) ** 2 / (n - lag)
    assert ljung_box_p_value(residual) == pytest.approx(stats.chi2.sf(n * (n + 2) * total, 20), rel=1e-9)


def test_probabilities_of_white_residuals_are_even():
    """Oracle: the even distribution (Kolmogorov and Smirnov) over 1000 draws."""
    random = np.random.default_rng(2)
    chances = [ljung_box_p_value(random.normal(size=400)) for _ in range(1000)]
    assert stats.kstest(chances, "uniform").pvalue > 1e-3


def test_correlated_residuals_are_not_white_and_few_say_nothing():
    """Oracle: by hand; a correlation of 0.3 from one to the next, 40 residuals for 20 lags, and none that scatter."""
    assert ljung_box_p_value(_autoregressive(np.random.default_rng(3), 0.3, 1000)) < 1e-6
    assert ljung_box_p_value(_autoregressive(np.random.default_rng(3), 0.9, 40)) == 1.0
    assert ljung_box_p_value(_autoregressive(np.random.default_rng(3), 0.9, 41)) < 1e-3
    assert ljung_box_p_value(np.full(100, 0.5)) == 1.0


@pytest.mark.parametrize(("phi", "factor"), [(0.0, 1.0), (0.5, 3.0), (0.8, 9.0)])
def test_widening_is_the_variance_of_a_mean_over_that_of_white_residuals(phi, factor):
    """Oracle: (1 + phi) / (1 - phi) for noise that keeps phi of itself from one value to the next; mean of 40 series."""
    random = np.random.default_rng(4)
    found = [variance_inflation(_autoregressive(random, phi, 4000)) for _ in range(40)]
    assert np.mean(found) == pytest.approx(factor, rel=0.08)


def test_widening_is_the_scatter_of_means():
    """Oracle: 2000 draws of 500 values that keep half of the one before: variance of their mean over variance / n."""
    random = np.random.default_rng(5)
    noise = random.normal(size=(2000, 700))
    series = np.zeros((2000, 700))
    for k in range(1, 700):
        series[:, k] = 0.5 * series[:, k - 1] + noise[:, k]
    series = series[:, 200:]
    seen = series.mean(axis=1).var() / (series.var() / 500)
    assert np.mean([variance_inflation(one) for one in series[:200]]) == pytest.approx(seen, rel=0.1)
    assert variance_inflation(np.zeros(100)) == 1.0
