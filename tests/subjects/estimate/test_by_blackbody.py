"""Recordings by the blackbody they show, as tables."""

import pytest

from irtiming.estimate import by_blackbody


@pytest.mark.parametrize(
    ("kelvin", "is_colder", "groups"),
    [
        ([288.1, 288.2, 303.0], [True, True, False], [[0, 1], [2]]),
        ([303.0, 288.1, 303.4, 288.0], [False, True, False, True], [[0, 2], [1, 3]]),
        ([None, None], [True, True], [[0, 1]]),
        ([None, None], [True, False], [[0], [1]]),
        ([None, 300.0], [False, False], [[0], [1]]),
        ([296.0, 296.5], [True, False], [[0], [1]]),
        ([300.0, 301.5], [False, False], [[0], [1]]),
    ],
)
def test_groups_share_temperature_and_sign(kelvin, is_colder, groups):
    """Oracle: the groups by hand: closer than 1 K, and colder or warmer than the wheel alike."""
    assert by_blackbody.groups(kelvin, is_colder=is_colder) == groups
