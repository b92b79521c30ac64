"""Scatter and weights that single outliers do not spoil."""

import numpy as np
from scipy.special import ndtri

from irtiming.physics import robust


def test_the_spread_of_normal_noise_is_its_standard_deviation():
    """Oracle: quantiles of the normal distribution, of which one of a thousand is far off."""
    noise = 3.0 * ndtri((np.arange(1000) + 0.5) / 1000)
    noise[0] = -1e6
    assert abs(robust.spread(noise) - 3.0) < 0.01


def test_weights_are_the_slope_of_the_loss():
    """Oracle: differences of the loss, over twice the size; at 3 it goes from the square to its tangent, 6 x - 9."""
    size, step = np.array([1.0, 2.0, 4.0, 100.0]), 1e-4
    np.testing.assert_allclose(robust.huber_loss(size, 3.0), [1.0, 4.0, 15.0, 591.0])
    slope = (robust.huber_loss(size + step, 3.0) - robust.huber_loss(size - step, 3.0)) / (2 * step)
    np.testing.assert_allclose(robust.huber_weight(size, 3.0), slope / (2 * size), rtol=1e-6)
