"""Inverse of badly scaled matrices, and the variance of a sum whose parts hang together."""

from fractions import Fraction

import numpy as np
import pytest

from irtiming.physics.covariance import generalised_inverse, hac_covariance, inverse, root


def test_units_apart_by_twelve_powers_of_ten_cost_no_digits():
    """Oracle: the inverse of a 2 x 2 matrix in exact fractions; a delay in s beside an angle in rad looks like this."""
    a, b, d = Fraction(10) ** 14, Fraction(3) * 10**7, Fraction(10)
    exact = np.array([[d, -b], [-b, a]], dtype=object) / (a * d - b * b)
    matrix = np.array([[float(a), float(b)], [float(b), float(d)]])
    np.testing.assert_allclose(inverse(matrix), exact.astype(float), rtol=1e-13)


def test_a_matrix_that_says_nothing_of_a_number_or_of_a_difference():
    """Oracle: by hand; a sum known to 1/2 and a number that nothing tells; of a and b apart from their sum nothing is known."""
    normal = np.zeros((3, 3))
    normal[:2, :2] = 4.0
    expected = np.zeros((3, 3))
    expected[:2, :2] = 1 / 16
    np.testing.assert_allclose(generalised_inverse(normal), expected, atol=1e-15)
    whole = np.diag([1e14, 10.0]) + 3e7 * np.array([[0, 1], [1, 0]])
    np.testing.assert_allclose(generalised_inverse(whole), inverse(whole), rtol=1e-9)


def test_a_root_gives_the_covariance_back():
    """Oracle: the matrix itself, singular, of numbers of units nine powers of ten apart, one of them exact."""
    through = np.array([[1e-6, 2e-6], [3e3, -1e3], [0.0, 0.0], [4e-6, 8e-6]])
    covariance = through @ through.T
    found = root(covariance)
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    np.testing.assert_allclose(
        found @ found.T / np.outer(scale, scale), covariance / np.outer(scale, scale), atol=1e-12
    )


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
