"""What a laboratory wants recorded, as it stands in plan.toml: devices, camera, wiring, runs, temperatures, references."""

from dataclasses import dataclass, field
from typing import Literal, final

from irtiming.records.frame_events import FrameEvent
from irtiming.records.recording import CameraType, ReadoutMode

ReferenceTime = Literal["before", "after", "both"]


@final
@dataclass(frozen=True, kw_only=True)
class DeviceAddresses:
    """Where each device is; a wheel may run by itself, and a blackbody be set by hand.

    ``speed`` is for a simulated rig: its seconds per second of this computer.
    """

    camera: str
    trigger_generator: str
    chopper: str | None = None
    blackbody: str | None = None
    speed: float = 1.0


@final
@dataclass(frozen=True, kw_only=True)
class CameraWishes:
    """How the camera is to be set; features have their names of GenICam SFNC, and are set in this order.

    ``frame_event`` is what a frame's delay counts from: its trigger, or, of a camera that runs free, something else.
    """

    camera_type: CameraType
    readout_mode: ReadoutMode | None = None
    integration_time_s: float | None = None
    bit_depth: int | None = None
    features: tuple[tuple[str, str], ...] = ()
    serial_number: str = ""
    correction: str = ""
    frame_event: FrameEvent = "trigger"

    @property
    def runs_free(self) -> bool:
        """Whether the camera makes frames without triggers."""
        return self.frame_event != "trigger"


@final
@dataclass(frozen=True, kw_only=True)
class WiringWishes:
    """How the lines of the trigger generator are wired; ``falling`` are those whose falling edge counts."""

    falling: tuple[str, ...] = ()
    glitch_filter_s: float = 0.0
    camera_pulse_s: float = 1e-3
    camera_input: bool = False
    spare: bool = False


@final
@dataclass(frozen=True, kw_only=True)
class TriggerWishes:
    """Wheel speeds, frame rate, samples and delays in exact text, as options of ``irtiming plan`` take them.

    ``clock_hz`` is None where the trigger generator's own clock will do. Limits that are None follow from the tolerances.
    """

    wheel_hz: tuple[str, ...]
    frame_hz: str
    samples: str
    delays: tuple[str, ...] = ("0 s",)
    repeats: str = "1"
    frame_hz_exact: bool = False
    tolerance: str = "1%"
    control_slots: str = "100"
    between_corrections: str | None = None
    clock_hz: str | None = None
    wheel_tolerance: str | None = None
    frame_hz_limits: tuple[str | None, str | None] = (None, None)
    samples_limits: tuple[str | None, str | None] = (None, None)


@final
@dataclass(frozen=True, kw_only=True)
class BlackbodyWishes:
    """Temperatures before which all runs are made, one after the other, and how steady they must be."""

    temperatures_k: tuple[float, ...]
    settle_within_s: float = 1800.0
    tolerance_k: float = 0.1


@final
@dataclass(frozen=True, kw_only=True)
class ReferenceWishes:
    """Frames of the bare blackbody at two temperatures; from ``file`` where they were recorded earlier.

    ``command`` takes wheel and mask out of the way, and brings them back, where no person is to be asked: it is run with
    ``remove`` or ``insert`` as its last word.
    """

    low_k: float | None = None
    high_k: float | None = None
    frames: int = 50
    when: ReferenceTime = "before"
    file: str = ""
    command: str = ""


MEASURANDS = (
    "trigger_delay", "exposure_midpoint_delay", "trigger_delay_falling", "trigger_delay_rising", "integration_time",
    "relative_delay", "time_constant", "row_delay", "strobe_delay", "timestamp_delay",
)  # fmt: skip
"""What an uncertainty may be wished for; the relative delay is the least sure one of a series."""


@final
@dataclass(frozen=True, kw_only=True)
class StopWishes:
    """What ends a series early, and what is switched off after it; uncertainties are named as in a result, s."""

    chopper: bool = False
    uncertainty_s: tuple[tuple[str, float], ...] = ()


@final
@dataclass(frozen=True, kw_only=True)
class SeriesPlan:
    """All of plan.toml. Either ``plan_file`` names the runs, or ``triggers`` what to wish for."""

    devices: DeviceAddresses
    camera: CameraWishes
    wiring: WiringWishes = field(default_factory=WiringWishes)
    plan_file: str = ""
    triggers: TriggerWishes | None = None
    blackbody: BlackbodyWishes | None = None
    references: ReferenceWishes | None = None
    stop: StopWishes = field(default_factory=StopWishes)
    file_name: str
    source: str = ""
    sha256: str = ""
