"""From the angle between the two light gates to the angle zero of the wheel (Schatz 2023, 2.5, figure 4a)."""

from math import atan, atan2, pi

from irtiming.errors import GeometryError
from irtiming.records.rig import LightGates
from irtiming.records.wheel_geometry import GateAngles


def gate_angles(gate_separation_rad: float, gates: LightGates) -> GateAngles:
    """Angles of both gates from their separation dbeta = atan((d - x) / h) + atan((d + x) / (h - dh)), solved for h by Newton.

    Parameters
    ----------
    gate_separation_rad
        dbeta, from the timestamps, rad.
    gates
        d and dh, from a caliper, and the lateral offset x, 0 where it is not stated.

    Raises
    ------
    GeometryError
        If no height below the axle gives this separation, or the beams do not lie on both sides of the axle.
    """
    d, dh = gates.half_separation_m.value, gates.height_difference_m.value
    x = 0.0 if gates.lateral_offset_m is None else gates.lateral_offset_m.value
    if not abs(x) < d:
        raise GeometryError(
            f"the middle between the beams lies {1e3 * x:.3f} mm beside the axle and each beam d = {1e3 * d:.3f} mm from it: "
            "both lie on one side of the axle; correct [beams] lateral_offset_mm"
        )
    left, right = d - x, d + x
    if not 0 < gate_separation_rad < pi:
        raise GeometryError(
            f"the timestamps put the light gates {gate_separation_rad:.4f} rad apart, which must lie between 0 and pi; "
            "correct [beams] whole_slots_between"
        )
    lowest = max(dh, 0.0)
    if not gate_separation_rad < atan2(left, lowest) + atan2(right, lowest - dh):
        raise GeometryError(
            f"gates {gate_separation_rad:.4f} rad apart with d = {1e3 * d:.3f} mm and dh = {1e3 * dh:.3f} mm would lie "
            f"less than {1e3 * lowest:.3f} mm below the axle, which they cannot; "
            "correct [beams] half_separation_mm, height_difference_mm or whole_slots_between"
        )
    h = lowest  # left of the root of a falling convex function: Newton's steps never overshoot
    for _ in range(100):
        excess = atan2(left, h) + atan2(right, h - dh) - gate_separation_rad
        step = excess / (left / (h * h + left * left) + right / ((h - dh) ** 2 + right * right))
        h += step
        if abs(step) < 1e-15 * max(1.0, abs(h)):
            break
    near, far = h * h + left * left, (h - dh) ** 2 + right * right
    h_per_separation = -1 / (left / near + right / far)
    h_per_d = -(h / near + (h - dh) / far) * h_per_separation
    h_per_dh = -(right / far) * h_per_separation
    h_per_x = -((h - dh) / far - h / near) * h_per_separation
    beta_per_h = -left / near
    return GateAngles(
        application_rad=atan(left / h),
        control_rad=atan(right / (h - dh)),
        height_m=h,
        control_height_m=h - dh,
        sensitivity=(beta_per_h * h_per_separation, h / near + beta_per_h * h_per_d, beta_per_h * h_per_dh),
        per_lateral_offset=-h / near + beta_per_h * h_per_x,
    )


def refuse_other_slots(gate_separation_rad: float, gates: LightGates, *, control_slots: int) -> None:
    """Nothing, if the height by a ruler, where there is one, fits the whole slots between the gates.

    One slot more or less moves the height by some millimetres, so that a ruler tells which number is right.

    Parameters
    ----------
    gate_separation_rad
        dbeta with the number of whole slots that rig.toml states, rad.
    gates
        As measured.
    control_slots
        Of the ring.

    Raises
    ------
    GeometryError
        If another number of whole slots comes nearer to the ruler, with that number.
    """
    ruler = gates.height_m
    if ruler is None:
        return
    between, pitch = gates.whole_slots_between, 2 * pi / control_slots
    heights = {between: gate_angles(gate_separation_rad, gates).height_m}
    for number in range(control_slots // 2):
        try:
            heights[number] = gate_angles(gate_separation_rad + (number - between) * pitch, gates).height_m
        except GeometryError:
            continue
    best = min(heights, key=lambda number: abs(heights[number] - ruler))
    if best != between:
        raise GeometryError(
            f"[beams] whole_slots_between = {between} puts the application beam {1e3 * heights[between]:.1f} mm below the axle, "
            f"the ruler says height_mm = {1e3 * ruler:g}; whole_slots_between = {best} fits ({1e3 * heights[best]:.1f} mm): "
            "correct it, or the height"
        )
