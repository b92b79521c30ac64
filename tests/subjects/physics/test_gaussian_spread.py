"""Light spread over pixels by a Gaussian: against the error function."""

import numpy as np
import pytest
from scipy.stats import norm

from irtiming.physics import gaussian_spread


@pytest.mark.parametrize(("first", "last"), [(0, 6), (2, 5)])
def test_pixels_share_a_gaussian_by_its_distribution(first, last):
    """Oracle: differences of the normal distribution; room for just these pixels, which compiled code would not notice."""
    out = np.empty(last - first + 1)
    gaussian_spread._along_axis.py_func(3.3, first, last, 0.8, out)
    ends = np.arange(first, last + 2) - 0.5
    np.testing.assert_allclose(out, np.diff(norm.cdf(ends, 3.3, 0.8)), atol=1e-9)


def test_light_is_spread_over_rows_and_columns_and_none_is_lost():
    """Oracle: products of the normal distribution; points in the middle of an image and at its border."""
    places, values = (np.array([10.2, 0.4]), np.array([12.7, 24.1])), np.array([[2 - 1j, 0.5j]])
    found = gaussian_spread.deposit(places, values, blur=(0.7, 1.1), size=(21, 26))[0]
    rows, columns = np.arange(22) - 0.5, np.arange(27) - 0.5
    parts = [
        value * np.outer(np.diff(norm.cdf(rows, row, 0.7)), np.diff(norm.cdf(columns, column, 1.1)))
        for row, column, value in zip(*places, values[0], strict=True)
    ]
    np.testing.assert_allclose(found, sum(parts), atol=1e-6)
