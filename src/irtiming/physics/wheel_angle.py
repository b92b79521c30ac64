"""Wheel angle at any moment between the first and the last control-slot edge (Schatz 2023, 2.4)."""

import numpy as np

from irtiming.records.arrays import Array, Ticks
from irtiming.records.wheel_track import WheelTrack


def wheel_angle_rad(delay_s: float, track: WheelTrack, *, at_ticks: Array | Ticks, set_s: float = 0.0) -> Array:
    """Unwrapped wheel angle ``delay_s`` after each of the given ticks, rad, same shape.

    Linear between control-slot edges; nan outside them, where the wheel was not recorded.

    Parameters
    ----------
    delay_s
        SI seconds.
    track
        The wheel.
    at_ticks
        Timestamps of triggers, any shape.
    set_s
        Delay that the trigger generator adds, in its own time.
    """
    origin = track.edge_ticks[0]
    set_ticks = set_s * track.clock_frequency_hz / (1 + track.clock_relative_error)
    since = (np.asarray(at_ticks) - origin).astype(float) + delay_s * track.clock_frequency_hz + set_ticks
    edges = (track.edge_ticks - origin).astype(float)
    return np.interp(since, edges, track.edge_angle_rad, left=np.nan, right=np.nan)
