"""Columns of a smooth curve against what splines must be able to draw."""

import numpy as np
import pytest

from irtiming.physics import smooth_curve

PLACE = np.linspace(0, 1, 501)


def test_no_interval_is_a_straight_line():
    """Oracle: by hand."""
    np.testing.assert_allclose(smooth_curve.columns(PLACE, 0)[:, 0], PLACE - 0.5)


@pytest.mark.parametrize("n_intervals", [1, 2, 7])
def test_with_a_constant_they_draw_every_cubic(n_intervals):
    """Oracle: a cubic polynomial is a spline on any knots; n intervals have n + 3 numbers, one of them the constant."""
    columns = smooth_curve.columns(PLACE, n_intervals)
    assert columns.shape == (PLACE.size, n_intervals + 2)
    whole = np.concatenate([np.ones((PLACE.size, 1)), columns], axis=1)
    cubic = 2 - 3 * PLACE + 5 * PLACE**2 - 4 * PLACE**3
    drawn = whole @ np.linalg.lstsq(whole, cubic, rcond=None)[0]
    np.testing.assert_allclose(drawn, cubic, atol=1e-12)
