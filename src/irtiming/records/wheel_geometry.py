"""Wheel, gates and opening as angles, and how well these are known."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeAlias, final

from irtiming.records.finding import Finding
from irtiming.records.rig import Rotation

EdgeAngles: TypeAlias = tuple[float, float, float, float]
"""alpha_0 .. alpha_3, rad."""


@final
@dataclass(frozen=True, kw_only=True)
class WheelModel:
    """Wheel and opening as the formulas need them; symbols as in `physics.wheel`."""

    cutout_edges_rad: EdgeAngles
    gate_angle_rad: float
    opening_angle_rad: float
    centre_angle_rad: float

    @property
    def opening_coordinate_rad(self) -> float:
        """Wheel coordinate alpha of the opening's centre at wheel angle zero: phi_A - phi_M."""
        return self.gate_angle_rad - self.centre_angle_rad


@final
@dataclass(frozen=True, kw_only=True)
class GateAngles:
    """Where the gates are, as angles from the downward vertical.

    ``application_rad`` is beta_1, ``control_rad`` beta_2, ``height_m`` h: the depth of the application gate below the
    axle, ``control_height_m`` h - dh that of the control gate. ``sensitivity`` holds the partial derivatives of beta_1 to
    dbeta (1), d (rad/m) and dh (rad/m), ``per_lateral_offset`` that to the lateral offset x (rad/m).
    """

    application_rad: float
    control_rad: float
    height_m: float
    control_height_m: float
    sensitivity: tuple[float, float, float]
    per_lateral_offset: float = 0.0


@final
@dataclass(frozen=True, kw_only=True)
class WheelGeometry:
    """Model of the wheel without any delay, and the standard uncertainties of its common angle, rad.

    ``angle_budget`` lists what shifts all edges alike; ``measured`` has, by the same sources, the standard uncertainty of what
    was measured and its unit, where that is not the angle itself; ``u_edge_rad`` is the standard uncertainty of a single cutout
    edge, None where none was stated. ``edges_from`` says where the edge angles come from. ``camera_roll_rad`` is rho, the
    bisector of the mask in the image minus phi_M; it touches no delay.
    """

    model: WheelModel
    gates: GateAngles
    angle_budget: tuple[tuple[str, str, float], ...]
    u_edge_rad: float | None
    edges_from: str
    camera_roll_rad: float | None
    findings: tuple[Finding, ...]
    rotation: Rotation = "clockwise"
    measured: Mapping[str, tuple[float, str]] = field(default_factory=dict)
