"""The period of a grid of stamps, determined by the light as well: it follows the wheel equally late in all parts of a run.

A few hundred arrivals tell where the middle of their grid lies much better than how fast it runs; the light in each quarter of
the run tells that again, by the wheel. Both are put together by their uncertainties, and the grid is turned about its middle:
the delay, which is an average over the run, stays where it was. Where the light comes at a larger wheel angle than elsewhere,
the grid is too late.
"""

from dataclasses import replace

import numpy as np

from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.reduced import ReducedRecording
from irtiming.reduce.steadiness import lateness

_OF_SPREAD = 12**0.5
"""Of evenly spread points: u of the rise of a line from end to end, over u of its middle."""


def refined(reduced: ReducedRecording) -> ReducedRecording:
    """The same with events whose period agrees with the light; as it is where there is no grid, or the run is too short to tell.

    Parameters
    ----------
    reduced
        With its sums.
    """
    events, ticks = reduced.events, reduced.trigger_ticks
    if events is None or events.u_grid_s == 0 or ticks.size < 2:
        return reduced
    light = reduced.row_sums.row_sum_dn.sum(axis=1) if reduced.pixels is None else reduced.pixels.pixel_sum
    late = lateness(light, wheel_angle_rad(0.0, reduced.track, at_ticks=ticks))
    if late is None:
        return reduced
    first = np.array([*late.first_frame, ticks.size]) / ticks.size
    place = (first[:-1] + first[1:]) / 2 - 0.5
    late_s, u_s = (
        late.angle_rad / reduced.track.angular_frequency_rad_per_s,
        late.u_rad / reduced.track.angular_frequency_rad_per_s,
    )
    weight = u_s**-2.0
    about = place - float(weight @ place) / float(weight.sum())
    known = float(weight @ about**2)
    rise_s = -float((weight * about) @ late_s) / (known + (_OF_SPREAD * events.u_grid_s) ** -2)
    along = (ticks - ticks[0]) / max(1, int(ticks[-1] - ticks[0])) - 0.5
    turned = np.rint(rise_s * along * reduced.track.clock_frequency_hz).astype(np.int64)
    span_s = float(ticks[-1] - ticks[0]) / reduced.track.clock_frequency_hz
    period_s = events.period_s * (1 + rise_s / span_s)
    rate = None if events.relative_rate is None else (1 + events.relative_rate) / (1 + rise_s / span_s) - 1
    return replace(reduced, trigger_ticks=ticks + turned, events=replace(events, period_s=period_s, relative_rate=rate))
