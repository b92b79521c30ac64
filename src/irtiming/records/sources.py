"""Sources of uncertainty: their names in budgets, what key of rig.toml stands behind one, and which one rig has in common."""

from collections.abc import Mapping

MASK_CENTRE = "mask centre angle phi_M"
GATE_DISTANCE, GATE_HEIGHT, BEAM_OFFSET = (
    "gate distance d (caliper)",
    "gate height difference dh (caliper)",
    "lateral offset of the beams",
)
"""What was measured as a length."""

REGISTER = "register of slots and cutouts"
EDGES = "cutout edges"
MASK_BESIDE = "mask beside the axle (image)"
IMAGE = "axle, mask and blur in the image"
LENS = "tilt of the camera, and its lens"
STRAIGHTNESS = "straightness of the mask's edges"
CLOCK = "clock of the trigger generator"
WINDOW, TAIL = "integration time as stated", "tail of the integration window"
MEMORY, FRAME_BEFORE = "share of the frame before, as stated", "share of the frame before in each frame"
"""What is known of that share beforehand; and what not knowing it adds."""

REFERENCES = "noise of the non-uniformity references"
RESIDUALS = "structure of the residuals common to all recordings"
LATENCIES: Mapping[str, str] = {
    "application_gate": "latency of the application gate",
    "control_gate": "latency of the control gate",
    "trigger": "latency of the trigger path",
}
"""Of the latencies by their names."""

BOTH_GATES = "latency of both light gates"
"""What both gates' latencies have in common."""

RIG_KEYS: Mapping[str, str] = {
    MASK_CENTRE: "mask.centre_angle",
    GATE_DISTANCE: "beams.half_separation",
    GATE_HEIGHT: "beams.height_difference",
    BEAM_OFFSET: "beams.lateral_offset",
    **{source: f"latency.{name}" for name, source in LATENCIES.items()},
    BOTH_GATES: "latency.control_gate",
    CLOCK: "clock.relative_error",
}
"""Key of rig.toml that states the estimate behind each contribution."""

OF_THE_RIG = (EDGES, REGISTER, MASK_BESIDE)
"""Sources of type A that belong to wheel and mask: they err alike in every recording of a camera before them."""
