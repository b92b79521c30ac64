"""When wheel speeds tell a window from corners that an edge rounds: by hand."""

from types import SimpleNamespace

import pytest

from irtiming.estimate import timing
from irtiming.estimate.measurands import WINDOW


@pytest.mark.parametrize(
    ("speeds", "names", "is_determined"),
    [
        ((20.0, 20.1, 20.2), (WINDOW,), False),
        ((20.0, 23.0), (WINDOW,), False),
        ((20.0, 40.0, 25.0), (WINDOW,), True),
        ((20.0, 40.0), ("opening_angle",), False),
    ],
)
def test_speeds_tell_a_window_where_they_differ_by_a_fifth(speeds, names, is_determined):
    """Oracle: by hand; speeds as they wander, 15 % apart, twice as fast; and a fit that has no window."""
    fits = [SimpleNamespace(angular_frequency_rad_per_s=speed) for speed in speeds]
    assert timing._window(SimpleNamespace(names=names), fits, stated_s=None).is_determined is is_determined
