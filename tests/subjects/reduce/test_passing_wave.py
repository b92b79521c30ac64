"""Whether frames tell the wave with which cutouts pass from all else."""

import numpy as np
import pytest

from irtiming.reduce import passing_wave

TURN, N, ORDERS = 2 * np.pi, 200, (1, 2, 3, 4, 6)


@pytest.mark.parametrize(
    ("step", "is_told"),
    [
        (0.0991, True),
        (0.2713, True),
        (0.125, False),
        (0.5, False),
        (1.0, False),
        (1 + 0.25 / N, False),
        (3 + 4 / N, True),
    ],
)
def test_frames_that_visit_the_whole_turn_tell(step, is_told):
    """Oracle: by hand; at eight angles six waves look like two, a quarter of a turn is no turn, and four turns are enough."""
    angle = TURN * step * np.arange(N)
    assert passing_wave.is_told(angle, [np.arange(N)], orders=ORDERS) == is_told


def test_each_part_must_tell():
    """Oracle: by hand; the wheel stands still in the second half."""
    angle = TURN * 0.0991 * np.minimum(np.arange(N), N // 2)
    assert passing_wave.is_told(angle, [np.arange(N // 2)], orders=ORDERS)
    assert not passing_wave.is_told(angle, np.array_split(np.arange(N), 2), orders=ORDERS)


def test_the_passing_wave_stands_in_its_place():
    """Oracle: by hand; two waves a turn."""
    angle = np.array([0.0, TURN / 8, TURN / 4])
    found = passing_wave.waves(angle, ORDERS)[:, passing_wave.place(ORDERS)]
    np.testing.assert_allclose(found, [[1, 0], [0, 1], [-1, 0]], atol=1e-12)
    third = passing_wave.waves(angle, ORDERS)[:, passing_wave.place(ORDERS, order=3)]
    np.testing.assert_array_equal(third, np.stack([np.cos(3 * angle), np.sin(3 * angle)], axis=1))
