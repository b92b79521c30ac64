"""rig.toml: what a person measured on the rig, checked and brought to SI units."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Annotated, TypeVar

from pydantic import AfterValidator, Field, model_validator

from irtiming.archive.typed_file import NOT_NEGATIVE, Number, Part, Uncertainty, read_toml
from irtiming.archive.typed_misfit import FileKind, OutOfRange
from irtiming.errors import GeometryError
from irtiming.records.rig import (
    CameraOptics,
    Clock,
    Latency,
    LensCalibration,
    LightGates,
    MaskOpening,
    Measured,
    Rig,
    Rotation,
    Wheel,
    WindowTail,
)

SI = {"mm": 1e-3, "deg": math.pi / 180, "us": 1e-6}
"""By what a number in each unit of the file is multiplied."""

_FROM_IDEAL_DEG = 10.0
_SMALLEST_HALF_SEPARATION_MM = 1.0
_LARGEST_OFFSET_MM = 20.0
_LONGEST_LATENCY_US = 10_000.0
_LARGEST_CLOCK_ERROR = 0.01  # no oscillator is as far off
LATENCIES = ("application_gate", "control_gate", "trigger", "camera_input")
_HALF_TURN_TOLERANCE_RAD = 1e-3
_P = TypeVar("_P", bound=Part)
_KIND = FileKind(
    name="rig.toml",
    missing="measure it and write it there",
    section="measure the rig and write it there",
    out_of_range=GeometryError,
)


def _edges(angles: list[float]) -> list[float]:
    for index, angle in enumerate(angles):
        ideal = index * math.pi / 2
        if index == 0 and angle != 0:
            cure = "alpha_0 is 0 by definition; subtract it from all four"
        elif abs(angle - ideal) > _FROM_IDEAL_DEG * SI["deg"]:
            cure = f"it must be within {_FROM_IDEAL_DEG:g} deg of {ideal:.4f} rad, in ascending order"
        elif index == 2 and angle < math.pi - _HALF_TURN_TOLERANCE_RAD:
            cure = "it must be at least pi: edge 0 is the one before the longer half turn"
        else:
            continue
        raise OutOfRange(f"[{index}] = {angle:g} rad; {cure}")
    return angles


def _in_millimetres(half_mm: float) -> float:
    if half_mm < _SMALLEST_HALF_SEPARATION_MM:
        least = f"greater than {_SMALLEST_HALF_SEPARATION_MM:g} mm"
        raise OutOfRange(f"= {half_mm:g} mm; it must be {least}: half the beams' distance, in millimetres")
    return half_mm


def _matrix(numbers: list[float]) -> list[float]:
    if min(numbers[:2]) <= 0:
        raise OutOfRange(f"= {numbers}; fx and fy must be greater than 0 px")
    return numbers


def _with_its_number(part: _P, companion: str, key: str) -> _P:
    if companion in part.model_fields_set and key not in part.model_fields_set:
        raise ValueError(f"{companion} stands without {key}; add {key} or take it out")
    return part


_Two = Annotated[list[Number], Field(min_length=2, max_length=2)]
_COMPANIONS = (
    ("distortion_u", "distortion"),
    ("window_tail_u", "window_tail"),
    ("window_tail_us", "window_tail"),
    ("frame_memory_u", "frame_memory"),
    ("focal_length_u_px", "focal_length_px"),
    ("lens_centre_u_px", "lens_centre_px"),
    ("camera_matrix_u", "camera_matrix"),
    ("distortion_coefficients", "camera_matrix"),
    ("distortion_coefficients_u", "distortion_coefficients"),
    ("region_origin_px", "camera_matrix"),
    ("roll_u_deg", "roll_deg"),
)


class _Wheel(Part):
    control_slots: int = Field(100, ge=2, le=10000, description="slots of the ring that the control gate sees")
    rotation: Rotation = Field(
        "clockwise",
        description="direction of the wheel",
        json_schema_extra={"must": "it must be 'clockwise' or 'counterclockwise', as the camera sees the wheel"},
    )
    cutout_edges_rad: Annotated[list[Number], Field(min_length=4, max_length=4), AfterValidator(_edges)] | None = Field(
        None,
        description="alpha_0 .. alpha_3, wheel angles at which the cutout edges pass the application gate",
        json_schema_extra={"must": "it must be a list of four angles, alpha_0 to alpha_3"},
    )
    cutout_edges_u_rad: Uncertainty | Annotated[list[Uncertainty], Field(min_length=4, max_length=4)] = Field(
        0.0,
        description="standard uncertainty of all four edges, or of each",
        json_schema_extra={"must": "it must be one number, or a list of four", "limit": NOT_NEGATIVE},
    )

    @model_validator(mode="after")
    def _refuse_uncertainty_alone(self) -> "_Wheel":
        return _with_its_number(self, "cutout_edges_u_rad", "cutout_edges_rad")

    def record(self) -> Wheel:
        """The same in SI units."""
        edges, u = self.cutout_edges_rad, self.cutout_edges_u_rad
        if edges is None:
            return Wheel(control_slots=self.control_slots, rotation=self.rotation)
        first, second, third, fourth = map(Measured, edges, u if isinstance(u, list) else [u] * 4)
        return Wheel(
            control_slots=self.control_slots, rotation=self.rotation, cutout_edges_rad=(first, second, third, fourth)
        )


class _Beams(Part):
    half_separation_mm: Annotated[float, AfterValidator(_in_millimetres)] = Field(
        ge=0, le=1000, description="d: half the distance of the two beams"
    )
    half_separation_u_mm: Uncertainty = 0.0
    height_difference_mm: float = Field(ge=0, le=1000, description="dh: how much nearer the axle the control beam is")
    height_difference_u_mm: Uncertainty = 0.0
    whole_slots_between: int = Field(description="floor(dbeta / slot pitch), from 0 to half the control slots")
    lateral_offset_mm: float = Field(
        0.0,
        ge=-_LARGEST_OFFSET_MM,
        le=_LARGEST_OFFSET_MM,
        description="middle between the beams beside the vertical through the axle, positive towards the control beam",
    )
    lateral_offset_u_mm: Uncertainty = 0.0
    height_mm: float | None = Field(
        None, gt=0, le=1000, description="h by a ruler: only a check of whole_slots_between"
    )

    def record(self) -> LightGates:
        """The same in SI units."""
        is_stated = {"lateral_offset_mm", "lateral_offset_u_mm"} & self.model_fields_set
        return LightGates(
            half_separation_m=_measured(self, "half_separation", unit="mm"),
            height_difference_m=_measured(self, "height_difference", unit="mm"),
            whole_slots_between=self.whole_slots_between,
            lateral_offset_m=_measured(self, "lateral_offset", unit="mm") if is_stated else None,
            height_m=None if self.height_mm is None else self.height_mm * SI["mm"],
        )


class _Mask(Part):
    opening_angle_deg: float = Field(gt=0, le=360, description="gamma")
    opening_angle_u_deg: Uncertainty = 0.0
    centre_angle_deg: float = Field(ge=-180, le=360, description="phi_M")
    centre_angle_u_deg: Uncertainty = 0.0


class _Camera(Part):
    distortion: float | None = Field(
        None,  # beyond these limits one number does not describe a lens
        ge=-0.14,
        le=0.5,
        description="k in r_d = r_u (1 + k r_u^2), in half widths of the image",
        json_schema_extra={"hint": ": k in r_d = r_u (1 + k r_u^2), in half widths of the image"},
    )
    distortion_u: Uncertainty = 0.0
    integration_time_u_us: Uncertainty | None = Field(
        None,
        description="standard uncertainty of the count_time that recordings state",
        json_schema_extra={"limit": NOT_NEGATIVE},
    )
    window_tail: float | None = Field(
        None,
        ge=0,
        lt=1,
        description="share of all that a photon camera takes in which comes after its integration window",
        json_schema_extra={"hint": ": a share; 0 where the detector is blind once the window ends"},
    )
    window_tail_u: Uncertainty = 0.0
    window_tail_us: float | None = Field(
        None, gt=0, le=1e6, description="time constant with which that fades; 200 us where it is left out"
    )
    frame_memory: float | None = Field(
        None,
        gt=-1,
        lt=1,
        description="share of the frame before that each frame holds, by a noise filter in the camera or the detector itself",
        json_schema_extra={"hint": ": the share of the frame before that each frame holds; 0 where no filter is on"},
    )
    frame_memory_u: Uncertainty = 0.0
    focal_length_px: float | None = Field(
        None, gt=0, le=1e6, description="focal length of the lens over the pixel pitch"
    )
    focal_length_u_px: Uncertainty = 0.0
    lens_centre_px: _Two | None = Field(
        None,
        description="column and row of the lens centre in the image recorded, pixel centres at whole numbers",
        json_schema_extra={"must": "it must be a list of two numbers, column and row"},
    )
    lens_centre_u_px: Uncertainty = 0.0
    camera_matrix: Annotated[list[Number], Field(min_length=4, max_length=4), AfterValidator(_matrix)] | None = Field(
        None,
        description="fx, fy, cx, cy of a calibration by OpenCV, Kalibr or ROS, px",
        json_schema_extra={"must": "it must be a list of four numbers: fx, fy, cx, cy"},
    )
    camera_matrix_u: Annotated[list[Uncertainty], Field(min_length=4, max_length=4)] = Field(
        [0.0] * 4,
        description="their standard uncertainties, px",
        json_schema_extra={"must": "it must be a list of four numbers", "limit": NOT_NEGATIVE},
    )
    distortion_coefficients: Annotated[list[Number], Field(min_length=4, max_length=5)] = Field(
        [0.0] * 5,
        description="k1, k2, p1, p2, k3 of the same calibration",
        json_schema_extra={"must": "it must be a list of k1, k2, p1, p2 and, if it has one, k3"},
    )
    distortion_coefficients_u: Uncertainty = Field(
        0.0, description="standard uncertainty of k1", json_schema_extra={"limit": NOT_NEGATIVE}
    )
    region_origin_px: _Two = Field(
        [0.0, 0.0],
        description="column and row of the recorded image's first pixel in the image that was calibrated",
        json_schema_extra={"must": "it must be a list of two numbers, column and row"},
    )
    roll_deg: float | None = Field(
        None,
        ge=-180,
        le=180,
        description="rho: how far the camera is turned about its axis, and sees angles as phi + rho; only a check of phi_M",
        json_schema_extra={
            "hint": ": positive where what stands at 3 o'clock on the rig appears further down in the image"
        },
    )
    roll_u_deg: Uncertainty = Field(
        0.0, description="its standard uncertainty; left out, rho is by eye", json_schema_extra={"limit": NOT_NEGATIVE}
    )

    @model_validator(mode="after")
    def _refuse_uncertainty_alone(self) -> "_Camera":
        for companion, key in _COMPANIONS:
            _with_its_number(self, companion, key)
        for name in ("distortion", "focal_length_px", "lens_centre_px"):
            if {name, "camera_matrix"} <= self.model_fields_set:
                raise ValueError(f"{name} stands beside camera_matrix, which says the same; take one of them out")
        return self

    def record(self) -> CameraOptics:
        """The same in SI units."""
        u_us, centre, u_centre = self.integration_time_u_us, self.lens_centre_px, self.lens_centre_u_px
        memory = self.frame_memory
        optics = CameraOptics(
            integration_time_u_s=None if u_us is None else u_us * SI["us"],
            window_tail=self._tail(),
            frame_memory=None if memory is None else Measured(memory, self.frame_memory_u),
            focal_length_px=None
            if self.focal_length_px is None
            else Measured(self.focal_length_px, self.focal_length_u_px),
            lens_centre_px=None if centre is None else (Measured(centre[0], u_centre), Measured(centre[1], u_centre)),
            calibration=self._calibration(),
            roll_rad=None if self.roll_deg is None else _measured(self, "roll", unit="deg"),
        )
        if self.distortion is None:
            return optics
        return replace(optics, distortion=Measured(self.distortion, self.distortion_u))

    def _tail(self) -> WindowTail | None:
        if self.window_tail is None:
            return None
        tail = WindowTail(share=Measured(self.window_tail, self.window_tail_u))
        return tail if self.window_tail_us is None else replace(tail, time_constant_s=self.window_tail_us * SI["us"])

    def _calibration(self) -> LensCalibration | None:
        if self.camera_matrix is None:
            return None
        fx, fy, cx, cy = map(Measured, self.camera_matrix, self.camera_matrix_u)
        across, down = self.region_origin_px
        k1, k2, p1, p2, k3 = (*self.distortion_coefficients, 0.0)[:5]
        return LensCalibration(
            focal_length_px=(fx, fy),
            centre_px=(replace(cx, value=cx.value - across), replace(cy, value=cy.value - down)),
            coefficients=(Measured(k1, self.distortion_coefficients_u), k2, p1, p2, k3),
        )


_Late = Annotated[
    float,
    Field(ge=-_LONGEST_LATENCY_US, le=_LONGEST_LATENCY_US, json_schema_extra={"hint": ": a latency in microseconds"}),
]


class _Latency(Part):
    application_gate_us: _Late | None = Field(
        None, description="how much later than it passes the application beam an edge is timestamped"
    )
    application_gate_u_us: Uncertainty = 0.0
    control_gate_us: _Late | None = Field(
        None, description="how much later than it passes the control beam a slot is timestamped"
    )
    control_gate_u_us: Uncertainty = 0.0
    trigger_us: _Late | None = Field(
        None, description="how much later than its timestamp a trigger is at the camera's connector"
    )
    trigger_u_us: Uncertainty = 0.0
    camera_input_us: _Late | None = Field(
        None, description="how much later than it leaves the camera an edge of its strobe is timestamped"
    )
    camera_input_u_us: Uncertainty = 0.0
    gates_common_u_us: Uncertainty = Field(
        0.0,
        description="part of both gates' standard uncertainties that is one error, as irtiming latency gates tells it",
    )

    @model_validator(mode="after")
    def _refuse_uncertainty_alone(self) -> "_Latency":
        for name in LATENCIES:
            _with_its_number(self, f"{name}_u_us", f"{name}_us")
        smaller = min(self.application_gate_u_us, self.control_gate_u_us)
        if self.gates_common_u_us > smaller:
            raise ValueError(
                f"gates_common_u_us is {self.gates_common_u_us:g}, must be at most {smaller:g}, the smaller of "
                "application_gate_u_us and control_gate_u_us, of both of which it is a part; state both, or take it out"
            )
        return self

    def record(self) -> Latency:
        """The same in SI units."""
        found = {
            f"{name}_s": _measured(self, name, unit="us")
            for name in LATENCIES
            if getattr(self, f"{name}_us") is not None
        }
        return Latency(**found, gates_common_u_s=1e-6 * self.gates_common_u_us or None)


class _Clock(Part):
    relative_error: float = Field(
        ge=-_LARGEST_CLOCK_ERROR,
        le=_LARGEST_CLOCK_ERROR,
        description="(true frequency - clock_frequency) / clock_frequency of the trigger generator",
        json_schema_extra={"hint": ": 20 ppm are 2e-5"},
    )
    relative_error_u: Uncertainty = 0.0


class RigFile(Part):
    """rig.toml as it is written: millimetres and degrees; any number may have its ``_u_`` companion, else it counts as exact."""

    wheel: _Wheel = _Wheel()
    beams: _Beams
    mask: _Mask
    camera: _Camera = _Camera()
    latency: _Latency | None = None
    clock: _Clock | None = None

    @model_validator(mode="after")
    def _check(self) -> "RigFile":
        most = (self.wheel.control_slots - 1) // 2
        between = self.beams.whole_slots_between
        if not 0 <= between <= most:
            raise OutOfRange(f"[beams] whole_slots_between = {between}; it must be from 0 to {most}")
        edges = self.wheel.cutout_edges_rad or [index * math.pi / 2 for index in range(4)]
        sectors = [after - before for before, after in zip(edges, [*edges[1:], 2 * math.pi], strict=True)]
        narrowest_deg, opening_deg = min(sectors) / SI["deg"], self.mask.opening_angle_deg
        if opening_deg >= narrowest_deg:
            raise OutOfRange(
                f"[mask] opening_angle_deg = {opening_deg:g} deg leaves no plateau: it must be narrower than the wheel's "
                f"narrowest sector, {narrowest_deg:.4g} deg; use a narrower mask"
            )
        return self


def read_rig(path: str | Path) -> Rig:
    """Rig described by a rig.toml file, in SI units.

    Millimetres and degrees become metres and radians. A number without its ``_u_`` companion counts as exact.
    A single ``cutout_edges_u_rad`` applies to all four edges. Without ``[wheel]`` the wheel has 100 control
    slots and turns clockwise; without ``cutout_edges_rad`` the record holds None. Without ``[camera]`` the lens is not known;
    without ``[latency]``, ``[clock]`` or ``lateral_offset_mm`` the record holds None in their place.

    Raises
    ------
    ArchiveError
        If the file cannot be read, is no TOML, misses a key, has an unknown one, or a value of another type.
    GeometryError
        If a number is out of its range, or the mask opening is so wide that there is no plateau.
    """
    file, sha256 = read_toml(Path(path), RigFile, kind=_KIND)
    clock = file.clock
    return Rig(
        wheel=file.wheel.record(),
        light_gates=file.beams.record(),
        mask_opening=MaskOpening(
            opening_angle_rad=_measured(file.mask, "opening_angle", unit="deg"),
            centre_angle_rad=_measured(file.mask, "centre_angle", unit="deg"),
        ),
        camera=file.camera.record(),
        latency=None if file.latency is None else file.latency.record(),
        clock=None if clock is None else Clock(relative_error=Measured(clock.relative_error, clock.relative_error_u)),
        source=str(path),
        sha256=sha256,
    )


def _measured(part: Part, name: str, *, unit: str) -> Measured:
    value, u = (getattr(part, f"{name}_{ending}") for ending in (unit, f"u_{unit}"))
    return Measured(value * SI[unit], u * SI[unit])
