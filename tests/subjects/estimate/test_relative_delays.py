"""Delays of recordings against those that were set shortest: by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import relative_delays
from irtiming.records.rig import Measured

US = 1e-6


def test_a_delay_is_counted_from_the_mean_of_those_set_shortest_and_lasts_as_long_as_the_clock_makes_it(monkeypatch):
    """Oracle: by hand; two recordings of no delay, 10 and 12 us, one that is set to 1 ms, at 14 us more, of a clock 100 ppm fast.

    Of u each has its own, and the mean of two that of both: (1 + 1) / 4 us^2 of the difference from it, 4 + 1/2 for the third.
    """
    each, covariance = np.array([10.0, 12.0, 14.0]) * US, np.diag([1.0, 1.0, 4.0]) * US**2
    asked = []

    def each_delay(found, setting):
        asked.append((found, setting))
        return each, covariance

    monkeypatch.setattr(relative_delays.joint, "each_delay", each_delay)
    fits = [
        SimpleNamespace(name=name, trigger_delay_time_set_s=set_s)
        for name, set_s in (("a", 2e-3), ("b", 2e-3), ("c", 3e-3))
    ]
    one, two, three = relative_delays.of("fit", fits, clock=Measured(1e-4, 2e-3))
    assert asked == [("fit", [0, 0, 1])]
    assert (one.file, two.file, three.file) == ("a", "b", "c")
    assert (one.nominal_s, three.nominal_s) == (0.0, pytest.approx(1e-3))
    assert (one.value_s, two.value_s) == (pytest.approx(-1 * US), pytest.approx(1 * US))
    assert one.standard_uncertainty_s == pytest.approx(np.sqrt(0.5) * US)
    assert three.value_s == pytest.approx(3 * US + 1e-3 / 1.0001, rel=1e-12)
    assert three.standard_uncertainty_s == pytest.approx(np.hypot(np.sqrt(4.5) * US, 1e-3 * 2e-3))
    assert three.deviation_s == pytest.approx(3 * US * 1.0001)
    assert three.u_deviation_s == pytest.approx(np.sqrt(4.5) * US)
