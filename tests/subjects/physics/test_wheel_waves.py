"""Orders on which the frames of a pixel are projected: by hand."""

import numpy as np
import pytest

from irtiming.physics import wheel_waves


@pytest.mark.parametrize(
    ("n_angles", "signal"),
    [
        (1000, range(2, 63, 4)), (248, range(2, 63, 4)), (247, range(2, 59, 4)), (100, range(2, 23, 4)),
        (24, [2, 6]), (23, [2]), (8, [2]),
    ],
)  # fmt: skip
def test_signal_is_every_fourth_order_as_far_as_the_angles_carry(n_angles, signal):
    """Oracle: by hand; orders up to a quarter of the angles, and up to 62."""
    assert wheel_waves.signal_orders(n_angles).tolist() == list(signal)


@pytest.mark.parametrize(
    ("n_angles", "quiet"),
    [
        (1000, [480, 481, 483, 484, 485, 487, 488, 489, 491, 492, 493, 495, 496, 497, 499]),
        (24, [8, 9, 11]), (23, [4, 5, 7, 8, 9, 11]), (16, [4, 5, 7]), (8, []),
    ],
)  # fmt: skip
def test_quiet_are_the_highest_orders_without_those_of_the_wheel(n_angles, quiet):
    """Oracle: by hand; below half of the angles, two above the signal at least, not 2, 6, 10 ..., at most 16 of them."""
    found = wheel_waves.quiet_orders(n_angles).tolist()
    assert found[-15:] == quiet
    assert len(found) == (16 if n_angles == 1000 else len(quiet))


def test_each_stretch_has_waves_of_mean_zero():
    """Oracle: by hand; cosines before sines, less their mean over the frames of a stretch."""
    angle, segment = np.array([0.0, 0.3, 1.0, 2.0, 2.1]), np.array([0, 0, 1, 1, 1])
    found = wheel_waves.waves(angle, np.array([2, 6]), segment=segment)
    assert found.shape == (4, 5)
    for row, wave in zip(
        found, (np.cos(2 * angle), np.cos(6 * angle), np.sin(2 * angle), np.sin(6 * angle)), strict=True
    ):
        for k in (0, 1):
            np.testing.assert_allclose(row[segment == k], wave[segment == k] - wave[segment == k].mean(), atol=1e-12)
