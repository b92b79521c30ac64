"""Inverse of badly scaled matrices, and the variance of a sum whose parts hang together."""

from fractions import Fraction

import numpy as np
import pytest

from irtiming.physics.covariance import hac_covariance, inverse


def test_units_apart_by_twelve_powers_of_ten_cost_no_digits():
    """Oracle: the inverse of a 2 x 2 matrix in exact fractions; a delay in s beside an angle in rad looks like this."""
    a, b, d = Fraction(10) ** 14, Fraction(3) * 10**7, Fraction(10)
    exact = np.array([[d, -b], [-b, a]], dtype=object) / (a * d - b * b)
    matrix = np.array([[float(a), float(b)], [float(b), float(d)]])
    np.testing.assert_allclose(inverse(matrix), exact.astype(float), rtol=1e-13)


def test_scores_weigh_as_by_hand():
    """Oracle: by hand; 1, 2, 3 with one neighbour at weight 1/2: 14 + 2/2 (2 + 6), and 3 more on a circle."""
    scores = np.array([[1.0], [2.0], [3.0]])
    assert hac_covariance(scores, n_neighbours=1, is_circular=False) == pytest.approx(22)
    assert hac_covariance(scores, n_neighbours=1, is_circular=True) == pytest.approx(25)


def test_a_moving_average_is_found_again():
    """Oracle: theory; the sum of n values x_i + x_(i+1) of white x has the variance 4 n, white scores would say 2 n."""
    x = np.random.default_rng(1).standard_normal(200_001)
    scores = (x[1:] + x[:-1])[:, None]
    found = hac_covariance(scores, n_neighbours=40, is_circular=True)[0, 0] / len(scores)
    assert found == pytest.approx(4.0, rel=0.06)
