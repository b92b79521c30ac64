"""From the angle between the two light gates to the angle zero of the wheel (Schatz 2023, 2.5, figure 4a)."""

from math import atan, atan2, pi

from irtiming.errors import GeometryError
from irtiming.records.rig import LightGates
from irtiming.records.wheel_geometry import GateAngles


def gate_angles(gate_separation_rad: float, gates: LightGates) -> GateAngles:
    """Angles of both gates from their separation dbeta = atan(d / h) + atan(d / (h - dh)), solved for h by Newton.

    Parameters
    ----------
    gate_separation_rad
        dbeta, from the timestamps, rad.
    gates
        d and dh, from a caliper.

    Raises
    ------
    GeometryError
        If no height below the axle gives this separation.
    """
    d, dh = gates.half_separation_m.value, gates.height_difference_m.value
    if not 0 < gate_separation_rad < pi:
        raise GeometryError(
            f"the timestamps put the light gates {gate_separation_rad:.4f} rad apart, which must lie between 0 and pi; "
            "correct [beams] whole_slots_between"
        )
    lowest = max(dh, 0.0)
    if not gate_separation_rad < atan2(d, lowest) + atan2(d, lowest - dh):
        raise GeometryError(
            f"gates {gate_separation_rad:.4f} rad apart with d = {1e3 * d:.3f} mm and dh = {1e3 * dh:.3f} mm would lie "
            f"less than {1e3 * lowest:.3f} mm below the axle, which they cannot; "
            "correct [beams] half_separation_mm, height_difference_mm or whole_slots_between"
        )
    h = lowest  # left of the root of a falling convex function: Newton's steps never overshoot
    for _ in range(100):
        excess = atan2(d, h) + atan2(d, h - dh) - gate_separation_rad
        step = excess / (d / (h * h + d * d) + d / ((h - dh) ** 2 + d * d))
        h += step
        if abs(step) < 1e-15 * max(1.0, abs(h)):
            break
    near, far = h * h + d * d, (h - dh) ** 2 + d * d
    h_per_separation = -1 / (d / near + d / far)
    h_per_d = -(h / near + (h - dh) / far) * h_per_separation
    h_per_dh = -(d / far) * h_per_separation
    beta_per_h = -d / near
    return GateAngles(
        application_rad=atan(d / h),
        control_rad=atan(d / (h - dh)),
        height_m=h,
        sensitivity=(beta_per_h * h_per_separation, h / near + beta_per_h * h_per_d, beta_per_h * h_per_dh),
    )
