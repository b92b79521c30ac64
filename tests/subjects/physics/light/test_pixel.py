"""What single pixels see, harmonic by harmonic: against a sum by hand, and derivatives against differences."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.physics.light.pixel import PixelLight, PixelNumbers, linearised
from irtiming.physics.response import first_order_lag

_OMEGA = 19.0
_AT = PixelNumbers(
    contrast_dn=np.array([900.0, -30.0]), delay_s=np.array([2e-3, 7e-3]), response_s=np.array([8e-3, 1.5e-2])
)


@pytest.fixture
def pixels():
    """Two pixels at three orders."""
    rng = np.random.default_rng(1)
    return PixelLight(
        orders=np.array([0, 2, 6]),
        light=rng.normal(size=(3, 2)) + 1j * rng.normal(size=(3, 2)),
        wheel=rng.normal(size=3) + 1j * rng.normal(size=3),
        angular_frequency_rad_per_s=_OMEGA,
        response=first_order_lag,
    )


def test_a_pixel_follows_the_light_of_a_delay_before(pixels):
    """Oracle: the lag's differential equation, tau y' + y = x, put into the wave of each order, at an hour of the turn."""
    observed, _ = linearised(pixels, _AT)
    turning = 1j * pixels.orders[:, None] * _OMEGA
    scene = pixels.light * pixels.wheel[:, None]
    left = _AT.response_s * turning * observed + observed
    later = np.exp(turning * 0.3)
    np.testing.assert_allclose(left * later, _AT.contrast_dn * scene * np.exp(turning * (0.3 + _AT.delay_s)), atol=1e-9)


@pytest.mark.parametrize(
    ("k", "name", "step"), [(0, "contrast_dn", 1.0), (1, "delay_s", 1e-6), (2, "response_s", 1e-6)]
)
def test_derivatives_are_those_of_differences(pixels, k, name, step):
    """Oracle: central differences of the harmonics."""
    _, slopes = linearised(pixels, _AT)
    above, below = (linearised(pixels, replace(_AT, **{name: getattr(_AT, name) + sign * step}))[0] for sign in (1, -1))
    np.testing.assert_allclose(slopes[k], (above - below) / (2 * step), rtol=1e-5, atol=1e-3)
