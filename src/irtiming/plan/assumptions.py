"""What is taken for granted before anything is recorded: the rig's angles, and how sure they will be."""

from dataclasses import dataclass, field
from math import radians
from typing import final

import numpy as np

from irtiming.physics.latency import window_tail
from irtiming.physics.light_gates import gate_angles
from irtiming.physics.wheel import TURN, wheel_model
from irtiming.plan.beside_angles import Beside, clock_u, of_rig
from irtiming.records import sources
from irtiming.records.camera_description import Camera
from irtiming.records.prediction import AngleErrors
from irtiming.records.rig import CameraOptics, LightGates, MaskOpening, Measured, Rig
from irtiming.records.wheel_geometry import EdgeAngles, WheelModel

USUAL_RIG = Rig(
    light_gates=LightGates(
        half_separation_m=Measured(13.0e-3, 0.05e-3),
        height_difference_m=Measured(5.5e-3, 0.05e-3),
        whole_slots_between=9,
    ),
    mask_opening=MaskOpening(
        opening_angle_rad=Measured(radians(75.0)), centre_angle_rad=Measured(radians(-90.0), radians(0.03))
    ),
    source="the usual rig",
)
"""Caliper to 0.05 mm, direction of the mask to 0.03 degrees."""

USUAL_EDGE_RAD = 0.1e-3
_USUAL_SEPARATION_RAD = 0.45e-3  # of the gates, from slots that are irregular by 0.35 mrad and eccentric by 0.4 mrad
_USUAL_BISECTOR_RAD, _USUAL_PIXELS = 0.15e-3, 1200.0  # of the mask in an image of so many pixels
_IDEAL_EDGES: EdgeAngles = (0.0, TURN / 4, TURN / 2, 3 * TURN / 4)


@final
@dataclass(frozen=True, kw_only=True)
class AssumedRig:
    """Wheel, gates and opening, the sizes of their errors, and in words what rig.toml did not say.

    ``beside`` is what latencies and clock add to parameters, ``u_clock`` the standard uncertainty of the clock's relative error,
    ``u_window_s`` that of the integration time, ``u_frame_memory`` that of the share of the frame before; None where unknown.
    ``optics`` is what rig.toml says of the camera's lens.
    """

    model: WheelModel
    angles: AngleErrors
    remarks: tuple[str, ...]
    beside: Beside = field(default_factory=dict)
    u_clock: float = 0.0
    u_window_s: float | None = None
    u_frame_memory: float | None = None
    optics: CameraOptics = field(default_factory=CameraOptics)


def assumed(rig: Rig | None, camera: Camera) -> AssumedRig:
    """The rig before it runs; None takes `USUAL_RIG`.

    The timestamps are not there yet: the gates are taken to stand half a slot beyond their whole slots, and their register to be
    as good as on a wheel with usual slots. So are the cutout edges where rig.toml does not state their uncertainty.
    """
    remarks = []
    if rig is None:
        remarks.append(
            "No rig.toml given: caliper to 0.05 mm, direction of the mask to 0.03° and the paper's dimensions are assumed."
        )
    owner = rig or USUAL_RIG
    gates = gate_angles(
        (owner.light_gates.whole_slots_between + 0.5) * TURN / owner.wheel.control_slots, owner.light_gates
    )
    edges, edge_rad = _IDEAL_EDGES, 0.0
    if owner.wheel.cutout_edges_rad is not None:
        a, b, c, d = (edge.value for edge in owner.wheel.cutout_edges_rad)
        edges = (a, b, c, d)
        edge_rad = float(np.sqrt(np.mean([edge.standard_uncertainty**2 for edge in owner.wheel.cutout_edges_rad])))
    if edge_rad == 0:
        edge_rad = USUAL_EDGE_RAD
        remarks.append(f"No cutout_edges_u_rad known: {1e3 * edge_rad:g} mrad are assumed for each cutout edge.")
    if owner.mask_opening.centre_angle_rad.standard_uncertainty == 0:
        remarks.append("rig.toml states no centre_angle_u_deg: phi_M counts as exact, every prediction is too good.")
    per_separation, per_d, per_dh = (abs(s) for s in gates.sensitivity)
    common = [
        (sources.MASK_CENTRE, owner.mask_opening.centre_angle_rad.standard_uncertainty),
        (sources.GATE_DISTANCE, per_d * owner.light_gates.half_separation_m.standard_uncertainty),
        (sources.GATE_HEIGHT, per_dh * owner.light_gates.height_difference_m.standard_uncertainty),
        (sources.REGISTER, per_separation * _USUAL_SEPARATION_RAD),
    ]
    if owner.light_gates.lateral_offset_m is not None:
        u_offset = owner.light_gates.lateral_offset_m.standard_uncertainty
        common.append((sources.BEAM_OFFSET, abs(gates.per_lateral_offset) * u_offset))
    if (camera.camera_type, camera.readout_mode) == ("photon", "snapshot"):
        bisector = _USUAL_BISECTOR_RAD * float(np.sqrt(_USUAL_PIXELS / camera.opening_pixels))
        common.append((sources.MASK_BESIDE, bisector))
    model = wheel_model(
        edges,
        gates.application_rad,
        opening_angle_rad=owner.mask_opening.opening_angle_rad.value,
        centre_angle_rad=owner.mask_opening.centre_angle_rad.value,
        rotation=owner.wheel.rotation,
    )
    if owner.latency is None:
        remarks.append(
            "No [latency] known: how late light gates and trigger path are is not in these predictions of a delay."
        )
    return AssumedRig(
        model=model,
        angles=AngleErrors(common=tuple(common), edge_rad=edge_rad, window_tail=window_tail(owner.camera)),
        remarks=tuple(remarks),
        beside=of_rig(owner, camera),
        u_clock=clock_u(owner),
        u_window_s=owner.camera.integration_time_u_s,
        u_frame_memory=None if owner.camera.frame_memory is None else owner.camera.frame_memory.standard_uncertainty,
        optics=owner.camera,
    )
