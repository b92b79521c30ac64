"""Compressed row sums against the frames that they were made of."""

import numpy as np
import pytest

from irtiming.estimate.harmonic_data import basis, compress, packed
from irtiming.physics.wheel_harmonics import at_angles


@pytest.fixture(scope="module")
def frames():
    """Wheel angles, unevenly spread, and values of five rows."""
    rng = np.random.default_rng(4)
    theta = 0.3 + 0.622 * np.delete(np.arange(300), rng.choice(300, 40, replace=False))
    return theta, 1e4 + 300 * np.cos(2 * theta)[:, None] * np.arange(1, 6) + rng.normal(0, 10, (theta.size, 5))


def test_basis_is_one_cosines_and_sines():
    """Oracle: numpy's cos and sin; doubling powers loses no digit that counts, up to order 300."""
    theta = np.linspace(-40, 700, 57)
    found = basis(theta, n_harmonics=300)
    order = np.arange(301)[:, None]
    assert found.shape == (601, 57)
    np.testing.assert_allclose(found[:301], np.cos(order * theta), atol=1e-10)
    np.testing.assert_allclose(found[301:], np.sin(order[1:] * theta), atol=1e-10)


@pytest.mark.parametrize("n", [0, 1, 2, 3, 8, 9])
def test_basis_has_as_many_rows_as_asked_for(n):
    """Oracle: 2 M + 1 functions for any M, also those beside a power of two."""
    np.testing.assert_allclose(
        basis(np.array([0.4]), n_harmonics=n)[:, 0],
        [*np.cos(0.4 * np.arange(n + 1)), *np.sin(0.4 * np.arange(1, n + 1))],
    )


def test_packed_coefficients_give_the_values():
    """Oracle: Re sum F_m exp(i m theta)."""
    rng = np.random.default_rng(2)
    harmonics = rng.normal(size=(3, 9)) + 1j * rng.normal(size=(3, 9))
    theta = rng.uniform(0, 9, 20)
    np.testing.assert_allclose(packed(harmonics) @ basis(theta, n_harmonics=8), at_angles(harmonics, theta), atol=1e-12)


def test_moments_are_the_sums_over_the_frames(frames):
    """Oracle: B B^T, B d and d d written out over all frames, means taken off."""
    theta, values = frames
    data = compress(theta, values, n_harmonics=24)
    waves = basis(theta, n_harmonics=24)
    waves, centred = waves - waves.mean(axis=1, keepdims=True), values - values.mean(axis=0)
    np.testing.assert_allclose(data.gram, waves @ waves.T, atol=1e-9)
    np.testing.assert_allclose(data.moment, (waves @ centred).T, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(data.power, np.sum(centred**2, axis=0), rtol=1e-12)
    assert data.n_frames == theta.size


def test_sum_of_squares_of_any_model_is_that_of_the_frames(frames):
    """Oracle: residuals of gain, offset and a periodic model, frame by frame, with numpy's own least squares for the two."""
    theta, values = frames
    data = compress(theta, values, n_harmonics=24)
    rng = np.random.default_rng(8)
    shape = rng.normal(size=25) + 1j * rng.normal(size=25)
    model, coefficients = at_angles(shape, theta), packed(shape)
    for row in range(5):
        design = np.stack([np.ones_like(model), model], axis=1)
        left = values[:, row] - design @ np.linalg.lstsq(design, values[:, row], rcond=None)[0]
        along, norm = coefficients @ data.moment[row], coefficients @ data.gram @ coefficients
        assert data.power[row] - along**2 / norm == pytest.approx(left @ left, rel=1e-9)


@pytest.mark.parametrize("n_frames", [40, 49, 50, 260])
@pytest.mark.parametrize("n_harmonics", [24, 9])
def test_plain_least_squares_are_those_of_the_frames(frames, n_frames, n_harmonics):
    """Oracle: residuals of a periodic model, frame by frame, means taken off; 49 waves are more than those, or fewer."""
    theta, values = (one[:n_frames] for one in frames)
    data = compress(theta, values, n_harmonics=24).lowest(n_harmonics).some_rows(slice(1, 4))
    rng = np.random.default_rng(8)
    shape = 300 * (rng.normal(size=n_harmonics + 1) + 1j * rng.normal(size=n_harmonics + 1))
    model, white = at_angles(shape, theta), data.white
    off = values[:, 1:4] - values[:, 1:4].mean(axis=0) - (model - model.mean())[:, None]
    found = white.rest + np.sum((white.root @ packed(shape) - white.target) ** 2, axis=1)
    np.testing.assert_allclose(found, np.sum(off**2, axis=0), rtol=1e-9)
    assert white.root.shape[0] <= n_frames
    assert white.rest.min() > 0


def test_fewer_harmonics_are_those_of_the_first(frames):
    """Oracle: the frames compressed with fewer from the start."""
    theta, values = frames
    few, lowest = compress(theta, values, n_harmonics=7), compress(theta, values, n_harmonics=24).lowest(7)
    np.testing.assert_allclose(lowest.gram, few.gram, atol=1e-9)
    np.testing.assert_allclose(lowest.moment, few.moment, atol=1e-6)
    np.testing.assert_array_equal(lowest.power, few.power)


def test_a_constant_on_all_values_is_forgotten(frames):
    """Oracle: offsets are free, so another one is the same data."""
    theta, values = frames
    one, other = compress(theta, values, n_harmonics=9), compress(theta, values + 777.0, n_harmonics=9)
    np.testing.assert_allclose(one.moment, other.moment, atol=1e-6)
    np.testing.assert_allclose(one.power, other.power, rtol=1e-10)
    assert abs(one.gram[0]).max() < 1e-9
