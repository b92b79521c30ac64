"""Everything that the twin is made of, true to the last digit.

Frozen, hashable records in SI units. The defaults are the experiment of Schatz 2023, section 3.1, with a
perfect wheel; `microbolometer_scene` is that of section 3.2; `irtiming.twin.rig.draw` adds the imperfections.
Lengths lie in the rig plane: x to the right and y downwards as the camera sees them, from the axle. Angles are
polar angles in that plane, clockwise as the camera sees it.
"""

import math
from dataclasses import dataclass, field, replace
from typing import TypeAlias, final

from irtiming.errors import GeometryError, PlanError
from irtiming.records.recording import ReadoutMode
from irtiming.records.rig import Rotation
from irtiming.twin.beams import Beams
from irtiming.twin.free_running import FreeRunning
from irtiming.twin.in_camera import InCamera
from irtiming.twin.optics import Optics
from irtiming.twin.response_curve import ResponseCurve
from irtiming.twin.taps import Taps
from irtiming.twin.upkeep import Drift, SelfCorrection, Sway

_SHORTEST_LAG_S = 1e-6
FADED_TAILS = 8.0
"""Time constants after which nothing is left of a window's tail."""


@final
@dataclass(frozen=True, kw_only=True)
class ChopperWheel:
    """Wheel with two cutouts, an outer ring that passes the application gate, and a ring of control slots.

    ``ring_edges_rad`` are the angles alpha_0 .. alpha_3 of the outer ring's edges; a cutout's edge lies
    ``cutout_errors_rad`` beyond its ring edge. Control slot j lies ``control_slot_errors_rad[j]`` beyond
    its nominal angle. The cutouts reach from ``inner_radius_m`` to ``outer_radius_m``.
    """

    ring_edges_rad: tuple[float, float, float, float] = (0.0, 0.5 * math.pi, math.pi, 1.5 * math.pi)
    cutout_errors_rad: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    control_slot_errors_rad: tuple[float, ...] = (0.0,) * 100
    inner_radius_m: float = 13.0e-3
    outer_radius_m: float = 41.5e-3
    rotation: Rotation = "clockwise"

    def __post_init__(self) -> None:
        """Refuse edges that do not lie in order within one turn."""
        edges = self.cutout_edges_rad
        ordered = edges[0] < edges[1] < edges[2] < edges[3] < edges[0] + 2 * math.pi
        if not ordered or not 0 <= self.inner_radius_m < self.outer_radius_m:
            raise GeometryError(
                f"cutout edges {edges} rad between radii {self.inner_radius_m} and {self.outer_radius_m} m; "
                "edges must increase within one turn and the radii too"
            )

    @property
    def cutout_edges_rad(self) -> tuple[float, float, float, float]:
        """Angles of the cutouts' own edges, counted like alpha."""
        a, b, c, d = (edge + error for edge, error in zip(self.ring_edges_rad, self.cutout_errors_rad, strict=True))
        return (a, b, c, d)

    @property
    def control_slot_angles_rad(self) -> tuple[float, ...]:
        """True angles of the control slots' edges, slot 0 in register with edge 0."""
        pitch = 2 * math.pi / len(self.control_slot_errors_rad)
        return tuple(j * pitch + error for j, error in enumerate(self.control_slot_errors_rad))


@final
@dataclass(frozen=True, kw_only=True)
class Ripple:
    """Speed variation locked to the turn: a cosine of ``order`` times the wheel angle."""

    order: int
    relative: float
    phase_rad: float = 0.0


@final
@dataclass(frozen=True, kw_only=True)
class SpeedWander:
    """How the speed strays from the chopper's reference.

    The relative speed error is a random walk that forgets itself in ``correlation_time_s`` and that the
    controller pulls back to the phase of its reference within ``lock_time_s``; ``relative`` is its standard
    deviation.
    """

    relative: float = 1e-4
    correlation_time_s: float = 0.5
    lock_time_s: float = 0.5
    ripples: tuple[Ripple, ...] = (
        Ripple(order=1, relative=2e-6),
        Ripple(order=2, relative=1e-6, phase_rad=1.0),
    )


@final
@dataclass(frozen=True, kw_only=True)
class MaskPlate:
    """Plate with an annular sector cut out about a centre of its own, which may lie off the axle."""

    opening_angle_rad: float = math.radians(75.0)
    centre_angle_rad: float = math.radians(-90.0)
    inner_radius_m: float = 15.0e-3
    outer_radius_m: float = 39.5e-3
    centre_x_m: float = 0.0
    centre_y_m: float = 0.0


@final
@dataclass(frozen=True, kw_only=True)
class Radiance:
    """What the camera sees, as temperatures.

    A mean pixel gives ``base_dn`` at 288.15 K and ``dn_per_k`` more per kelvin. A straight line is enough:
    the two-point correction and the normalisation take out any monotonic curve. ``narcissus_dn`` is missing
    at the image centre where solid wheel mirrors the cold detector, as a Gaussian of
    ``narcissus_radius_m``; negative where it mirrors a warm camera. The blade between edges 2 and 3 is ``blade_share`` of
    the contrast of blackbody and wheel warmer than the other. References are taken anew for each recording where they are
    ``references_anew``, else once for all.
    """

    blackbody_k: float = 303.15
    wheel_k: float = 294.15
    mask_k: float = 294.35
    narcissus_dn: float = 200.0
    narcissus_radius_m: float = 6.0e-3
    base_dn: float = 1000.0
    dn_per_k: float = 530.0
    reference_low_k: float = 288.15
    reference_high_k: float = 303.15
    reference_frames: int = 50
    blade_share: float = 0.0
    references_anew: bool = False

    @property
    def blade_dn(self) -> float:
        """By how much a mean pixel gives more before the blade between edges 2 and 3 than before the other, DN."""
        return self.blade_share * abs(self.dn_per_k * (self.blackbody_k - self.wheel_k))

    def level_dn(self, temperature_k: float) -> float:
        """Value of a mean pixel that sees nothing but this temperature, DN."""
        return self.base_dn + self.dn_per_k * (temperature_k - 288.15)


@final
@dataclass(frozen=True, kw_only=True)
class Detector:
    """Pixels and their faults; ``pattern_seed`` fixes gain, offset and place of the dead ones.

    ``noise_dn`` is drawn for each pixel, ``row_noise_dn`` for each row of each frame; both are beside the response's ``curve``.
    """

    rows: int = 512
    columns: int = 640
    bits: int = 14
    saturation_dn: float = 16383.0
    gain_spread: float = 0.02
    offset_spread_dn: float = 60.0
    noise_dn: float = 20.0
    dead_pixels: int = 0
    pattern_seed: int = 0
    row_noise_dn: float = 0.0
    curve: ResponseCurve = field(default_factory=ResponseCurve)


@final
@dataclass(frozen=True, kw_only=True)
class CameraTiming:
    """Photon camera: light counts from ``trigger_delay_s`` after the trigger for ``integration_time_s``.

    In a rolling camera, row y begins y ``row_delay_s`` later, which is None for a snapshot. ``jitter_s`` is the standard
    deviation of the start; ``substeps`` instants stand for the window.

    The window rises within ``rise_s`` and falls within ``fall_s``, both straight lines about its start and end. A share
    ``tail_share`` of all that counts comes after the end and fades with ``tail_s``. The camera says that it integrates
    ``count_time_error_s`` longer than it does.
    """

    trigger_delay_s: float = 412.7e-6
    integration_time_s: float = 250e-6
    row_delay_s: float | None = None
    jitter_s: float = 0.05e-6
    substeps: int = 16
    rise_s: float = 0.0
    fall_s: float = 0.0
    tail_share: float = 0.0
    tail_s: float = 0.3e-3
    count_time_error_s: float = 0.0

    @property
    def is_rectangular(self) -> bool:
        """Whether all instants from start to end count alike, and no others."""
        return self.rise_s == self.fall_s == self.tail_share == 0

    @property
    def after_s(self) -> float:
        """How long after the window's end something still counts."""
        return self.fall_s / 2 + (FADED_TAILS * self.tail_s if self.tail_share else 0.0)


@final
@dataclass(frozen=True, kw_only=True)
class RadiativeExchange:
    """Heat that a pixel exchanges with what it sees, by Planck's law within the band.

    ``scene_time_constant_s`` is its time constant for a pixel at ``reference_k``; ``substrate_k`` is the temperature of
    the detector's substrate, to which the pixel returns with the time constant of `BolometerTiming`.
    """

    scene_time_constant_s: float
    substrate_k: float = 303.15
    reference_k: float = 300.0
    band_m: tuple[float, float] = (7.5e-6, 14e-6)

    def __post_init__(self) -> None:
        """Refuse what is no exchange."""
        if not (_SHORTEST_LAG_S <= self.scene_time_constant_s < math.inf and self.substrate_k > 0):
            raise PlanError(
                f"scene time constant of {self.scene_time_constant_s} s with a substrate of {self.substrate_k} K; they must "
                f"be at least {_SHORTEST_LAG_S * 1e6:g} us and above 0 K: check the units"
            )


@final
@dataclass(frozen=True, kw_only=True)
class BolometerTiming:
    """Microbolometer: row y is read ``trigger_delay_s`` + y ``row_delay_s`` after the trigger.

    Each pixel follows what it sees with ``time_constant_s``; with a ``radiative`` exchange it is not linear, and
    ``time_constant_s`` is that of the exchange with the substrate alone. ``row_delay_s`` is negative where the last row
    is read first, and None for a snapshot. ``jitter_s`` is the standard deviation of the whole frame's delay.
    """

    trigger_delay_s: float = 3.872e-3
    time_constant_s: float = 4.819e-3
    row_delay_s: float | None = 38.76e-6
    jitter_s: float = 0.05e-6
    radiative: RadiativeExchange | None = None

    def __post_init__(self) -> None:
        """Refuse a pixel that does not lag."""
        if not _SHORTEST_LAG_S <= self.time_constant_s < math.inf:
            raise PlanError(
                f"time constant of {self.time_constant_s} s; a microbolometer's must be at least "
                f"{_SHORTEST_LAG_S * 1e6:g} us: check the unit"
            )


Timing: TypeAlias = CameraTiming | BolometerTiming
"""When a camera takes its values: its class is the pixels' response, whether it has a row delay the readout."""


def readout_mode_of(timing: Timing) -> ReadoutMode:
    """How a camera reads its rows."""
    return "snapshot" if timing.row_delay_s is None else "rolling"


@final
@dataclass(frozen=True, kw_only=True)
class TriggerGenerator:
    """Clock, periods T and C in ticks, and the run: how many triggers, from which count and angle on.

    ``start_angle_rad`` is the angle the chopper's reference asks for at the first trigger; edges are
    timestamped from ``lead_turns`` before it. The clock runs at ``clock_frequency_hz`` (1 + ``clock_relative_error``); an edge
    is at the camera's connector ``late_trigger_s`` after its timestamp.
    """

    clock_frequency_hz: float = 49_152_000.0
    turn_period_ticks: int = 16_384_000
    camera_period_ticks: int = 1_622_016
    n_triggers: int = 1000
    trigger_delay_time_set_s: float = 0.0
    counter_start_ticks: int = 200_000_000
    start_angle_rad: float = 1.0
    lead_turns: float = 2.0
    clock_relative_error: float = 0.0
    late_trigger_s: float = 0.0

    @property
    def wheel_hz(self) -> float:
        """Nominal turns per second."""
        return self.clock_frequency_hz / self.turn_period_ticks

    @property
    def true_frequency_hz(self) -> float:
        """Ticks in a second."""
        return self.clock_frequency_hz * (1 + self.clock_relative_error)

    @property
    def true_wheel_hz(self) -> float:
        """Turns in a second that the chopper's reference asks for."""
        return self.true_frequency_hz / self.turn_period_ticks


@final
@dataclass(frozen=True, kw_only=True)
class EdgeFaults:
    """How many timestamps of one channel are missing, come twice within microseconds, or from nowhere."""

    missing: int = 0
    doubled: int = 0
    spurious: int = 0


@final
@dataclass(frozen=True, kw_only=True)
class Faults:
    """What goes wrong in a run."""

    lost_frames: int = 0
    control_slot: EdgeFaults = EdgeFaults()
    application: EdgeFaults = EdgeFaults()


@final
@dataclass(frozen=True, kw_only=True)
class Scene:
    """The whole simulated experiment; every number is the true one.

    The kind of ``timing`` is the kind of camera. ``free`` is None of a camera that is triggered; where it is not, ``trigger``
    still has the period of the frames and how many there are.
    """

    wheel: ChopperWheel = field(default_factory=ChopperWheel)
    wander: SpeedWander = field(default_factory=SpeedWander)
    beams: Beams = field(default_factory=Beams)
    mask: MaskPlate = field(default_factory=MaskPlate)
    optics: Optics = field(default_factory=Optics)
    radiance: Radiance = field(default_factory=Radiance)
    detector: Detector = field(default_factory=Detector)
    timing: Timing = field(default_factory=CameraTiming)
    trigger: TriggerGenerator = field(default_factory=TriggerGenerator)
    faults: Faults = field(default_factory=Faults)
    correction: SelfCorrection = field(default_factory=SelfCorrection)
    drift: Drift = field(default_factory=Drift)
    sway: Sway = field(default_factory=Sway)
    in_camera: InCamera = field(default_factory=InCamera)
    taps: Taps = field(default_factory=Taps)
    free: FreeRunning | None = None


def paper_scene(rows: int = 512, columns: int = 640) -> Scene:
    """Experiment of Schatz 2023, section 3.1, with the wheel filling an image of this size.

    Raises
    ------
    GeometryError
        If the image is smaller than 16 rows or columns: the opening would be a few pixels.
    """
    _refuse_tiny(rows, columns)
    optics = Optics(
        pixel_pitch_m=0.1024 / min(rows, columns),
        wheel_centre_row_px=(rows - 1) / 2,
        wheel_centre_column_px=(columns - 1) / 2,
    )
    return Scene(optics=optics, detector=Detector(rows=rows, columns=columns))


def microbolometer_scene(rows: int = 480, columns: int = 640) -> Scene:
    """Experiment of Schatz 2023, section 3.2: cold blackbody, wheel that fills the image.

    The mask's opening is 193 of 480 rows high; smaller images show the same with fewer pixels. The row delay
    stays that of the paper.

    Raises
    ------
    GeometryError
        If the image is smaller than 16 rows or columns: the opening would be a few pixels.
    """
    _refuse_tiny(rows, columns)
    return Scene(
        wheel=ChopperWheel(inner_radius_m=6.8e-3),
        mask=MaskPlate(inner_radius_m=8.1e-3, outer_radius_m=40.2e-3),
        optics=Optics(
            pixel_pitch_m=0.084 / min(rows, columns),
            wheel_centre_row_px=(rows - 1) / 2 + 0.02 * min(rows, columns),
            wheel_centre_column_px=(columns - 1) / 2,
        ),
        radiance=Radiance(
            blackbody_k=288.15,
            wheel_k=296.15,
            mask_k=296.45,
            narcissus_dn=-100.0,
            narcissus_radius_m=15.0e-3,
            base_dn=6000.0,
            dn_per_k=80.0,
        ),
        detector=Detector(
            rows=rows,
            columns=columns,
            bits=16,
            saturation_dn=65535.0,
            gain_spread=0.01,
            offset_spread_dn=4.0,
            noise_dn=5.0,
        ),
        timing=BolometerTiming(),
    )


def _refuse_tiny(rows: int, columns: int) -> None:
    if min(rows, columns) < 16:
        raise GeometryError(f"image of {rows} x {columns} pixels; the twin needs at least 16 x 16 to show a wheel")


def with_wheel_speed(scene: Scene, wheel_hz: float, *, frame_hz: float = 30.303, samples: int = 1000) -> Scene:
    """Same experiment at another speed, in whole ticks, with frames as near ``frame_hz`` as can be.

    Raises
    ------
    PlanError
        If the clock is too slow for so many samples, or the wheel too fast for any frame between them.
    """
    interval = round(scene.trigger.clock_frequency_hz / (wheel_hz * samples)) if wheel_hz > 0 else 0
    if interval < 1 or samples < 1 or frame_hz <= 0:
        raise PlanError(
            f"{samples} samples per turn at {wheel_hz} Hz and {frame_hz} frames per second; numbers must be "
            f"positive and leave each sample at least one of {scene.trigger.clock_frequency_hz:.0f} ticks/s"
        )
    wanted = scene.trigger.clock_frequency_hz / (frame_hz * interval)
    around = range(max(1, round(wanted) - samples), round(wanted) + samples + 1)
    steps = min((n for n in around if math.gcd(n, samples) == 1), key=lambda n: abs(n - wanted))
    trigger = replace(
        scene.trigger,
        turn_period_ticks=interval * samples,
        camera_period_ticks=interval * steps,
        n_triggers=samples,
    )
    return replace(scene, trigger=trigger)
