"""What recordings state of the integration time: by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.errors import EstimationError
from irtiming.estimate import integration_time


def _recording(name, time_s):
    return SimpleNamespace(name=name, integration_time_s=time_s)


@pytest.mark.parametrize("time_s", [None, 250e-6])
def test_what_all_state_is_taken(time_s):
    """Oracle: by hand; nothing where none states it."""
    assert integration_time.common([_recording("a", time_s), _recording("b", time_s)]) == time_s


@pytest.mark.parametrize("other_s", [None, 300e-6])
def test_recordings_that_differ_are_refused(other_s):
    """Oracle: by hand; one that states nothing differs, too."""
    with pytest.raises(EstimationError, match=rf"differ in integration time .*a: 0.00025, b: {other_s} s"):
        integration_time.common([_recording("a", 250e-6), _recording("b", other_s)])


def test_a_search_begins_at_one_sample_and_at_half_an_opening():
    """Oracle: by hand; 500 samples in a turn, an opening of 1.3 rad, 20 rad/s."""
    reduced = SimpleNamespace(samples_per_turn=500, track=SimpleNamespace(angular_frequency_rad_per_s=20.0))
    found = integration_time.starts_s(reduced, SimpleNamespace(opening_angle_rad=1.3))
    assert found == pytest.approx((2 * np.pi / 500 / 20, 0.65 / 20))
