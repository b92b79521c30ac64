"""`inference.tempered`: draws from posteriors whose moments are known otherwise."""

import numpy as np
import pytest

from irtiming.errors import EstimationError
from irtiming.inference import tempered


def test_a_normal_likelihood_gives_the_normal_posterior():
    """Oracle: closed form; six numbers, one of them told a thousand times better than before, two tied to each other."""
    root = np.diag([1000.0, 30.0, 3.0, 1.0, 0.3, 0.0])
    root[1, 2] = 25.0
    centre = np.array([0.4, -1.0, 1.5, 0.2, 1.0, 0.0])
    found = tempered.draws(lambda at: -0.5 * np.sum(((at - centre) @ root.T) ** 2, axis=1), n_numbers=6)
    covariance = np.linalg.inv(root.T @ root + np.eye(6))
    mean, u = covariance @ root.T @ root @ centre, np.sqrt(np.diag(covariance))
    assert np.all(np.abs(found.mean(axis=0) - mean) / u < 0.12)
    np.testing.assert_allclose(np.cov(found.T) / np.outer(u, u), covariance / np.outer(u, u), atol=0.1)


def test_a_bent_valley_with_two_floors():
    """Oracle: sums over a fine grid; a product is told, and its square root's sign not."""

    def told(at):
        return -0.5 * ((at[:, 0] * at[:, 1] - 0.6) / 0.05) ** 2

    found = tempered.draws(told, n_numbers=2)
    x, y = np.meshgrid(*2 * [np.linspace(-5, 5, 2001)])
    at = np.column_stack([x.ravel(), y.ravel()])
    weight = np.exp(told(at) - 0.5 * np.sum(at**2, axis=1))
    size = np.average(np.abs(at), axis=0, weights=weight)
    np.testing.assert_allclose(np.abs(found).mean(axis=0), size, rtol=0.04)
    assert np.mean(found[:, 0] > 0) == pytest.approx(0.5, abs=0.08)


@pytest.mark.parametrize("more", [1e4, -1e4])
def test_a_constant_beside_the_likelihood_changes_nothing(more):
    """Oracle: a law; only differences of its logarithm count, and one of ten thousand lets none be lost in rounding."""

    def told(at):
        return -0.5 * ((at[:, 0] - 1.0) / 0.1) ** 2

    plain, beside = (tempered.draws(one, n_numbers=2, n_draws=100) for one in (told, lambda at: told(at) + more))
    np.testing.assert_allclose(beside, plain, rtol=1e-6)


def test_the_same_each_time():
    """Oracle: two calls."""
    first, second = (tempered.draws(lambda at: -(at[:, 0] ** 2), n_numbers=1, n_draws=40) for _ in range(2))
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("nothing", [-np.inf, np.nan])
def test_what_is_known_beforehand_and_impossible_is_refused(nothing):
    """Oracle: by hand; without a single possible draw there is nowhere to go, and it must not go on for ever."""
    with pytest.raises(
        EstimationError, match="none of 40 draws of what is known beforehand is possible; check what rig"
    ):
        tempered.draws(lambda at: np.full(len(at), nothing), n_numbers=2, n_draws=40)
