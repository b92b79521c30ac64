"""The wheel as its timestamps show it: speed over time, and the irregularity of its control slots."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from irtiming.physics import slot_orders
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array
from irtiming.records.wheel_calibration import SlotsAtSpeed, WheelCalibration
from irtiming.records.wheel_track import WheelTrack
from irtiming.report import sheet
from irtiming.report.evidence import WheelEvidence
from irtiming.report.wheel_tables import ripple_is_seen

_PER_MILLION = 1e6
_LEAST_MRAD = 1e-6


def speed(evidence: WheelEvidence) -> Figure:
    """Mean speed of each turn of each recording, relative to the nominal one."""
    recordings = evidence.recordings
    names = sheet.run_names(
        [recording.trigger_delay_time_set_s for recording in recordings],
        [recording.rotation_speed_hz for recording in recordings],
    )
    with sheet.style():
        drawn = sheet.figure(height_in=2.6)
        axes = drawn.add_subplot()
        told: set[str] = set()
        for recording, name, hue in zip(recordings, names, sheet.colours(names), strict=True):
            middle_s, rate_hz = turn_rates(recording.track)
            deviation = _PER_MILLION * (rate_hz / recording.rotation_speed_hz - 1)
            label = None if name in told else name
            told.add(name)
            axes.plot(middle_s, deviation, color=hue, linewidth=0.9, marker=".", markersize=3, label=label)
        sheet.zero_line(axes)
        axes.set_xlabel("time after the first control slot of the recording (s)")
        axes.set_ylabel("turn rate − nominal\n(10⁻⁶ of nominal)")
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return drawn


def turn_rates(track: WheelTrack) -> tuple[Array, Array]:
    """Time of the middle of each whole turn, s after the first control slot, and its mean rate, Hz; shapes (n_turn,)."""
    known = np.isfinite(track.edge_angle_rad)
    angle = track.edge_angle_rad[known]
    time_s = (track.edge_ticks[known] - track.edge_ticks[0]) / track.clock_frequency_hz
    marks = np.arange(angle[0], angle[-1], TURN)
    passed = np.interp(marks, angle, time_s)
    return (passed[1:] + passed[:-1]) / 2, 1 / np.diff(passed)


def slots(evidence: WheelEvidence) -> Figure:
    """Slots as all recordings tell them together; those of the first one where nothing was learned."""
    return calibration(evidence.wheel or _of_track(evidence.recordings[0].track))


def calibration(wheel: WheelCalibration) -> Figure:
    """Deviation of each control slot from its regular place, and how it spreads over the orders of the wheel."""
    with sheet.style():
        drawn = sheet.figure(height_in=5.2)
        deviations, spectrum = drawn.subplots(2, 1, height_ratios=(1.2, 1))
        _deviations(deviations, wheel)
        _orders(spectrum, wheel)
    return drawn


def _deviations(axes: Axes, wheel: WheelCalibration) -> None:
    deviation, slot = wheel.slot_deviation_rad, np.arange(wheel.slot_deviation_rad.size)
    u = slot_orders.u_slot_rad(wheel.order_variance_rad2, slot.size)
    slowest_hz = wheel.speeds[0].rotation_speed_hz
    sheet.zero_line(axes)
    axes.vlines(slot, 0, 1e3 * deviation, color=sheet.BLUE, linewidth=2.2, alpha=0.35)
    axes.errorbar(
        slot, 1e3 * deviation, yerr=1e3 * u, fmt=".", color=sheet.BLUE, ecolor=sheet.RED, elinewidth=1.2, markersize=4,
        label="slots with standard uncertainty" if wheel.ripple is not None else "slots and ripple, with standard uncertainty",
    )  # fmt: skip
    if wheel.ripple is not None:
        axes.plot(
            slot, 1e3 * wheel.ripple.deviation_rad, color=sheet.ORANGE, linewidth=1.3,
            label=f"what the ripple adds at {wheel.ripple.reference_speed_hz:.3g} Hz, taken off",
        )  # fmt: skip
    axes.set_xlim(-1.5, slot.size + 0.5)
    axes.set_xlabel("control slot, slot 0 in register with edge 0 (1)")
    axes.set_ylabel("deviation (mrad)")
    times = axes.twinx()
    times.set_ylim(*(1e3 * limit / (TURN * slowest_hz) for limit in axes.get_ylim()))
    times.grid(visible=False)
    times.spines["right"].set_visible(True)
    times.set_ylabel(f"at {slowest_hz:.3g} Hz (µs)")
    axes.legend(loc="upper right", ncols=2, bbox_to_anchor=(1.0, 1.17))


def _orders(axes: Axes, wheel: WheelCalibration) -> None:
    n_slots = wheel.slot_deviation_rad.size
    order = np.arange(1, n_slots // 2 + 1)
    amplitude = 1e3 * slot_orders.amplitude_rad(wheel.slot_deviation_rad)[1:]
    u = 1e3 * slot_orders.u_amplitude_rad(wheel.order_variance_rad2, n_slots)[1:]
    known = [values[values > 0].min() for values in (amplitude, u) if np.any(values > 0)]
    floor = 0.5 * max(min(known, default=_LEAST_MRAD), _LEAST_MRAD)
    axes.vlines(order, floor, np.maximum(amplitude, floor), color=sheet.BLUE, linewidth=2.2, alpha=0.35)
    axes.plot(order, amplitude, ".", color=sheet.BLUE, markersize=4, label="slots")
    axes.plot(order, u, color=sheet.RED, linewidth=1.1, label="standard uncertainty")
    if wheel.ripple is not None:
        ripple = 1e3 * slot_orders.amplitude_rad(wheel.ripple.deviation_rad)[1:]
        seen = ripple_is_seen(wheel.ripple)[1:]
        axes.plot(
            order[~seen], ripple[~seen], "x", color=sheet.ORANGE, alpha=0.35, markersize=4, label="ripple or chance"
        )
        axes.plot(order[seen], ripple[seen], "x", color=sheet.ORANGE, markersize=6, label="ripple")
    axes.set_yscale("log")
    axes.set_ylim(bottom=floor)
    axes.set_xlim(0.2, order[-1] + 0.8)
    axes.set_xlabel("order: waves to a turn (1)")
    axes.set_ylabel("amplitude (mrad)")
    axes.legend(loc="upper right", ncols=4, bbox_to_anchor=(1.0, 1.2))


def _of_track(track: WheelTrack) -> WheelCalibration:
    """What a single track stands on."""
    variance = track.order_variance_rad2
    if variance is None:
        n_orders = track.u_slot_deviation_rad.size // 2 + 1
        variance = np.full(n_orders, float(np.mean(track.u_slot_deviation_rad**2)))
    alone = SlotsAtSpeed(
        rotation_speed_hz=track.angular_frequency_rad_per_s / TURN,
        n_turns=1,
        deviation_rad=track.slot_deviation_rad,
        order_variance_rad2=variance,
    )
    return WheelCalibration(
        slot_deviation_rad=alone.deviation_rad,
        order_variance_rad2=variance,
        ripple=None,
        speeds=(alone,),
        gate_separation_rad=track.gate_separation_rad,
        u_gate_separation_rad=track.u_gate_separation_rad,
    )
