"""Gaussian basis functions of which a smooth field is made."""

import numpy as np
import pytest

from irtiming.physics.smooth_field import SmoothField

ROWS, COLUMNS = np.arange(8.0, 62.0), np.arange(41.0, 110.0)


def _terms(field):
    return np.array([field.at(one) for one in np.eye(field.size)])


def test_basis_functions_stand_on_a_grid():
    """Oracle: Gaussians as wide as the grid's steps, from a step before the region to a step after it; flat when summed."""
    field = SmoothField.over(ROWS, COLUMNS)
    terms = _terms(field)
    n = round(field.size**0.5)
    assert terms.shape == (n * n, 54, 69)
    grid = terms.reshape(n, n, 54, 69)
    corners = [grid[1, 1, 0, 0], grid[1, -2, 0, -1], grid[-2, 1, -1, 0], grid[-2, -2, -1, -1]]
    assert corners == pytest.approx([1, 1, 1, 1])
    assert grid[0, 1, 0, 0] == pytest.approx(np.exp(-0.5))
    assert terms.max() <= 1
    whole = terms.sum(axis=0)
    assert whole.max() / whole.min() < 1.3
    inner = whole[12:42, 15:54]
    assert inner.max() / inner.min() < 1.1


@pytest.mark.parametrize("width_px", [9.0, 15.0, 21.0, 30.0, 60.0])
def test_reflection_of_a_camera(width_px):
    """Oracle: a Gaussian beside the region's middle, met to 0.5 % of its height everywhere, in the corners too."""
    terms = _terms(SmoothField.over(ROWS, COLUMNS)).reshape(-1, 54 * 69)
    reflected = np.exp(-0.5 * ((ROWS[:, None] - 59.5) ** 2 + (COLUMNS - 79.5) ** 2) / width_px**2).ravel()
    heights, *_ = np.linalg.lstsq(terms.T, reflected, rcond=1e-9)
    assert np.abs(heights @ terms - reflected).max() < 5e-3


def test_sums_and_products_are_those_of_the_basis_functions():
    """Oracle: the functions written out pixel by pixel, summed with a weight that is no product of rows and columns."""
    field = SmoothField.over(ROWS[:17], COLUMNS[:23], steps=3)
    terms = _terms(field)
    weight = np.random.default_rng(3).uniform(size=(17, 23))
    np.testing.assert_allclose(field.sums(weight), np.einsum("kij,ij->k", terms, weight))
    np.testing.assert_allclose(field.products(weight), np.einsum("kij,lij,ij->kl", terms, terms, weight))
