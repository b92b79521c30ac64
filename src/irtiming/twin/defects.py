"""What a laboratory has and a paper does not name: defects of rig and camera, each by itself, put into a scene."""

import math
from dataclasses import dataclass, fields, replace
from typing import Any, final

from irtiming.errors import PlanError
from irtiming.twin.in_camera import InCamera
from irtiming.twin.optics import GlareShape
from irtiming.twin.response_curve import ResponseCurve
from irtiming.twin.scene import BolometerTiming, CameraTiming, Radiance, Scene, Timing
from irtiming.twin.upkeep import Sway

_BEYOND = 0.2  # of the contrast: how far the range of a camera's values reaches beyond it
_WINDOW = ("rise_s", "fall_s", "tail_share", "tail_s", "count_time_error_s")


@final
@dataclass(frozen=True, kw_only=True)
class Defects:
    """Defects to put into a scene; the defaults are none.

    Rig. ``late_application_gate_s`` and ``late_control_gate_s``: how much later than they pass the light gates' edges are
    timestamped; ``late_trigger_s``: how much later than its timestamp an edge is at the camera's connector.
    ``clock_relative_error``: true seconds are ticks / (f (1 + e)). ``lateral_offset_m``: the middle between the beams lies that
    much beside the vertical through the axle, towards the control beam.

    Optics, as in `irtiming.twin.optics.Optics`. Tilts in rad, ``lens_centre_*_px`` from the middle of the image: that of a region
    of interest of a larger detector may lie far out. ``distortion`` and blurs are those of the scene where they are None.

    Levels. ``blade_share``: the blade between edges 2 and 3 is warmer by that share of the contrast. ``sway_share``: by how
    much of the contrast gain and offset each go up and down within 33 s, smoothly. ``references_anew``: a photon camera's
    references are recorded anew for each recording.

    Detector. ``exponent`` of its response between the coldest and the warmest that it sees, which takes in blackbody and wheel
    and a fifth of their contrast on either side; 1 is a straight line (`irtiming.twin.response_curve.ResponseCurve`).

    In the camera, as in `irtiming.twin.in_camera.InCamera`: ``filter_share``, ``averaged_frames``, ``memory_share``.

    Window of a photon camera, as in `irtiming.twin.scene.CameraTiming`: ``rise_s``, ``fall_s``, ``tail_share``, ``tail_s`` and
    ``count_time_error_s``, stated less true.
    """

    late_application_gate_s: float = 0.0
    late_control_gate_s: float = 0.0
    late_trigger_s: float = 0.0
    clock_relative_error: float = 0.0
    lateral_offset_m: float = 0.0
    tilt_about_row_rad: float = 0.0
    tilt_about_column_rad: float = 0.0
    focal_length_px: float = 1000.0
    lens_centre_row_px: float = 0.0
    lens_centre_column_px: float = 0.0
    distortion: float | None = None
    blur_rows_px: float | None = None
    blur_columns_px: float | None = None
    blur_turn_rad: float = 0.0
    blur_growth: float = 0.0
    glare_share: float = 0.0
    glare_px: float = 6.0
    glare_shape: GlareShape = "exponential"
    blade_share: float = 0.0
    sway_share: float = 0.0
    references_anew: bool = False
    exponent: float = 1.0
    filter_share: float = 0.0
    averaged_frames: int = 1
    memory_share: float = 0.0
    rise_s: float = 0.0
    fall_s: float = 0.0
    tail_share: float = 0.0
    tail_s: float = 0.3e-3
    count_time_error_s: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what no laboratory has."""
        limits = {
            "late_application_gate_s": 1e-2, "late_control_gate_s": 1e-2, "late_trigger_s": 1e-2, "clock_relative_error": 1e-2,
            "lateral_offset_m": 5e-3, "tilt_about_row_rad": math.radians(20), "tilt_about_column_rad": math.radians(20),
            "blur_turn_rad": math.radians(90), "blade_share": 0.2, "sway_share": 0.5, "count_time_error_s": 1e-2,
        }  # fmt: skip
        for name, most in limits.items():
            if not abs(getattr(self, name)) <= most:
                raise PlanError(
                    f"{{{name}}} of {getattr(self, name)} was asked for; it must lie within +-{most:g}", name
                )
        if not (
            0 <= self.rise_s <= 1e-2 and 0 <= self.fall_s <= 1e-2 and 0 <= self.tail_share <= 0.5 and self.tail_s > 0
        ):
            raise PlanError(
                f"a window that rises in {self.rise_s:g} s and falls in {self.fall_s:g} s with a tail of {self.tail_share:g} "
                f"over {self.tail_s:g} s; rise and fall must lie between 0 and 10 ms, the tail between 0 and 0.5"
            )

    @property
    def has_window(self) -> bool:
        """Whether there is a defect of the integration window."""
        return self.rise_s != 0 or self.fall_s != 0 or self.tail_share != 0 or self.count_time_error_s != 0


def with_defects(scene: Scene, defects: Defects) -> Scene:
    """The scene with these defects in place of its own; distortion and blur stay where the defects say nothing of them.

    Raises
    ------
    PlanError
        If the defects are not of this kind of camera, or leave nothing of the window.
    """
    lens: dict[str, Any] = {} if defects.distortion is None else {"distortion": defects.distortion}
    own = ("late_application_gate_s", "late_control_gate_s", "lateral_offset_m")
    optics = (
        "tilt_about_row_rad", "tilt_about_column_rad", "focal_length_px", "lens_centre_row_px", "lens_centre_column_px",
        "blur_rows_px", "blur_columns_px", "blur_turn_rad", "blur_growth", "glare_share", "glare_px", "glare_shape",
    )  # fmt: skip
    return replace(
        scene,
        beams=replace(scene.beams, **_picked(defects, own)),
        trigger=replace(scene.trigger, **_picked(defects, ("clock_relative_error", "late_trigger_s"))),
        optics=replace(scene.optics, **_picked(defects, optics), **lens),
        radiance=replace(scene.radiance, **_picked(defects, ("blade_share", "references_anew"))),
        detector=replace(scene.detector, curve=_curve(scene.radiance, defects.exponent)),
        timing=_shaped(scene.timing, defects),
        sway=Sway(gain_share=defects.sway_share, offset_share=defects.sway_share),
        in_camera=InCamera(**_picked(defects, ("memory_share", "filter_share", "averaged_frames"))),
    )


def defects_of(scene: Scene) -> Defects:
    """What `with_defects` put into a scene, with its distortion and blur."""
    optics, timing = scene.optics, scene.timing
    window = {name: getattr(timing, name) for name in _WINDOW} if isinstance(timing, CameraTiming) else {}
    rows_px, columns_px = optics.blur_rows_columns_px
    homes = (scene.beams, scene.trigger, optics, scene.radiance, scene.detector.curve, scene.in_camera)
    shared = {
        field.name: getattr(home, field.name)
        for field in fields(Defects)
        for home in homes
        if hasattr(home, field.name)
    }
    shared |= {"blur_rows_px": rows_px, "blur_columns_px": columns_px, "sway_share": scene.sway.gain_share}
    return Defects(**shared, **window)


def _curve(radiance: Radiance, exponent: float) -> ResponseCurve:
    if exponent == 1:
        return ResponseCurve()
    low_dn, high_dn = sorted(radiance.level_dn(kelvin) for kelvin in (radiance.blackbody_k, radiance.wheel_k))
    beyond_dn = _BEYOND * (high_dn - low_dn)
    return ResponseCurve(exponent=exponent, low_dn=low_dn - beyond_dn, high_dn=high_dn + beyond_dn)


def _picked(defects: Defects, names: tuple[str, ...]) -> dict[str, Any]:
    return {name: getattr(defects, name) for name in names}


def _shaped(timing: Timing, defects: Defects) -> Timing:
    """Timing of the camera with its window as the defects make it."""
    if isinstance(timing, BolometerTiming):
        if defects.has_window:
            raise PlanError("defects of an integration window with a microbolometer, which has none; take them out")
        return timing
    shaped: CameraTiming = replace(timing, **_picked(defects, _WINDOW))
    slowest_s = max(shaped.rise_s, shaped.fall_s)
    if slowest_s > timing.integration_time_s:
        raise PlanError(
            f"a window of {timing.integration_time_s * 1e6:g} us that takes {slowest_s * 1e6:g} us to rise or fall; that "
            "must be shorter than the window"
        )
    return shaped
