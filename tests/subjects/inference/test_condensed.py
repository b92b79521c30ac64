"""Few residuals in the place of many."""

import numpy as np
import pytest

from irtiming.inference.condensed import condensed


@pytest.mark.parametrize("scale", [np.ones(3), np.array([1e-9, 1.0, 1e6])])
def test_deviance_gradient_and_normal_equations_stay(scale):
    """Oracle: 40 residuals and their derivatives; parameters of like and of very unlike size."""
    rng = np.random.default_rng(1)
    residual, jacobian = rng.normal(size=40), rng.normal(size=(40, 3)) * scale
    few = condensed(deviance=float(residual @ residual), gradient=-jacobian.T @ residual, normal=jacobian.T @ jacobian)
    assert few.residual.shape == (4,)
    assert few.deviance == pytest.approx(residual @ residual)
    np.testing.assert_allclose(few.gradient, -jacobian.T @ residual)
    np.testing.assert_allclose(few.normal, jacobian.T @ jacobian, rtol=1e-9, atol=1e-12 * np.outer(scale, scale).max())


def test_a_parameter_that_nothing_tells_does_no_harm():
    """Oracle: the same without it."""
    rng = np.random.default_rng(2)
    residual, jacobian = rng.normal(size=20), np.hstack([rng.normal(size=(20, 2)), np.zeros((20, 1))])
    few = condensed(deviance=float(residual @ residual), gradient=-jacobian.T @ residual, normal=jacobian.T @ jacobian)
    assert few.deviance == pytest.approx(residual @ residual)
    np.testing.assert_allclose(few.gradient, -jacobian.T @ residual, atol=1e-12)
    np.testing.assert_allclose(few.jacobian[:, 2], 0, atol=1e-6)
