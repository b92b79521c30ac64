"""Falling minus rising as a time and an angle, from edge delays that were made of them."""

from dataclasses import dataclass

import numpy as np
import pytest

from irtiming.estimate import joint, shared_numbers, slope_split
from irtiming.records.estimate import EDGE_DELAYS, Estimate

TIME, ANGLE, U = 3e-6, 1.4e-3, 0.2e-6


@dataclass
class _Fit:
    estimate: Estimate
    angular_frequency_rad_per_s: float


def _fits(speeds_hz, *, random=None):
    made = []
    for hz in speeds_hz:
        omega = 2 * np.pi * hz
        half = (TIME + ANGLE / omega) / 2
        noise = np.zeros(4) if random is None else U * random.normal(size=4)
        values = 5e-4 + half * np.array([1, -1, 1, -1]) + noise
        made.append(
            _Fit(Estimate(names=EDGE_DELAYS, units=("s",) * 4, values=values, covariance=U**2 * np.eye(4)), omega)
        )
    return made


def _found(fits):
    models = [joint.parabola(fit.estimate) for fit in fits]
    return slope_split.of(joint.fit(models, [shared_numbers.delay(fits, start=4e-4)]), fits)


def test_time_and_angle_that_made_the_delays_are_found():
    """Oracle: the numbers that made them; u by hand from two differences of u each, at two speeds."""
    found = _found(_fits((3.0, 9.0)))
    assert found.value("falling_rising_time") == pytest.approx(TIME, rel=1e-6)
    assert found.value("falling_rising_angle") == pytest.approx(ANGLE, rel=1e-6)
    slow, fast = 2 * np.pi * 3, 2 * np.pi * 9
    by_speed = np.linalg.inv([[1, 1 / slow], [1, 1 / fast]])
    np.testing.assert_allclose(found.covariance, U**2 * by_speed @ by_speed.T, rtol=1e-6)


def test_pulls_are_standard():
    """Oracle: 200 draws of the noise of the edges' delays."""
    random = np.random.default_rng(2)
    pulls = []
    for _ in range(200):
        found = _found(_fits((3.0, 5.0, 9.0), random=random))
        pulls.append((found.values - [TIME, ANGLE]) / found.standard_uncertainties)
    np.testing.assert_allclose(np.std(pulls, axis=0), 1, atol=0.15)


def test_one_speed_does_not_tell_them_apart():
    """Oracle: two unknowns and one equation."""
    assert _found(_fits((3.0, 3.1))) is None
