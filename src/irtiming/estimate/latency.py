"""Latencies of the light gates from edges at several wheel speeds, and of the trigger from one that is led back."""

import math
from collections.abc import Sequence

import numpy as np
from scipy import special

from irtiming.errors import EstimationError
from irtiming.records.arrays import Array, Ticks
from irtiming.records.finding import Finding
from irtiming.records.latency_check import GateRegister, LatencyDifference, LoopBack
from irtiming.records.rig import Latency, Measured
from irtiming.units import counted

_SPEEDS_APART = 1.2
_SIGNIFICANCE = 0.01
_LEAST_BACK = 0.5  # of the triggers: a line loses hardly any, another signal meets few
_BEFORE_S = 10e-6
"""A stamp may be so much earlier than its trigger, where more latency was taken off than there is."""


def over_speeds(
    registers: Sequence[GateRegister], *, line: str, later_than: str, pitch_rad: float
) -> LatencyDifference:
    """By how much later one line is stamped than another: slope of the phase over the wheel's speed.

    Angles of edges, slots and gates are the same at every speed and stay out of it.

    Parameters
    ----------
    registers
        At two speeds or more.
    line, later_than
        What lines these are.
    pitch_rad
        Of the slots: phases are known but for whole ones.

    Raises
    ------
    EstimationError
        If the speeds are not far enough apart.
    """
    speed = np.array([one.wheel_rad_per_s for one in registers])
    if speed.size < 2 or speed.max() < _SPEEDS_APART * speed.min():
        raise EstimationError(
            f"the {line}'s latency wants recordings at two wheel speeds, the fastest at least {_SPEEDS_APART:g} times as fast as "
            "the slowest; twice is good"
        )
    phase = np.array([one.phase_rad.value for one in registers])
    phase = phase[0] + np.mod(phase - phase[0] + pitch_rad / 2, pitch_rad) - pitch_rad / 2
    u = np.array([one.phase_rad.standard_uncertainty for one in registers])
    slope, u_slope, chi_squared = _line(speed, phase, u)
    free = speed.size - 2
    findings: tuple[Finding, ...] = ()
    if free and special.chdtrc(free, chi_squared) < _SIGNIFICANCE:
        u_slope *= math.sqrt(chi_squared / free)
        chi = f"chi squared {chi_squared:.1f} with {counted(free, 'degree')} of freedom"
        what = f"the {line}'s edges do not move in proportion to the speed ({chi})"
        cure = "check the wheel's lock and the gates' fastening; the uncertainty is widened"
        findings = (Finding(code="latency-not-proportional", severity="warning", what=what, cure=cure),)
    return LatencyDifference(
        line=line,
        later_than=later_than,
        difference_s=Measured(slope, u_slope),
        registers=tuple(registers),
        chi_squared=chi_squared,
        degrees_of_freedom=free,
        findings=findings,
    )


def _line(x: Array, y: Array, u: Array) -> tuple[float, float, float]:
    """Slope of a weighted straight line, its standard uncertainty and chi squared."""
    weight = u**-2.0
    from_middle = x - float(weight @ x / weight.sum())
    squares = float(weight @ from_middle**2)
    slope = float((weight * from_middle) @ y) / squares
    left = y - float(weight @ y / weight.sum()) - slope * from_middle
    return slope, squares**-0.5, float(weight @ left**2)


def exchanged(before: GateRegister, after: GateRegister, *, pitch_rad: float, place_u_rad: float) -> LatencyDifference:
    """By how much later the application gate is stamped than the control gate, from a second recording with the gates exchanged.

    The phase is c + omega (L - l) before and c - omega (L - l) after: half of the change is the difference.

    Parameters
    ----------
    before, after
        Registers of the application gate, one with the gates as they will be used, one with them exchanged.
    pitch_rad
        Of the slots.
    place_u_rad
        Standard uncertainty of the angle by which the beams stand elsewhere after the exchange.
    """
    change = before.phase_rad.value - after.phase_rad.value
    change = math.remainder(change, pitch_rad)
    speeds = before.wheel_rad_per_s + after.wheel_rad_per_s
    u = math.hypot(before.phase_rad.standard_uncertainty, after.phase_rad.standard_uncertainty, place_u_rad)
    return LatencyDifference(
        line="application gate",
        later_than="control gate",
        difference_s=Measured(change / speeds, u / speeds),
        registers=(before, after),
        chi_squared=0.0,
        degrees_of_freedom=0,
    )


def of_gates(application: LatencyDifference, *, photodiode: LatencyDifference | None, known: Measured) -> Latency:
    """Latencies of both gates from their difference and one that is known.

    Parameters
    ----------
    application
        Application gate after control gate.
    photodiode
        A fast photodiode after the control gate, None where there was none.
    known
        Latency of the photodiode, or without one that of the application gate, s.

    Returns
    -------
    One gate from ``known``, the other from that one: what the first may be off, both are.
    """
    difference = application.difference_s
    if photodiode is None:
        application_s, control_s = known, _sum(known, difference, sign=-1)
    else:
        control_s = _sum(known, photodiode.difference_s, sign=-1)
        application_s = _sum(control_s, difference, sign=1)
    common_u_s = min(one.standard_uncertainty for one in (application_s, control_s))
    return Latency(application_gate_s=application_s, control_gate_s=control_s, gates_common_u_s=common_u_s)


def _sum(one: Measured, other: Measured, *, sign: int) -> Measured:
    u = math.hypot(one.standard_uncertainty, other.standard_uncertainty)
    return Measured(one.value + sign * other.value, u)


def of_loop(trigger_ticks: Ticks, stamp_ticks: Ticks, *, name: str, line: str, clock_frequency_hz: float) -> LoopBack:
    """How much later than its trigger each edge was stamped that was led back.

    Parameters
    ----------
    trigger_ticks
        As the camera gets them, shape (n_trigger,), in order.
    stamp_ticks
        Of the input, shape (n_stamp,), in order.
    name, line
        Of the recording and the input, for messages.
    clock_frequency_hz
        Of both.

    Raises
    ------
    EstimationError
        If no trigger came back, or fewer than half of them: then another signal is at that input.
    """
    early = round(_BEFORE_S * clock_frequency_hz)
    most = int(np.median(np.diff(trigger_ticks))) - early if trigger_ticks.size > 1 else early
    first = np.searchsorted(stamp_ticks, trigger_ticks - early)
    has = first < stamp_ticks.size
    late = stamp_ticks[first[has]] - trigger_ticks[has]
    late = late[late < most]
    if not late.size:
        raise EstimationError(
            f"{name}: no trigger came back at {line}; lead camera_out to that input, and record it (--spare, or --camera-input)"
        )
    if late.size < _LEAST_BACK * trigger_ticks.size:
        raise EstimationError(
            f"{name}: {late.size} of {trigger_ticks.size} triggers came back at {line}, most must: another signal is at that "
            "input; lead camera_out to it, and record it (--spare, or --camera-input)"
        )
    values, counts = np.unique(late, return_counts=True)
    return LoopBack(
        name=name,
        line=line,
        clock_frequency_hz=clock_frequency_hz,
        mean_s=float(late.mean()) / clock_frequency_hz,
        spread_s=float(late.std()) / clock_frequency_hz,
        lowest_s=float(late.min()) / clock_frequency_hz,
        highest_s=float(late.max()) / clock_frequency_hz,
        counts=tuple(zip(values.tolist(), counts.tolist(), strict=True)),
        n_triggers=int(late.size),
        n_missing=int(trigger_ticks.size - late.size),
    )
