"""Residuals of frames: the middle of a plateau, and bands of rows, by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import frame_residuals
from irtiming.estimate.frame_residuals import FrameResiduals

TURN = 2 * np.pi


def _frames(angle, fraction):
    n, n_band = fraction.shape
    return FrameResiduals(
        name="x", omega_rad_per_s=20.0, angle_rad=angle, time=np.linspace(-1, 1, n), number=np.arange(n),
        fraction=fraction, residual=np.zeros((n, n_band)), row=np.zeros(n_band), noise=np.ones(n_band),
    )  # fmt: skip


@pytest.mark.parametrize("middle_rad", [0.3, -1.1])
def test_the_opening_is_open_in_the_middle_of_its_plateau(middle_rad):
    """Oracle: the trapezoid that was drawn about it, twice a turn; frames in any order."""
    angle = np.random.default_rng(1).permutation(TURN * np.arange(500) / 500)
    fraction = np.clip(0.5 + 1.6 * np.cos(2 * (angle - middle_rad)), 0, 1)[:, None]
    frames = _frames(angle, fraction)
    assert frames.open_at_rad == pytest.approx(middle_rad, abs=1e-3)


def test_rows_of_a_band_count_by_their_noise():
    """Oracle: by hand; 24 rows are 12 bands of two, of which the second has three times the noise: 9 parts to one."""
    rows = np.arange(100, 124)
    noise = np.where(rows % 2 == 0, 1.0, 3.0)
    model = np.where(rows % 2 == 0, 10.0, 20.0) + np.zeros((2, 24))
    fit = SimpleNamespace(row_px=rows, noise=noise, model=model, residual=-model)
    fraction, residual, place = frame_residuals._banded(fit)
    np.testing.assert_allclose(fraction, np.full((2, 12), 11.0))
    np.testing.assert_allclose(residual, np.full((2, 12), -11.0))
    np.testing.assert_allclose(place, (rows[::2] + 0.1 - 111.5) / 11.5)


def test_places_of_few_rows_are_counted_in_rows():
    """Oracle: by hand; two rows lie half a row on either side of the middle, and one, divided by nothing, in it."""
    for n, expected in ((1, [0.0]), (2, [-0.5, 0.5])):
        fit = SimpleNamespace(
            row_px=np.arange(100, 100 + n), noise=np.ones(n), model=np.zeros((2, n)), residual=np.zeros((2, n))
        )
        np.testing.assert_allclose(frame_residuals._banded(fit)[2], expected)


def test_noise_is_that_of_neighbours_along_the_wheel_angle():
    """Oracle: the noise that was drawn, of two bands, beside a wave of twenty times its size; frames in any order."""
    random = np.random.default_rng(3)
    angle = random.permutation(TURN * np.arange(4000) / 4000)
    residual = np.array([1e-3, 3e-3]) * (random.normal(size=(4000, 2)) + 20 * np.sin(2 * angle)[:, None])
    found = frame_residuals.with_residual(_frames(angle, np.zeros((4000, 2))), residual)
    np.testing.assert_allclose(found.noise, [1e-3, 3e-3], rtol=0.05)


def test_the_run_begins_one_before_its_middle_and_ends_one_after_it():
    """Oracle: by hand; four triggers of a run of 4000 ticks, one of them after a gap in which a frame was lost."""
    fit = SimpleNamespace(name="run", angular_frequency_rad_per_s=20.0)
    ticks, nothing = np.array([7000, 8000, 9000, 11000]), np.zeros((4, 1))
    made = frame_residuals._made(fit, np.arange(4.0), ticks, fraction=nothing, residual=nothing, row=np.zeros(1))
    np.testing.assert_allclose(made.time, [-1, -0.5, 0, 1])
    assert made.number.tolist() == [0, 1, 2, 4]
