"""Neighbours that are alike are of one group: by hand."""

import pytest

from irtiming.estimate.chains import chains


@pytest.mark.parametrize(
    ("order", "groups"),
    [
        ([], []),
        ([0], [[0]]),
        ([3, 0, 2, 1], [[0, 3], [1, 2]]),
        ([1, 3, 2, 0], [[1], [2, 3], [0]]),
    ],
)
def test_each_is_held_against_the_one_before_it_alone(order, groups):
    """Oracle: by hand; of 0, 7, 4 and 1 those alike differ by 3 at most, and 0 and 4 do not, though both are beside 1."""
    speeds = [0, 7, 4, 1]
    assert chains(order, lambda before, now: abs(speeds[before] - speeds[now]) <= 3) == groups


def test_a_chain_may_drift_as_far_as_it_likes():
    """Oracle: by hand; each of 0, 2, 4, 6 is beside the next, and the first is given first."""
    asked = []

    def is_alike(before, now):
        asked.append((before, now))
        return now - before <= 2

    assert chains([0, 2, 4, 6], is_alike) == [[0, 2, 4, 6]]
    assert asked == [(0, 2), (2, 4), (4, 6)]
