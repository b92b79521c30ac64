"""Where the wheel is when frames are taken, and was when the frames before them were: a wheel that turns evenly."""

import numpy as np

from irtiming.estimate.pixel_sums import PixelSums

CLOCK_HZ, START, PERIOD = 49_152_000, 10_000_000, 1_638_400


def test_before_the_wheel_was_recorded_it_has_turned_evenly(track_of, reduced_recording):
    """Oracle: by hand; 20 rad/s for one period less, also where no slot had passed yet; one frame is dropped."""
    track = track_of(lambda t: 20.0 * t, start=START, duration_s=2.0)
    ticks = START + PERIOD // 2 + PERIOD * np.arange(40, dtype=np.int64)
    kept = np.arange(40) != 7
    sums = PixelSums(
        reduced=reduced_recording(track, ticks, np.ones(40)),
        wheel=None,
        kept=kept,
        levels=None,
        unit_dn=1.0,
        border_rad=0.0,
    )
    now, before = sums.angle(2e-3), sums.angle(-0.02, is_before=True)
    time_s = (ticks[kept] - START) / CLOCK_HZ
    np.testing.assert_allclose(now[5:] - now[5], 20.0 * (time_s - time_s[5])[5:], atol=1e-5)
    np.testing.assert_allclose(before[1:] - now[1:], -20.0 * (PERIOD / CLOCK_HZ + 0.022), atol=1e-5)
