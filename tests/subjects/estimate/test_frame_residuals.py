"""Residuals of frames: the middle of a plateau, and bands of rows, by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import frame_residuals
from irtiming.estimate.frame_residuals import FrameResiduals


@pytest.mark.parametrize("middle_rad", [0.3, -1.1])
def test_the_opening_is_open_in_the_middle_of_its_plateau(middle_rad):
    """Oracle: the trapezoid that was drawn about it, twice a turn; frames in any order."""
    angle = np.random.default_rng(1).permutation(2 * np.pi * np.arange(500) / 500)
    fraction = np.clip(0.5 + 1.6 * np.cos(2 * (angle - middle_rad)), 0, 1)[:, None]
    frames = FrameResiduals(
        name="x", omega_rad_per_s=20.0, angle_rad=angle, time=np.linspace(-1, 1, 500), number=np.arange(500),
        fraction=fraction, residual=np.zeros((500, 1)), row=np.zeros(1), noise=np.ones(1),
    )  # fmt: skip
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
