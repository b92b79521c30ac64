"""Stamps of the camera's clock in seconds: by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.reduce.events.numbering import stamps_s


def _stamped(ticks, frequency_hz=50.0):
    return stamps_s(SimpleNamespace(frame_timestamp_ticks=ticks, timestamp_frequency_hz=frequency_hz))


def test_stamps_are_seconds_from_the_first_on():
    """Oracle: by hand; 200 ticks at 50 Hz are 4 s, and a clock may begin at 0."""
    assert _stamped(np.array([100, 300, 310])).tolist() == pytest.approx([0.0, 4.0, 4.2])
    assert _stamped(np.array([0, 25])).tolist() == pytest.approx([0.0, 0.5])


@pytest.mark.parametrize(
    ("ticks", "frequency_hz"), [(None, 50.0), (np.array([100, 300]), None), (np.array([100, 0, 310]), 50.0)]
)
def test_unknown_stamps_are_none(ticks, frequency_hz):
    """Oracle: by hand; no stamps, no frequency, and 0 after another value, which stands for an unknown one."""
    assert _stamped(ticks, frequency_hz) is None
