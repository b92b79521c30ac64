"""The wheel as its timestamps show it: speed over time, irregularity of its slots, their orders and ripple."""

from typing import TYPE_CHECKING

import numpy as np

from irtiming.physics import slot_orders
from irtiming.physics.wheel import TURN
from irtiming.records.analysis import Analysis
from irtiming.records.arrays import Array, Mask
from irtiming.records.wheel_calibration import SlotsAtSpeed, SpeedRipple, WheelCalibration
from irtiming.records.wheel_track import WheelTrack
from irtiming.report import sheet
from irtiming.report.blocks import Panel, Section, Table
from irtiming.report.language import decimal, heads, t, with_unit
from irtiming.report.rounding import in_unit, significant

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PER_MILLION = 1e6
_LEAST_MRAD = 1e-6
_LARGEST = 6
_RARE = 0.01
_NOT_SEPARABLE = (
    "All recordings have one wheel speed: a ripple of the speed that repeats every turn cannot be separated from the slots "
    "and is in "
    "their angles. Add recordings at another speed."
)


def section(analysis: Analysis) -> Section:
    """Figures; tables where the slots were learned."""
    wheel = analysis.wheel
    rate = Panel(
        title=t("Speed of the wheel"),
        caption=t(
            "Mean rate of each turn, from the control slots’ timestamps, relative to the nominal one. Wheel angles "
            "are interpolated between the slots, so that slow wander does no harm."
        ),
        svg=sheet.svg(speed(analysis), title=t("Speed of the wheel over time")),
    )
    irregular = Panel(
        title=t("Irregularity of the control slots"),
        caption=slots_caption(wheel),
        svg=sheet.svg(slots(analysis), title=t("Deviation of the control slots, and its orders")),
    )
    tables = () if wheel is None else (speeds(wheel), orders(wheel))
    return Section(title=t("What the wheel did"), blocks=(rate, irregular, *tables))


def slots_caption(wheel: WheelCalibration | None) -> str:
    """What the figure of the slots shows."""
    if wheel is None:
        return t("Too few turns were recorded to learn the slots: they are taken as equal.")
    known = t(
        "Above: angle of each slot minus its regular place, from all recordings together. The default method "
        "corrects for it, the published one takes the slots as equal. Below: the same as waves around the wheel; "
        "order 1 is eccentricity. "
    )
    if wheel.ripple is None:
        return known + (
            t(
                "A speed ripple that repeats every turn is in it: no order can be separated from such a ripple at a "
                "single wheel speed, the low ones least. Recordings at another speed separate them."
            )
        )
    orange = t(
        "Orange: speed ripple that repeats every turn, separated from the slots by its fall with the square of the speed, at "
        "the slowest speed; pale where an order by itself may be chance. "
    )
    return known + orange + _as_a_whole(wheel.ripple)


def speed(analysis: Analysis) -> "Figure":
    """Mean speed of each turn of each recording, relative to the nominal one."""
    recordings = analysis.recordings
    names = sheet.run_names(
        [recording.trigger_delay_time_set_s for recording in recordings],
        [recording.rotation_speed_hz for recording in recordings],
    )
    with sheet.style():
        drawn = sheet.figure(height_in=2.6)
        axes = drawn.add_subplot()
        named: set[str] = set()
        for recording, name, hue in zip(recordings, names, sheet.colours(names), strict=True):
            middle_s, rate_hz = turn_rates(recording.track)
            deviation = _PER_MILLION * (rate_hz / recording.rotation_speed_hz - 1)
            label = None if name in named else name
            named.add(name)
            axes.plot(middle_s, deviation, color=hue, linewidth=0.9, marker=".", markersize=3, label=label)
        sheet.zero_line(axes)
        axes.set_xlabel(t("time after the first control slot of the recording (s)"))
        axes.set_ylabel(t("turn rate − nominal\n(10⁻⁶ of nominal)"))
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return drawn


def summary(wheel: WheelCalibration) -> Table:
    """What the slots, gates and edges are."""
    n_slots = wheel.slot_deviation_rad.size
    rms, u_slot = float(np.std(wheel.slot_deviation_rad)), slot_orders.u_slot_rad(wheel.order_variance_rad2, n_slots)
    slowest_hz = wheel.speeds[0].rotation_speed_hz
    rows = [
        (
            t("slots' deviations, rms"),
            _mrad(rms),
            t("{rms:.2f} µs at {speed:.3g} Hz", rms=1e6 * rms / (TURN * slowest_hz), speed=slowest_hz),
        ),
        (
            t("standard uncertainty of each slot"),
            _mrad(u_slot),
            t("{time:.2f} µs", time=1e6 * u_slot / (TURN * slowest_hz)),
        ),
        (
            t("closure: mean of the deviations"),
            t("{mean:.3f} nrad", mean=1e9 * abs(float(wheel.slot_deviation_rad.mean()))),
            t("each turn is made 360°"),
        ),
        (t("gate separation Δβ"), *_value_and_u(wheel.gate_separation_rad, wheel.u_gate_separation_rad)),
    ]
    if wheel.application_edges_rad is not None and wheel.u_application_edges_rad is not None:
        both = zip("₀₁₂₃", wheel.application_edges_rad, wheel.u_application_edges_rad, strict=True)
        rows += [
            (
                t("application edge α{i}", i=i),
                *((_mrad(angle), t("by definition")) if i == "₀" else _value_and_u(angle, u)),
            )
            for i, angle, u in both
        ]
    return Table(title=t("Wheel"), columns=heads("quantity", "value", ""), align="lrl", rows=tuple(rows))


def speeds(wheel: WheelCalibration) -> Table:
    """Which recordings it rests on."""
    rows = tuple(
        (
            t("{speed:.4g} Hz", speed=one.rotation_speed_hz),
            str(one.n_turns),
            _mrad(float(np.std(one.deviation_rad))),
            with_unit(
                significant(1e6 * slot_orders.u_slot_rad(one.order_variance_rad2, one.deviation_rad.size)), "µrad"
            ),
        )
        for one in wheel.speeds
    )
    return Table(
        title=t("Slots as they appear at each speed"),
        columns=heads("speed", "turns", "rms deviation", "u of each slot"),
        align="rrrr",
        rows=rows,
        note="" if wheel.ripple is not None else t(_NOT_SEPARABLE),
    )


def orders(wheel: WheelCalibration) -> Table:
    """The largest orders of the deviations, and the ripple of each where it is known."""
    n_slots = wheel.slot_deviation_rad.size
    amplitude = slot_orders.amplitude_rad(wheel.slot_deviation_rad)
    phase = slot_orders.phase_rad(wheel.slot_deviation_rad)
    u = slot_orders.u_amplitude_rad(wheel.order_variance_rad2, n_slots)
    ripple = None if wheel.ripple is None else slot_orders.amplitude_rad(wheel.ripple.deviation_rad)
    largest = amplitude if ripple is None else np.maximum(amplitude, ripple)
    chosen = sorted((1 + np.argsort(largest[1:])[::-1][:_LARGEST]).tolist())
    rows = tuple(
        (str(k), _with_u(float(amplitude[k]), float(u[k])), decimal(f"{np.degrees(phase[k]):.0f}°"), _ripple(wheel, k))
        for k in chosen
    )
    note = t("The largest of {n} orders; order k has k waves to a turn.", n=amplitude.size - 1)
    if wheel.ripple is not None:
        note += t(
            " Ripple: of the wheel's angle, at {speed:.3g} Hz; it falls with the square of the speed. ",
            speed=wheel.ripple.reference_speed_hz,
        ) + _as_a_whole(wheel.ripple)
    return Table(
        title=t("Deviations by order"),
        columns=heads("order k", "amplitude (µrad)", "phase", "speed ripple (µrad)"),
        align="rrrl",
        rows=rows,
        note=note,
    )


def ripple_is_clear(ripple: SpeedRipple) -> Mask:
    """Whether chance would make so large a ripple in any order with less than 1 % probability; shape (slots // 2 + 1,)."""
    return np.asarray(ripple.order_chance * (ripple.order_chance.size - 1) < _RARE)


def _as_a_whole(ripple: SpeedRipple) -> str:
    """Whether there is a ripple, which all orders together may show where none of them does by itself."""
    is_there, stands_out = ripple.chance < _RARE, bool(ripple_is_clear(ripple)[1:].any())
    if is_there:
        verdict = (
            t("there is a ripple, and orders that are not marked are part of it.")
            if stands_out
            else t("there is a ripple, although no order by itself stands out of the noise.")
        )
    else:
        verdict = t("single orders stand out of the noise only.") if stands_out else t("no ripple is found.")
    chance = t(
        "Noise alone would make all orders together as large with a probability of {chance:.1g}: ", chance=ripple.chance
    )
    return chance + verdict


def _ripple(wheel: WheelCalibration, order: int) -> str:
    if wheel.ripple is None:
        return t("not separable")
    n_slots = wheel.slot_deviation_rad.size
    amplitude = float(slot_orders.amplitude_rad(wheel.ripple.deviation_rad)[order])
    u = float(slot_orders.u_amplitude_rad(wheel.ripple.order_variance_rad2, n_slots)[order])
    return _with_u(amplitude, u) + ("" if ripple_is_clear(wheel.ripple)[order] else t(" (by itself may be chance)"))


def _mrad(angle_rad: float) -> str:
    return t("{angle:.4f} mrad", angle=1e3 * angle_rad)


def _value_and_u(angle_rad: float, u_rad: float) -> tuple[str, str]:
    """Both to the second digit of the uncertainty; a dash for none."""
    if u_rad <= 0:
        return _mrad(angle_rad), "–"
    return with_unit(in_unit(angle_rad, u_rad, unit_s=1e-3), "mrad"), f"± {with_unit(significant(1e3 * u_rad), 'mrad')}"


def _with_u(angle_rad: float, u_rad: float) -> str:
    return f"{in_unit(angle_rad, u_rad, unit_s=1e-6)} ± {significant(1e6 * u_rad)}"


def turn_rates(track: WheelTrack) -> tuple[Array, Array]:
    """Time of the middle of each whole turn, s after the first control slot, and its mean rate, Hz; shapes (n_turn,)."""
    known = np.isfinite(track.edge_angle_rad)
    angle = track.edge_angle_rad[known]
    time_s = (track.edge_ticks[known] - track.edge_ticks[0]) / track.clock_frequency_hz
    marks = np.arange(angle[0], angle[-1], TURN)
    passed = np.interp(marks, angle, time_s)
    return (passed[1:] + passed[:-1]) / 2, 1 / np.diff(passed)


def slots(analysis: Analysis) -> "Figure":
    """Slots of all recordings together; those of the first one where nothing was learned."""
    return calibration(analysis.wheel or _of_track(analysis.recordings[0].track))


def calibration(wheel: WheelCalibration) -> "Figure":
    """Deviation of each control slot from its regular place, and how it spreads over the orders of the wheel."""
    with sheet.style():
        drawn = sheet.figure(height_in=5.2)
        deviations, spectrum = drawn.subplots(2, 1, height_ratios=(1.2, 1))
        _deviations(deviations, wheel)
        _orders(spectrum, wheel)
    return drawn


def _deviations(axes: "Axes", wheel: WheelCalibration) -> None:
    deviation, slot = wheel.slot_deviation_rad, np.arange(wheel.slot_deviation_rad.size)
    u = slot_orders.u_slot_rad(wheel.order_variance_rad2, slot.size)
    slowest_hz = wheel.speeds[0].rotation_speed_hz
    sheet.zero_line(axes)
    axes.vlines(slot, 0, 1e3 * deviation, color=sheet.BLUE, linewidth=2.2, alpha=0.35)
    axes.errorbar(
        slot,
        1e3 * deviation,
        yerr=1e3 * u,
        fmt=".",
        color=sheet.BLUE,
        ecolor=sheet.RED,
        elinewidth=1.2,
        markersize=4,
        label=t("slots with standard uncertainty")
        if wheel.ripple is not None
        else t("slots and ripple, with standard uncertainty"),
    )
    if wheel.ripple is not None:
        axes.plot(
            slot, 1e3 * wheel.ripple.deviation_rad, color=sheet.ORANGE, linewidth=1.3,
            label=t("what the ripple adds at {speed:.3g} Hz, taken off", speed=wheel.ripple.reference_speed_hz),
        )  # fmt: skip
    axes.set_xlim(-1.5, slot.size + 0.5)
    axes.set_xlabel(t("control slot, slot 0 in register with edge 0 (1)"))
    axes.set_ylabel(t("deviation (mrad)"))
    times = axes.twinx()
    times.set_ylim(*(1e3 * limit / (TURN * slowest_hz) for limit in axes.get_ylim()))
    times.grid(visible=False)
    times.spines["right"].set_visible(True)
    times.set_ylabel(t("at {speed:.3g} Hz (µs)", speed=slowest_hz))
    axes.legend(loc="upper right", ncols=2, bbox_to_anchor=(1.0, 1.17))


def _orders(axes: "Axes", wheel: WheelCalibration) -> None:
    n_slots = wheel.slot_deviation_rad.size
    order = np.arange(1, n_slots // 2 + 1)
    amplitude = 1e3 * slot_orders.amplitude_rad(wheel.slot_deviation_rad)[1:]
    u = 1e3 * slot_orders.u_amplitude_rad(wheel.order_variance_rad2, n_slots)[1:]
    known = [values[values > 0].min() for values in (amplitude, u) if np.any(values > 0)]
    floor = 0.5 * max(min(known, default=_LEAST_MRAD), _LEAST_MRAD)
    axes.vlines(order, floor, np.maximum(amplitude, floor), color=sheet.BLUE, linewidth=2.2, alpha=0.35)
    axes.plot(order, amplitude, ".", color=sheet.BLUE, markersize=4, label=t("slots"))
    axes.plot(order, u, color=sheet.RED, linewidth=1.1, label=t("standard uncertainty"))
    if wheel.ripple is not None:
        ripple = 1e3 * slot_orders.amplitude_rad(wheel.ripple.deviation_rad)[1:]
        clear = ripple_is_clear(wheel.ripple)[1:]
        axes.plot(
            order[~clear],
            ripple[~clear],
            "x",
            color=sheet.ORANGE,
            alpha=0.35,
            markersize=4,
            label=t("ripple or chance"),
        )
        axes.plot(order[clear], ripple[clear], "x", color=sheet.ORANGE, markersize=6, label=t("ripple"))
    axes.set_yscale("log")
    axes.set_ylim(bottom=floor)
    axes.set_xlim(0.2, order[-1] + 0.8)
    axes.set_xlabel(t("order: waves to a turn (1)"))
    axes.set_ylabel(t("amplitude (mrad)"))
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
