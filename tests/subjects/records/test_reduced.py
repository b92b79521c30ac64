"""What a reduced recording says of itself: by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.records.reduced import ReducedRecording


def test_the_period_of_triggers_is_that_of_most():
    """Oracle: by hand; every tenth trigger is missing and one comes 5 ticks late, the others are 1 622 016 ticks apart: 33 ms."""
    ticks = 1_622_016 * np.delete(np.arange(30), [9, 19])
    ticks[4] += 5
    one = SimpleNamespace(trigger_ticks=ticks, track=SimpleNamespace(clock_frequency_hz=49_152_000))
    one.trigger_period_ticks = ReducedRecording.trigger_period_ticks.func(one)
    assert one.trigger_period_ticks == 1_622_016
    assert ReducedRecording.trigger_period_s.fget(one) == pytest.approx(33e-3, rel=1e-12)
