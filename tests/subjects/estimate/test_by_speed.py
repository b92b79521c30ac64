"""Recordings by the speed of their wheel, as tables."""

import pytest

from irtiming.estimate import by_speed


@pytest.mark.parametrize(
    ("speeds", "groups"),
    [
        ([3.0, 12.0, 3.001, 8.0], [[0, 2], [3], [1]]),
        ([3.125 * (1 + 1e-7), 3.125 * (1 - 1e-7), 3.125], [[0, 1, 2]]),
        ([19.635, 19.6349, 19.6351], [[0, 1, 2]]),
        ([3.0, 3.02], [[0], [1]]),
        ([3.005, 3.0, 3.01], [[0, 1, 2]]),
        ([7.0], [[0]]),
    ],
)
def test_groups_share_a_speed(speeds, groups):
    """Oracle: by hand; within 0.2 % of a neighbour, wherever a rounding of the numbers has its border; the slowest first."""
    assert by_speed.groups(speeds) == groups
