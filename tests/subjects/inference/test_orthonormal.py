"""Orthonormal columns, against Householder's by NumPy."""

import numpy as np
import pytest

from irtiming.inference import orthonormal


def _columns(condition, *, m=300, j=12):
    rng = np.random.default_rng(3)
    turned = np.linalg.qr(rng.normal(size=(j, j)))[0]
    return np.linalg.qr(rng.normal(size=(m, j)))[0] @ (np.geomspace(1, 1 / condition, j)[:, None] * turned)


@pytest.mark.parametrize("condition", [1.0, 1e3, 1e5])
def test_columns_are_orthonormal_and_span_the_same(condition):
    """Oracle: a law, and the projector of NumPy's QR."""
    given = _columns(condition)
    found = orthonormal.of(given)
    np.testing.assert_allclose(found.columns.T @ found.columns, np.eye(12), atol=1e-14)
    np.testing.assert_allclose(given @ found.turn, found.columns, atol=1e-10)
    other = np.linalg.qr(given)[0]
    np.testing.assert_allclose(found.columns @ found.columns.T, other @ other.T, atol=1e-15 * max(condition, 10))


def test_amounts_are_those_of_least_squares_in_any_units():
    """Oracle: NumPy's least squares; columns from metres to nanometres."""
    given = _columns(1e2) * np.geomspace(1e-9, 1e9, 12)
    data = np.random.default_rng(5).normal(size=300)
    found = orthonormal.of(given)
    expected = np.linalg.lstsq(given / np.linalg.norm(given, axis=0), data, rcond=None)[0] / np.linalg.norm(
        given, axis=0
    )
    np.testing.assert_allclose(found.amounts(found.columns.T @ data), expected, rtol=1e-9)


def test_columns_that_depend_on_each_other_share_what_they_explain():
    """Oracle: by hand; the same column twice, one of zeros, and none at all."""
    one = np.array([3.0, 4.0, 0.0])
    found = orthonormal.of(np.stack([one, one, np.zeros(3)], axis=1))
    assert found.columns.shape == (3, 1)
    np.testing.assert_allclose(found.amounts(found.columns.T @ np.array([6.0, 8.0, 5.0])), [1.0, 1.0, 0.0], atol=1e-12)
    assert orthonormal.of(np.zeros((3, 2))).columns.shape == (3, 0)
    assert orthonormal.of(np.zeros((3, 0))).columns.shape == (3, 0)
