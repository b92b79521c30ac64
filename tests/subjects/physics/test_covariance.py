"""Inverse of badly scaled matrices, and the variance of a sum whose parts hang together."""

from fractions import Fraction

import numpy as np
import pytest

from irtiming.physics.covariance import generalised_inverse, hac_covariance, hac_samples, inverse, root, shrunk


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


def test_triangle_is_that_of_newey_and_west():
    """Oracle: the double sum over all pairs of frames at most eight apart, weight 1 - distance / 9, written out."""
    scores = np.random.default_rng(5).normal(size=(60, 2))
    expected = np.zeros((2, 2))
    for a in range(60):
        for b in range(60):
            apart = min((a - b) % 60, (b - a) % 60)
            expected += max(0, 1 - apart / 9) * np.outer(scores[a], scores[b])
    np.testing.assert_allclose(hac_covariance(scores, n_neighbours=8, is_circular=True), expected, rtol=1e-9)


def test_so_many_independent_samples_scatter_as_much():
    """Oracle: 4000 repetitions; an estimated variance of n independent samples scatters by its size times the root of 2 / n."""
    rng = np.random.default_rng(2)
    found = [hac_covariance(rng.normal(size=(300, 1)), n_neighbours=8, is_circular=True)[0, 0] for _ in range(4000)]
    relative = np.std(found) / np.mean(found)
    assert np.sqrt(2 / hac_samples(300, n_neighbours=8)) == pytest.approx(relative, rel=0.04)


def test_correlations_are_shrunk_as_by_hand():
    """Oracle: by hand; a correlation of 0.5 of 15 samples where none is expected: chance (4 + 2.5) / 15 / 3, apart 0.5.

    Units of 2e3 and 1e-3, and the size of what is expected, change nothing.
    """
    units = np.diag([2e3, 1e-3])
    estimated = units @ np.array([[1.0, 0.5], [0.5, 1.0]]) @ units
    found = shrunk(estimated, 7 * units**2, n_samples=15)
    left = 0.5 * (1 - 6.5 / 45 / 0.5)
    np.testing.assert_allclose(found, units @ np.array([[1.0, left], [left, 1.0]]) @ units, rtol=1e-12)


def test_chance_is_shrunk_away_and_what_is_there_stays():
    """Oracle: 500 repetitions of covariances of 40 samples in eight numbers; the one expected, and one far from it."""
    rng = np.random.default_rng(3)
    expected = np.diag(np.arange(1.0, 9.0))
    far = expected + 30 * np.outer(np.ones(8), np.ones(8))
    for true, at_most in ((expected, 0.5), (far, 1.02)):
        errors = {"estimated": 0.0, "shrunk": 0.0}
        for _ in range(500):
            samples = rng.multivariate_normal(np.zeros(8), true, size=40)
            estimated = samples.T @ samples / 40
            errors["estimated"] += float(np.sum((estimated - true) ** 2))
            errors["shrunk"] += float(np.sum((shrunk(estimated, expected, n_samples=40) - true) ** 2))
        assert errors["shrunk"] < at_most * errors["estimated"]


def test_variances_stay():
    """Oracle: the diagonal; one number alone, and none at all, are what they were."""
    estimated = np.array([[4.0, 1.0, 0.0], [1.0, 9.0, 2.0], [0.0, 2.0, 25.0]])
    expected = np.array([[2.0, 1.0, 0.5], [1.0, 3.0, 0.1], [0.5, 0.1, 1.0]])
    found = shrunk(estimated, expected, n_samples=12)
    np.testing.assert_allclose(np.diag(found), [4.0, 9.0, 25.0])
    assert np.all(np.linalg.eigvalsh(found) > 0)
    np.testing.assert_array_equal(shrunk(np.zeros((3, 3)), expected, n_samples=12), np.zeros((3, 3)))
    np.testing.assert_allclose(shrunk(np.array([[3.0]]), np.array([[2.0]]), n_samples=5), [[3.0]])
