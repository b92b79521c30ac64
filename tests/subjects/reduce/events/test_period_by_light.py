"""The period of a grid of stamps, told by the light."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.records.frame_events import FrameEvents
from irtiming.reduce.events.period import refined

TURN, CLOCK_HZ = 2 * np.pi, 49_152_000


@pytest.mark.parametrize("rise_us", [0.0, 150.0, -90.0])
def test_a_grid_that_runs_too_fast_or_slow_is_turned_about_its_middle(rise_us, track_of, reduced_recording):
    """Oracle: the ticks that the light was made at; noise leaves a few microseconds of slope.

    What the camera's own clock counts from frame to frame is its stamps' and no matter of the light.
    """
    track, random = track_of(), np.random.default_rng(8)
    place = np.linspace(-0.5, 0.5, 400)
    true = np.rint(8_000_000 + 0.0331 * CLOCK_HZ * np.arange(400)).astype(np.int64)
    angle = np.interp(true, track.edge_ticks, track.edge_angle_rad) + 0.01
    light = (
        1000 + 400 * np.cos(2 * angle) + 30 * np.cos(6 * angle) + 20 * np.cos(angle) + 0.4 * random.standard_normal(400)
    )
    told = true + np.rint(rise_us * 1e-6 * CLOCK_HZ * place).astype(np.int64)
    events = FrameEvents(kind="arrival", period_s=0.0331 + rise_us * 1e-6 / 399, deviation_s=np.zeros(400),
                         relative_rate=30e-6, u_grid_s=40e-6)  # fmt: skip
    found = refined(reduced_recording(track, told, light, events=events))
    off_us = 1e6 * (found.trigger_ticks - true) / CLOCK_HZ
    assert np.abs(off_us - off_us.mean()).max() < 8
    assert abs(off_us.mean()) < 1
    assert found.events.period_s == pytest.approx(0.0331, abs=16e-6 / 399)
    by_camera_s = (1 + 30e-6) * events.period_s
    assert (1 + found.events.relative_rate) * found.events.period_s == pytest.approx(by_camera_s, rel=1e-12)
    strobe = reduced_recording(track, told, light, events=replace(events, kind="strobe", u_grid_s=0.0))
    assert refined(strobe) is strobe
