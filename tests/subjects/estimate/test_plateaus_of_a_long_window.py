"""Windows in which the wheel turns so far that the opening is never wholly open."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import doubts
from irtiming.physics.wheel import wheel_model

WHEEL = wheel_model(
    tuple(np.radians([0.0, 90.0, 180.0, 272.0])), 0.27, opening_angle_rad=np.radians(75.0), centre_angle_rad=-np.pi / 2
)


@pytest.mark.parametrize(
    ("integration_time_s", "is_doubted"), [(None, False), (3.2e-3, False), (3.0e-3, False), (3.3e-3, True)]
)
def test_a_window_is_too_long_where_with_the_opening_it_is_wider_than_a_blade(integration_time_s, is_doubted):
    """Oracle: by hand; the narrowest blade has 88 degrees, 13 more than the opening: 3.25 ms at 4000 degrees a second."""
    fits = [SimpleNamespace(angular_frequency_rad_per_s=np.radians(one)) for one in (1000.0, 4000.0)]
    found = doubts.of_plateaus(fits, WHEEL, integration_time_s=integration_time_s)
    assert [(one.code, one.severity) for one in found] == [("never-wholly-open", "doubt")] * is_doubted
