"""A response that is no straight line, against exponentials that a wheel leaves behind, put through the curve pixel by pixel."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.physics.light import pixel_waves
from irtiming.physics.light.bent_rows import PixelPowers, bends
from irtiming.physics.response import first_order_lag
from irtiming.physics.wheel import wheel_model
from irtiming.physics.wheel_harmonics import at_angles, open_harmonics

TURN, M, N = 2 * np.pi, 300, 36_000
LAG_RAD = 0.15
EDGES = (0.0, 1.5718, 3.1421, 4.7125)
MODEL = wheel_model(EDGES, 0.2682, opening_angle_rad=1.3, centre_angle_rad=float(np.radians(-90)))
ANGLE = np.arange(N) * TURN / N
WAVE = open_harmonics(MODEL, M).sum(axis=0) * first_order_lag.transfer(1.0, LAG_RAD, n_harmonics=M)


@pytest.fixture(scope="module")
def lagging():
    """What a point at the opening's centre shows over a turn: it follows the open and closed wheel exponentially."""
    phase = np.mod(MODEL.opening_coordinate_rad + ANGLE + TURN / N / 2, TURN)
    seen = ((phase > EDGES[1]) & (phase < EDGES[2])) | (phase > EDGES[3])
    kept, value, shown = np.exp(-TURN / N / LAG_RAD), 0.0, np.empty(N)
    for _ in range(2):
        for k in range(N):
            shown[k] = value
            value = seen[k] + (value - seen[k]) * kept
    return shown


def _beside(values, wave):
    """What is left of values over a turn beside a constant and so much of the wave."""
    own = np.stack([np.ones(N), wave], axis=1)
    return values - own @ np.linalg.lstsq(own, values, rcond=None)[0]


@pytest.mark.parametrize("number", [0, 1], ids=["quadratic", "cubic"])
@pytest.mark.parametrize(("share", "whole"), [(1.0, 1.0), (0.4, 1.0), (1.15, 1.15), (0.5, 0.9)])
def test_a_bent_pixel_is_the_lagging_one_through_the_curve(lagging, number, share, whole):
    """Oracle: v + b v (1 - v), or c v (1 - v) (1 - 2 v), of the exponentials; beside the gain that the contrast image shows.

    A pixel wholly in the light, one on the border, one in front of which the wheel mirrors more, and both.
    """
    phi = 100 * TURN / N

    def of_power(value):
        one = np.array([[value]])
        return pixel_waves.by_row(one, np.array([[phi]]), smear=np.ones((1, 1)), n_harmonics=M)

    pixels = PixelPowers(
        squares=of_power(share**2), cubes=of_power(share**3), askew=of_power(3 * share**2 * (2 * whole - 1 - share)),
        smear=np.ones(1),
    )  # fmt: skip
    wave = np.roll(lagging, 100)
    seen = 1 - whole + share * wave
    curve = seen * (1 - seen) * (1.0, 1 - 2 * seen)[number]
    found = at_angles(bends(pixels, WAVE)[number, 0], ANGLE)
    off = _beside(found, wave) - _beside(curve, wave)
    assert np.std(off) < 0.02 * np.std(_beside(curve, wave))  # the corners of the wave have more than M harmonics


def test_a_smeared_pixel_is_bent_after_it_is_smeared(lagging):
    """Oracle: a Gaussian mean of the exponentials over angles, then squared."""
    width = 0.05
    weight = np.exp(-0.5 * (np.minimum(ANGLE, TURN - ANGLE) / width) ** 2)
    smeared = np.fft.irfft(np.fft.rfft(lagging) * np.fft.rfft(weight / weight.sum()), n=N)
    ones = np.ones((1, M + 1), complex)
    pixels = PixelPowers(squares=ones, cubes=ones, askew=0 * ones, smear=np.array([np.exp(-(width**2) / 2)]))
    found = at_angles(bends(pixels, WAVE)[0, 0], ANGLE)
    np.testing.assert_allclose(found, smeared * (1 - smeared), atol=1e-3)


def test_the_mean_of_a_bent_pixel_lies_on_the_curve():
    """Oracle: by hand; a pixel that always shows a quarter gains 3/16 of b, and half of that of c."""
    ones = np.ones((1, 2), complex)
    pixels = PixelPowers(squares=ones, cubes=ones, askew=0 * ones, smear=np.ones(1))
    found = bends(pixels, np.array([0.25, 0], complex))
    np.testing.assert_allclose(found[:, 0], [[3 / 16, 0], [3 / 32, 0]], atol=1e-15)


def test_fewer_rows_and_harmonics_are_the_first_of_all():
    """Oracle: slices by numpy."""
    numbers = np.random.default_rng(1).normal(size=(3, 4, 9)).astype(complex)
    pixels = PixelPowers(squares=numbers[0], cubes=numbers[1], askew=numbers[2], smear=np.linspace(0.9, 1, 4))
    some = pixels.some(slice(None, None, 2), n_harmonics=5)
    np.testing.assert_array_equal(some.squares, numbers[0, ::2, :6])
    np.testing.assert_array_equal(some.smear, pixels.smear[::2])
    assert replace(pixels).some().cubes.shape == (4, 9)
