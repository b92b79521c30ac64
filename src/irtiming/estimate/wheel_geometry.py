"""The rig's angles and what is known of their errors, from rig.toml and the timestamps (Schatz 2023, 2.5)."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from irtiming.physics.light_gates import gate_angles, refuse_other_slots
from irtiming.physics.wheel import TURN, wheel_model
from irtiming.records import sources
from irtiming.records.finding import Finding
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import LightGates, Measured, Rig
from irtiming.records.wheel_geometry import EdgeAngles, GateAngles, WheelGeometry
from irtiming.records.wheel_track import WheelTrack

_LARGEST_ROLL_RAD = np.radians(
    5.0
)  # a camera that is set up by eye stands straighter; a bubble level tells a tenth of it
_BY_CHANCE = 4.0  # standard uncertainties of an angle by an instrument: by chance once in the life of a laboratory
_RULER_M = 2e-3  # half of what one slot more between the gates makes; a ruler in a hand is better
_IDEAL_EDGES: EdgeAngles = (0.0, TURN / 4, TURN / 2, 3 * TURN / 4)


def geometry(
    recordings: Sequence[ReducedRecording],
    rig: Rig,
    *,
    slots: Literal["learned", "equal"],
    off_axle_mask: bool,
) -> WheelGeometry:
    """Angles of gates, edges and opening.

    Parameters
    ----------
    recordings
        Their timestamps give the gate separation and, where rig.toml has no edge angles, these.
    rig
        As measured by its owner.
    slots
        Which of the two tracks to take the gate separation from.
    off_axle_mask
        Whether to shift the opening by what the image shows of a mask whose centre lies beside the axle; the published
        procedure knows nothing of it.

    Raises
    ------
    GeometryError
        If the numbers contradict each other.
    """
    tracks = [r.track if slots == "learned" else r.equal_track for r in recordings]
    beams = rig.light_gates if slots == "learned" else replace(rig.light_gates, lateral_offset_m=None)
    separation = float(np.mean([t.gate_separation_rad for t in tracks]))
    gates = gate_angles(separation, beams)
    refuse_other_slots(separation, beams, control_slots=rig.wheel.control_slots)
    edges, u_edge, edges_from, findings = _edges(rig, tracks)
    shift, u_shift = _mask_shift(recordings) if off_axle_mask else (0.0, None)
    opening = rig.mask_opening
    model = wheel_model(
        edges,
        gates.application_rad,
        opening_angle_rad=opening.opening_angle_rad.value,
        centre_angle_rad=opening.centre_angle_rad.value + shift,
        rotation=rig.wheel.rotation,
    )
    budget = _budget(
        rig.mask_opening.centre_angle_rad, beams, gates, u_register=max(t.u_gate_separation_rad for t in tracks)
    )
    if u_shift is not None:
        budget.append((sources.MASK_BESIDE, "A", u_shift))
    roll = _camera_roll(recordings, opening.centre_angle_rad.value)
    findings += (*_doubts(rig, roll if slots == "learned" else None), *_of_height(beams, gates))
    return WheelGeometry(
        model=model,
        gates=gates,
        angle_budget=tuple(budget),
        u_edge_rad=u_edge,
        edges_from=edges_from,
        camera_roll_rad=roll,
        findings=findings,
        rotation=rig.wheel.rotation,
        measured={source: (number.standard_uncertainty, "m") for source, number in _by_caliper(beams).items()},
    )


def _by_caliper(beams: LightGates) -> dict[str, Measured]:
    """Lengths on the rig, by the source that a budget names."""
    offset = {} if beams.lateral_offset_m is None else {sources.BEAM_OFFSET: beams.lateral_offset_m}
    return {sources.GATE_DISTANCE: beams.half_separation_m, sources.GATE_HEIGHT: beams.height_difference_m} | offset


def _budget(
    centre: Measured, beams: LightGates, gates: GateAngles, *, u_register: float
) -> list[tuple[str, str, float]]:
    """What shifts all edges alike, with its type and standard uncertainty, rad."""
    per_separation, per_d, per_dh = (abs(s) for s in gates.sensitivity)
    per_length = {
        sources.GATE_DISTANCE: per_d,
        sources.GATE_HEIGHT: per_dh,
        sources.BEAM_OFFSET: abs(gates.per_lateral_offset),
    }
    lengths = _by_caliper(beams).items()
    return [
        (sources.MASK_CENTRE, "B", centre.standard_uncertainty),
        *((source, "B", per_length[source] * number.standard_uncertainty) for source, number in lengths),
        (sources.REGISTER, "A", per_separation * u_register),
    ]


def _doubts(rig: Rig, roll_rad: float | None) -> tuple[Finding, ...]:
    """What is missing in rig.toml, or does not fit the image."""
    doubts = []
    if rig.mask_opening.centre_angle_rad.standard_uncertainty == 0:
        doubts.append(
            Finding(
                code="mask-angle-without-uncertainty",
                severity="warning",
                what="rig.toml states no centre_angle_u_deg: phi_M is taken as exact, and the absolute delay's "
                "uncertainty is too "
                "small",
            )
        )
    return (*doubts, *_of_roll(rig, roll_rad))


def _of_roll(rig: Rig, roll_rad: float | None) -> tuple[Finding, ...]:
    """Where the image shows the mask turned by another angle than the camera is said to be.

    An angle by an instrument, which has an uncertainty, is off by chance where the mask's own has one too; one by eye is none.
    """
    stated, centre = rig.camera.roll_rad or Measured(0.0), rig.mask_opening.centre_angle_rad
    u_rad = np.hypot(stated.standard_uncertainty, centre.standard_uncertainty)
    most_rad = _BY_CHANCE * u_rad if stated.standard_uncertainty else _LARGEST_ROLL_RAD
    beside_rad = 0.0 if roll_rad is None else float(np.angle(np.exp(1j * (roll_rad - stated.value))))
    if abs(beside_rad) <= most_rad:
        return ()
    beyond = "" if rig.camera.roll_rad is None else f" beside roll_deg = {np.degrees(stated.value):g}"
    return (
        Finding(
            code="mask-not-where-stated",
            severity="doubt",
            what=f"the mask stands {np.degrees(beside_rad):+.1f} deg beside its place in rig.toml: the camera is rolled by more "
            f"than {np.degrees(most_rad):.2g} deg{beyond}, or centre_angle_deg is as wrong, and the delay with it",
            cure="set the camera upright or state [camera] roll_deg, check [mask] centre_angle_deg, [wheel] rotation and that "
            "the image is not mirrored",
        ),
    )


def _of_height(beams: LightGates, gates: GateAngles) -> tuple[Finding, ...]:
    """Where the beams' depth below the axle, which follows from the slots between them, is not what a ruler says."""
    ruler_m = beams.height_m
    if ruler_m is None or abs(gates.height_m - ruler_m) <= _RULER_M:
        return ()
    return (
        Finding(
            code="height-contradicts-ruler",
            severity="doubt",
            what=f"by the slots between the gates the application beam lies {1e3 * gates.height_m:.1f} mm below the axle, by "
            f"the ruler {1e3 * ruler_m:g} mm: more than {1e3 * _RULER_M:g} mm apart, and the delay is wrong with it",
            cure="check [beams] half_separation_mm, height_difference_mm, height_mm, and the control gate's edge",
        ),
    )


def _edges(rig: Rig, tracks: list[WheelTrack]) -> tuple[EdgeAngles, float | None, str, tuple[Finding, ...]]:
    stated = rig.wheel.cutout_edges_rad
    if stated is not None:
        u = float(np.sqrt(np.mean([e.standard_uncertainty**2 for e in stated])))
        values = (stated[0].value, stated[1].value, stated[2].value, stated[3].value)
        return values, u or None, "rig.toml", ()
    edges_rad = [track.application_edges_rad for track in tracks if track.application_edges_rad is not None]
    if edges_rad:
        a, b, c, d = (float(angle) for angle in np.mean(edges_rad, axis=0))
        return (a, b, c, d), None, "application_edges of the recordings", ()
    doubt = Finding(
        code="edges-taken-as-ideal",
        severity="warning",
        what="cutout edges taken as ideal (0, 90, 180, 270 deg): neither rig.toml nor the recording states them",
    )
    return _IDEAL_EDGES, None, "ideal", (doubt,)


def _camera_roll(recordings: Sequence[ReducedRecording], centre_angle_rad: float) -> float | None:
    """Angle by which the camera is turned against the rig: bisector of the mask in the image minus phi_M, rad."""
    turned = [np.exp(1j * (r.axle.bisector_rad - centre_angle_rad)) for r in recordings if r.axle is not None]
    return float(np.angle(np.mean(turned))) if turned else None


def _mask_shift(recordings: Sequence[ReducedRecording]) -> tuple[float, float | None]:
    """Mean angle of the light about the axle minus the bisector of the mask's edges, from the images."""
    views = [r.axle for r in recordings if r.axle is not None]
    if not views:
        return 0.0, None
    shifts = np.array([v.mean_angle_rad - v.bisector_rad for v in views])
    weights = np.array([1 / max(v.u_off_axle_rad, 1e-6) ** 2 for v in views])
    return float(np.average(shifts, weights=weights)), float(np.mean([v.u_off_axle_rad for v in views]))
