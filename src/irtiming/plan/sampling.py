"""Exact arithmetic of one trigger scheme: its rates, its duration, its sampling order.

Only integers and fractions: two periods that are one tick apart have a different greatest common divisor, and
with it a different number of samples, so nothing here may be rounded.
"""

from fractions import Fraction
from math import lcm

import numpy as np

from irtiming.records.arrays import Ticks
from irtiming.records.trigger_plan import TriggerScheme


def wheel_rate_hz(scheme: TriggerScheme, clock_frequency_hz: int) -> Fraction:
    """Turns of the wheel per second, f / T."""
    return Fraction(clock_frequency_hz, scheme.turn_period_ticks)


def frame_rate_hz(scheme: TriggerScheme, clock_frequency_hz: int) -> Fraction:
    """Frames of the camera per second, f / C."""
    return Fraction(clock_frequency_hz, scheme.camera_period_ticks)


def run_period_ticks(scheme: TriggerScheme) -> int:
    """Ticks until wheel and camera meet again, lcm(T, C) = N C = K T: the length of one run."""
    return lcm(scheme.turn_period_ticks, scheme.camera_period_ticks)


def run_duration_s(scheme: TriggerScheme, clock_frequency_hz: int) -> Fraction:
    """Duration of one run, lcm(T, C) / f."""
    return Fraction(run_period_ticks(scheme), clock_frequency_hz)


def sampling_order(scheme: TriggerScheme) -> Ticks:
    """Sample of the turn that each trigger of a run takes (Schatz 2023, figure 3).

    Returns
    -------
    Shape (N,), a permutation of 0 .. N - 1: trigger n takes sample n K mod N.
    """
    triggers = np.arange(scheme.samples_per_turn, dtype=np.int64)
    return triggers * (scheme.samples_per_frame % scheme.samples_per_turn) % scheme.samples_per_turn


def triggers_to_neighbour(scheme: TriggerScheme) -> int:
    """Smallest m with m C = delta modulo T: m triggers after a sample its right-hand neighbour is taken.

    Notes
    -----
    The inverse of K modulo N; 7 in figure 3 of Schatz 2023. It is 0 where a turn has one sample only.
    """
    return pow(scheme.samples_per_frame, -1, scheme.samples_per_turn)


def nearest_ticks(time_s: Fraction, clock_frequency_hz: int) -> int:
    """Whole number of ticks nearest to an exact time: what the trigger generator can set for a delay."""
    return round(time_s * clock_frequency_hz)
