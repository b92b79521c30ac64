"""The rig as its owner measured it: wheel, light gates, mask opening, lens, latencies and clock (rig.toml in SI units)."""

from dataclasses import dataclass, field
from typing import Literal, final

Rotation = Literal["clockwise", "counterclockwise"]
"""Direction of the wheel as the camera sees it."""


@final
@dataclass(frozen=True)
class Measured:
    """A measured number, with its standard uncertainty in the same unit.

    ``standard_uncertainty`` is 0 where rig.toml states none; the number then counts as exact.
    """

    value: float
    standard_uncertainty: float = 0.0


@final
@dataclass(frozen=True, kw_only=True)
class Wheel:
    """Chopper wheel: two cutouts between four edges, and a ring of control slots.

    ``cutout_edges_rad`` are alpha_0 .. alpha_3, the wheel angles at which the edges pass the application gate;
    None where rig.toml leaves them out: then they come from the recording or are ideal.
    """

    control_slots: int = 100
    rotation: Rotation = "clockwise"
    cutout_edges_rad: tuple[Measured, Measured, Measured, Measured] | None = None


@final
@dataclass(frozen=True, kw_only=True)
class LightGates:
    """The two light beams below the axle; figure 1 of the definitions.

    The application gate lies ``half_separation_m`` (d) beside the vertical through the axle, the control gate as far
    on the other side and ``height_difference_m`` (dh) nearer the axle. ``whole_slots_between`` is the whole number of
    control slots between them, floor(dbeta / slot pitch). ``lateral_offset_m`` is by how much the middle between the beams lies
    beside that vertical, positive towards the control gate; None where rig.toml does not state it. ``height_m`` (h) is by a
    ruler: it only checks ``whole_slots_between``.
    """

    half_separation_m: Measured
    height_difference_m: Measured
    whole_slots_between: int
    lateral_offset_m: Measured | None = None
    height_m: float | None = None


@final
@dataclass(frozen=True, kw_only=True)
class MaskOpening:
    """Annular sector behind the wheel: opening angle gamma and direction phi_M of its bisector."""

    opening_angle_rad: Measured
    centre_angle_rad: Measured


@final
@dataclass(frozen=True, kw_only=True)
class Latency:
    """How much later than the event its edge is timestamped, s; None where rig.toml does not state it.

    ``application_gate_s`` and ``control_gate_s``: an edge that passes the beam. ``camera_input_s``: an edge of the camera's
    strobe. ``trigger_s`` the other way: how much later than its timestamp the trigger is at the camera's connector, from where
    its delay counts. ``gates_common_u_s`` is the part of both gates' standard uncertainties that is one error: that of the
    number from which both were measured.
    """

    application_gate_s: Measured | None = None
    control_gate_s: Measured | None = None
    trigger_s: Measured | None = None
    camera_input_s: Measured | None = None
    gates_common_u_s: float | None = None


@final
@dataclass(frozen=True, kw_only=True)
class Clock:
    """Of the trigger generator: ``relative_error`` e = (true frequency - clock_frequency) / clock_frequency.

    Time in SI seconds is ticks / (clock_frequency (1 + e)).
    """

    relative_error: Measured


@final
@dataclass(frozen=True, kw_only=True)
class LensCalibration:
    """A calibration of others: camera matrix and distortion as OpenCV, Kalibr (radtan) and ROS have them, in the image recorded.

    ``focal_length_px`` are f_x and f_y, ``centre_px`` c_x and c_y, columns first, pixel centres at whole numbers;
    ``coefficients`` are k_1, k_2, p_1, p_2, k_3. Only k_1 carries an uncertainty: it stands for that of the whole curve.
    """

    focal_length_px: tuple[Measured, Measured]
    centre_px: tuple[Measured, Measured]
    coefficients: tuple[Measured, float, float, float, float] = (Measured(0.0), 0.0, 0.0, 0.0, 0.0)


@final
@dataclass(frozen=True, kw_only=True)
class WindowTail:
    """What a photon camera still takes in after its window: ``share`` of all that counts, fading with ``time_constant_s``.

    The latter is 0.2 ms where it is not stated.
    """

    share: Measured
    time_constant_s: float = 0.2e-3


@final
@dataclass(frozen=True, kw_only=True)
class CameraOptics:
    """What is known of the camera's lens: its radial distortion k, r_d = r_u (1 + k r_u^2) in half widths of the image.

    Where none was measured it is 0 with an uncertainty that few lenses exceed; the frames say more where they can.
    ``integration_time_u_s`` is the standard uncertainty of the integration time that recordings state; None where
    unknown. ``window_tail`` is what comes after it; None where unknown. ``frame_memory`` is the share of the frame
    before that each frame holds, by a noise filter or the detector; None where the frames alone tell it. ``lens_centre_px``,
    column and row, and ``focal_length_px`` are None where rig.toml does not state them. A ``calibration`` holds what is known
    of the lens, and then stands alone. ``roll_rad`` is by how much the camera is turned about its axis, an image angle less the
    rig's: it only checks where the mask is in the image; None of a camera that was set upright by eye.
    """

    distortion: Measured | None = None
    integration_time_u_s: float | None = None
    window_tail: WindowTail | None = None
    frame_memory: Measured | None = None
    lens_centre_px: tuple[Measured, Measured] | None = None
    focal_length_px: Measured | None = None
    calibration: LensCalibration | None = None
    roll_rad: Measured | None = None


@final
@dataclass(frozen=True, kw_only=True)
class Rig:
    """All that a person measured on the rig; ``source`` and ``sha256`` say where it was read.

    ``latency`` and ``clock`` are None where rig.toml has no such section.
    """

    wheel: Wheel = field(default_factory=Wheel)
    light_gates: LightGates
    mask_opening: MaskOpening
    camera: CameraOptics = field(default_factory=CameraOptics)
    latency: Latency | None = None
    clock: Clock | None = None
    source: str = ""
    sha256: str = ""
