"""The wheel calibration as tables: speeds, register and edges, and how the slots' deviations spread over the orders."""

import numpy as np

from irtiming.physics import slot_orders
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Mask
from irtiming.records.wheel_calibration import SpeedRipple, WheelCalibration
from irtiming.report.rounding import in_unit, significant
from irtiming.report.tables import Table

_LARGEST = 6
_RARE = 0.01
_NOT_SEPARABLE = (
    "All recordings have one wheel speed: a ripple of the speed that repeats every turn cannot be told from the slots and is in "
    "their angles. Add recordings at another speed."
)


def blocks(wheel: WheelCalibration | None) -> tuple[Table, ...]:
    """What the certificate shows; nothing where the slots were taken as equal."""
    return () if wheel is None else (speeds(wheel), orders(wheel))


def summary(wheel: WheelCalibration) -> Table:
    """What the slots, gates and edges are."""
    n_slots = wheel.slot_deviation_rad.size
    rms, u_slot = float(np.std(wheel.slot_deviation_rad)), slot_orders.u_slot_rad(wheel.order_variance_rad2, n_slots)
    slowest_hz = wheel.speeds[0].rotation_speed_hz
    rows = [
        ("slots' deviations, rms", _mrad(rms), f"{1e6 * rms / (TURN * slowest_hz):.2f} µs at {slowest_hz:.3g} Hz"),
        ("standard uncertainty of each slot", _mrad(u_slot), f"{1e6 * u_slot / (TURN * slowest_hz):.2f} µs"),
        (
            "closure: mean of the deviations",
            f"{1e9 * abs(float(wheel.slot_deviation_rad.mean())):.3f} nrad",
            "each turn is made 360°",
        ),
        ("gate separation Δβ", _mrad(wheel.gate_separation_rad), f"± {_mrad(wheel.u_gate_separation_rad)}"),
    ]
    if wheel.application_edges_rad is not None and wheel.u_application_edges_rad is not None:
        both = zip("₀₁₂₃", wheel.application_edges_rad, wheel.u_application_edges_rad, strict=True)
        rows += [
            (f"application edge α{i}", _mrad(angle), "by definition" if i == "₀" else f"± {_mrad(u)}")
            for i, angle, u in both
        ]
    return Table(title="Wheel", columns=("quantity", "value", ""), align="lrl", rows=tuple(rows))


def speeds(wheel: WheelCalibration) -> Table:
    """Which recordings it rests on."""
    rows = tuple(
        (
            f"{one.rotation_speed_hz:.4g} Hz",
            str(one.n_turns),
            _mrad(float(np.std(one.deviation_rad))),
            f"{significant(1e6 * slot_orders.u_slot_rad(one.order_variance_rad2, one.deviation_rad.size))} µrad",
        )
        for one in wheel.speeds
    )
    return Table(
        title="Slots as they appear at each speed",
        columns=("speed", "turns", "rms deviation", "u of each slot"),
        align="rrrr",
        rows=rows,
        note="" if wheel.ripple is not None else _NOT_SEPARABLE,
    )


def orders(wheel: WheelCalibration) -> Table:
    """The largest orders of the deviations, and the ripple of each where it can be told."""
    n_slots = wheel.slot_deviation_rad.size
    amplitude = slot_orders.amplitude_rad(wheel.slot_deviation_rad)
    phase = slot_orders.phase_rad(wheel.slot_deviation_rad)
    u = slot_orders.u_amplitude_rad(wheel.order_variance_rad2, n_slots)
    ripple = None if wheel.ripple is None else slot_orders.amplitude_rad(wheel.ripple.deviation_rad)
    largest = amplitude if ripple is None else np.maximum(amplitude, ripple)
    chosen = sorted((1 + np.argsort(largest[1:])[::-1][:_LARGEST]).tolist())
    rows = tuple(
        (str(k), _with_u(float(amplitude[k]), float(u[k])), f"{np.degrees(phase[k]):.0f}°", _ripple(wheel, k))
        for k in chosen
    )
    note = f"The largest of {amplitude.size - 1} orders; order k has k waves to a turn."
    if wheel.ripple is not None:
        note += (
            f" Ripple: of the wheel's angle, at {wheel.ripple.reference_speed_hz:.3g} Hz; it falls with the square of the speed. "
            f"All orders of it together are chance with probability {wheel.ripple.chance:.1g}."
        )
    return Table(
        title="Deviations by order",
        columns=("order", "amplitude (µrad)", "phase", "speed ripple (µrad)"),
        align="rrrl",
        rows=rows,
        note=note,
    )


def ripple_is_seen(ripple: SpeedRipple) -> Mask:
    """Whether chance would make so large a ripple in any order with less than 1 % probability; shape (slots // 2 + 1,)."""
    return np.asarray(ripple.order_chance * (ripple.order_chance.size - 1) < _RARE)


def _ripple(wheel: WheelCalibration, order: int) -> str:
    if wheel.ripple is None:
        return "not separable"
    n_slots = wheel.slot_deviation_rad.size
    amplitude = float(slot_orders.amplitude_rad(wheel.ripple.deviation_rad)[order])
    u = float(slot_orders.u_amplitude_rad(wheel.ripple.order_variance_rad2, n_slots)[order])
    return _with_u(amplitude, u) + ("" if ripple_is_seen(wheel.ripple)[order] else " (may be chance)")


def _mrad(angle_rad: float) -> str:
    return f"{1e3 * angle_rad:.4f} mrad"


def _with_u(angle_rad: float, u_rad: float) -> str:
    return f"{in_unit(angle_rad, u_rad, unit_s=1e-6)} ± {significant(1e6 * u_rad)}"
