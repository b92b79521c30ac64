"""Which key of rig.toml, by section and name, stands behind a source of uncertainty, and which sources one rig has in common."""

from collections.abc import Mapping

CLOCK = "clock of the trigger generator"
RIG_KEYS: Mapping[str, str] = {
    "mask centre angle phi_M": "mask.centre_angle",
    "gate distance d (caliper)": "beams.half_separation",
    "gate height difference dh (caliper)": "beams.height_difference",
    "lateral offset of the beams": "beams.lateral_offset",
    "latency of the application gate": "latency.application_gate",
    "latency of the control gate": "latency.control_gate",
    "latency of both light gates": "latency.control_gate",
    "latency of the trigger path": "latency.trigger",
    CLOCK: "clock.relative_error",
}
"""Key of rig.toml that states the estimate behind each contribution."""

OF_THE_RIG = ("cutout edges", "register of slots and cutouts", "mask beside the axle (image)")
"""Sources of type A that belong to wheel and mask: they err alike in every recording of a camera before them."""
