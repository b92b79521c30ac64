"""Light spread over pixels by a Gaussian: against the error function."""

import numpy as np
import pytest
from numpy.polynomial.hermite_e import hermeval
from scipy.special import erf, factorial
from scipy.stats import multivariate_normal, norm

from irtiming.physics import gaussian_spread
from irtiming.records.blur import Blur


@pytest.mark.parametrize(("first", "last"), [(0, 6), (2, 5)])
def test_pixels_share_a_gaussian_by_its_distribution(first, last):
    """Oracle: differences of the normal distribution; room for just these pixels, which compiled code would not notice."""
    n = last - first + 1
    out, room = np.empty((1, n)), np.empty((1, n + 1))
    gaussian_spread._along_axis.py_func((first - 0.5 - 3.3) / 0.8, 1 / 0.8, n, gaussian_spread._series(0.0), room, out)
    ends = np.arange(first, last + 2) - 0.5
    np.testing.assert_allclose(out[0], np.diff(norm.cdf(ends, 3.3, 0.8)), atol=1e-9)


def test_hermite_functions_across_pixels_are_derivatives_of_the_density():
    """Oracle: NumPy's Hermite polynomials times the density, over the root of k!; room for just these pixels."""
    series = gaussian_spread._series(0.4)
    n_terms, n = series.weight.size, 5
    assert n_terms > 8
    out, room = np.empty((n_terms, n)), np.empty((n_terms, n + 1))
    gaussian_spread._along_axis.py_func(-2.7, 1.1, n, series, room, out)
    ends = -2.7 + 1.1 * np.arange(n + 1)
    for k in range(1, n_terms):
        hermite = hermeval(ends, [0.0] * (k - 1) + [1.0]) / np.sqrt(factorial(k - 1))
        np.testing.assert_allclose(out[k], np.diff(hermite * norm.pdf(ends)), atol=1e-7)
    np.testing.assert_allclose(series.weight[1:], [0.4**k / k for k in range(1, n_terms)])


@pytest.mark.parametrize(("correlation", "n_terms"), [(0.0, 1), (1e-7, 1), (2e-6, 2), (-0.1, 6), (0.1, 6)])
def test_the_series_has_as_many_terms_as_its_correlation_asks(correlation, n_terms):
    """Oracle: by hand, the terms left out: 1e-6 x r^n / n / (1 - r) of a geometric series that is larger than theirs."""
    assert gaussian_spread._series(correlation).weight.size == n_terms


def test_what_lies_below_a_place_is_counted_from_the_middle():
    """Oracle: the error function; places from seven standard deviations below on, 128 steps for each."""
    places = np.array([-6.5, -1.234, 0.0, 0.77, 5.1])
    found = [gaussian_spread._below.py_func(at) for at in (places + 7) * 128]
    np.testing.assert_allclose(found, erf(places / np.sqrt(2)) / 2, atol=1e-11)


def test_light_is_spread_over_rows_and_columns_and_none_is_lost():
    """Oracle: products of the normal distribution; points in the middle of an image and at its border."""
    places, values = (np.array([10.2, 0.4]), np.array([12.7, 24.1])), np.array([[2 - 1j, 0.5j]])
    found = gaussian_spread.deposit(places, values, blur=Blur(0.7, 1.1), widening=np.ones(2), size=(21, 26))[0]
    rows, columns = np.arange(22) - 0.5, np.arange(27) - 0.5
    parts = [
        value * np.outer(np.diff(norm.cdf(rows, row, 0.7)), np.diff(norm.cdf(columns, column, 1.1)))
        for row, column, value in zip(*places, values[0], strict=True)
    ]
    np.testing.assert_allclose(found, sum(parts), atol=1e-6)


@pytest.mark.parametrize(
    "blur", [Blur(0.7, 1.1, 0.6), Blur(0.9, 0.6, -0.5), Blur(0.5, 0.6, 0.7), Blur(2.0, 1.5, 0.3), Blur(0.5, 0.9, 0.85)]
)
def test_a_blur_askew_is_a_normal_distribution_of_two_places(blur):
    """Oracle: SciPy's bivariate normal distribution over each pixel, to what SciPy's is good for."""
    row, column, size = 10.2, 12.7, (21, 26)
    places, one = (np.array([row]), np.array([column])), np.array([[1 + 0j]])
    found = gaussian_spread.deposit(places, one, blur=blur, widening=np.ones(1), size=size)[0].real
    covariance = np.array([[blur.rows_px**2, blur.covariance_px2], [blur.covariance_px2, blur.columns_px**2]])
    ends = np.stack(np.meshgrid(np.arange(22) - 0.5, np.arange(27) - 0.5, indexing="ij"), axis=-1)
    below = multivariate_normal([row, column], covariance).cdf(ends)
    expected = np.diff(np.diff(below, axis=0), axis=1)
    np.testing.assert_allclose(found, expected, atol=5e-7)
    np.testing.assert_allclose(found.sum(), 1, atol=1e-6)


def test_a_blur_hardly_askew_differs_by_the_product_of_both_densities():
    """Oracle: the derivative of a normal distribution of two places by their correlation (Plackett 1954), in closed form."""
    places, values, small = (np.array([10.2]), np.array([12.7])), np.array([[2 - 1j]]), 1e-3
    straight, askew = (
        gaussian_spread.deposit(places, values, blur=Blur(0.7, 1.1, r), widening=np.ones(1), size=(21, 26))[0]
        for r in (0.0, small)
    )
    rows, columns = (np.arange(22) - 0.5 - 10.2) / 0.7, (np.arange(27) - 0.5 - 12.7) / 1.1
    slope = (2 - 1j) * np.outer(np.diff(norm.pdf(rows)), np.diff(norm.pdf(columns)))
    np.testing.assert_allclose((askew - straight) / small, slope, atol=small)
    assert np.abs(slope).max() > 0.1


@pytest.mark.parametrize("correlation", [0.0, 0.4])
def test_each_point_has_a_blur_as_wide_as_it_says(correlation):
    """Oracle: points one by one, each with its own blur of one width."""
    places, values = (np.array([10.2, 4.4]), np.array([12.7, 17.1])), np.array([[2 - 1j, 0.5j]])
    wider = np.array([1.0, 1.6])
    found = gaussian_spread.deposit(places, values, blur=Blur(0.7, 0.9, correlation), widening=wider, size=(21, 26))
    alone = [
        gaussian_spread.deposit(
            (places[0][k : k + 1], places[1][k : k + 1]), values[:, k : k + 1],
            blur=Blur(0.7 * wider[k], 0.9 * wider[k], correlation), widening=np.ones(1), size=(21, 26),
        )
        for k in (0, 1)
    ]  # fmt: skip
    np.testing.assert_allclose(found, sum(alone), atol=1e-12)
