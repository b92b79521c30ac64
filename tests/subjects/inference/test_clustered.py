"""`inference.clustered`: covariances of parameters whose residuals err alike within clusters."""

import numpy as np
import pytest

from irtiming.inference import clustered


def test_covariance_holds_for_residuals_that_scatter_more_than_noise():
    """Oracle: the sandwich of the textbook, written out cluster by cluster; two residuals each, and two that are known."""
    rng = np.random.default_rng(2)
    jacobian, residual = rng.normal(size=(42, 3)), 5 * rng.normal(size=42)
    clusters = np.append([-1, -1], np.tile(np.arange(20), 2))
    white = np.linalg.inv(jacobian.T @ jacobian)
    middle = jacobian[:2].T @ jacobian[:2]
    for k in range(20):
        score = jacobian[2 + k] * residual[2 + k] + jacobian[22 + k] * residual[22 + k]
        middle += np.outer(score, score)
    expected = white @ middle @ white
    assert np.all(np.diag(expected) > np.diag(white))
    np.testing.assert_allclose(clustered.covariance(jacobian, residual, clusters=clusters), expected)
    calm = clustered.covariance(jacobian, residual / 1e3, clusters=clusters)
    np.testing.assert_allclose(calm, white)


def test_what_is_known_beforehand_scatters_as_it_says():
    """Oracle: 3000 draws of a number, half of whose weight is known beforehand; pairs of residuals err alike.

    With nothing known in the middle of the sandwich, its variance would be three quarters of the scatter.
    """
    rng, n_pairs = np.random.default_rng(4), 40
    jacobian, clusters = np.ones((2 * n_pairs + 1, 1)), np.append(np.repeat(np.arange(n_pairs), 2), -1)
    jacobian[-1] = np.sqrt(2 * n_pairs)
    found, stated = [], []
    for _ in range(3000):
        noise = np.append(np.repeat(1.3 * rng.normal(size=n_pairs), 2), rng.normal())
        number = float(jacobian[:, 0] @ noise) / (4 * n_pairs)
        found.append(number)
        stated.append(clustered.covariance(jacobian, noise - jacobian[:, 0] * number, clusters=clusters)[0, 0])
    np.testing.assert_allclose(np.mean(stated), np.var(found), rtol=0.08)


def test_the_normal_matrix_is_its_inverse_and_says_nothing_where_residuals_do_not():
    """Oracle: the inverse; and a parameter that is the sum of two others, along which there is nothing to be told."""
    rng = np.random.default_rng(3)
    jacobian, residual = rng.normal(size=(60, 3)), 2 * rng.normal(size=60)
    clusters = np.tile(np.arange(20), 3)
    found = clustered.normal_matrix(jacobian, residual, clusters=clusters)
    np.testing.assert_allclose(
        found @ clustered.covariance(jacobian, residual, clusters=clusters), np.eye(3), atol=1e-9
    )
    mixed = np.column_stack([jacobian, jacobian[:, 0] + jacobian[:, 1]])
    again = clustered.normal_matrix(mixed, residual, clusters=clusters)
    np.testing.assert_allclose(again @ [1.0, 1.0, 0.0, -1.0], 0.0, atol=1e-3)
    np.testing.assert_allclose(again[:3, :3], found, rtol=1e-6)


@pytest.mark.parametrize(("own", "told"), [(3e-5, True), (3e-6, False)])
def test_numbers_that_look_nearly_alike_keep_what_tells_them_apart(own, told):
    """Oracle: by hand; 100 residuals without scatter, each of which tells a tenth of 100 numbers' sum and ``own`` of one of them.

    The sum's size is 100: 9e-10 is more than 1e-12 of it, and 9e-12 is less, which is nothing.
    """
    jacobian = np.full((100, 100), 0.1) + own * np.eye(100)
    found = clustered.normal_matrix(jacobian, np.zeros(100), clusters=np.arange(100))
    apart = np.eye(100)[3] - np.eye(100)[70]
    np.testing.assert_allclose(apart @ found @ apart, 2 * own**2 if told else 0.0, rtol=1e-3, atol=1e-14)
    np.testing.assert_allclose(found.sum(), np.sum(jacobian.sum(axis=1) ** 2))
