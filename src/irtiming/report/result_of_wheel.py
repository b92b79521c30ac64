"""The rig's geometry and the wheel calibration as plain data, for JSON."""

from typing import Any

import numpy as np

from irtiming.physics import slot_orders
from irtiming.records.analysis import Analysis
from irtiming.records.wheel_calibration import WheelCalibration


def geometry(analysis: Analysis) -> dict[str, Any]:
    """Wheel, gates and opening as angles."""
    found = analysis.geometry
    model, gates, name = found.model, found.gates, "opening_angle"
    return {
        "cutout_edges": [float(angle) for angle in model.cutout_edges_rad],
        "cutout_edges_from": found.edges_from,
        "beta_1": gates.application_rad,
        "beta_2": gates.control_rad,
        "gate_height": {"value": gates.height_m, "unit": "m"},
        "camera_roll": found.camera_roll_rad,
        "opening_angle": model.opening_angle_rad,
        "opening_angle_fitted": [fit.estimate.value(name) for fit in analysis.fits if name in fit.estimate],
        "angle_unit": "rad",
    }


def calibration(wheel: WheelCalibration | None) -> dict[str, Any] | None:
    """Slots, orders, ripple and register in radians; None where the slots were taken as equal."""
    if wheel is None:
        return None
    n_slots = wheel.slot_deviation_rad.size
    return {
        "slots_from": list(wheel.names),
        "speeds": [
            {"rotation_speed": one.rotation_speed_hz, "unit": "Hz", "turns": one.n_turns} for one in wheel.speeds
        ],
        "rms_deviation": float(np.std(wheel.slot_deviation_rad)),
        "standard_uncertainty": slot_orders.u_slot_rad(wheel.order_variance_rad2, n_slots),
        "orders": _orders(wheel),
        "ripple": _ripple(wheel),
        "gate_separation": {"value": wheel.gate_separation_rad, "standard_uncertainty": wheel.u_gate_separation_rad},
        "application_edges": _edges(wheel),
        "angle_unit": "rad",
    }


def _orders(wheel: WheelCalibration) -> list[dict[str, Any]]:
    amplitude = slot_orders.amplitude_rad(wheel.slot_deviation_rad)
    phase = slot_orders.phase_rad(wheel.slot_deviation_rad)
    u = slot_orders.u_amplitude_rad(wheel.order_variance_rad2, wheel.slot_deviation_rad.size)
    return [
        {
            "order": order,
            "amplitude": float(amplitude[order]),
            "standard_uncertainty": float(u[order]),
            "phase": float(phase[order]),
            "separable_from_ripple": wheel.ripple is not None,
        }
        for order in range(1, amplitude.size)
    ]


def _ripple(wheel: WheelCalibration) -> dict[str, Any] | str:
    ripple = wheel.ripple
    if ripple is None:
        return "not separable at one speed"
    amplitude = slot_orders.amplitude_rad(ripple.deviation_rad)
    u = slot_orders.u_amplitude_rad(ripple.order_variance_rad2, ripple.deviation_rad.size)
    return {
        "reference_speed": {"value": ripple.reference_speed_hz, "unit": "Hz"},
        "amplitude_by_order": [float(value) for value in amplitude[1:]],
        "standard_uncertainty_by_order": [float(value) for value in u[1:]],
        "chance_by_order": [float(value) for value in ripple.order_chance[1:]],
        "chance": ripple.chance,
    }


def _edges(wheel: WheelCalibration) -> dict[str, Any] | None:
    if wheel.application_edges_rad is None or wheel.u_application_edges_rad is None:
        return None
    return {"value": list(wheel.application_edges_rad), "standard_uncertainty": list(wheel.u_application_edges_rad)}
