"""One uninterrupted series of frames, triggered or of a camera that runs free, with the timestamps taken beside it."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal, Protocol, final

import numpy as np

from irtiming.records.arrays import Array, Pixels, Ticks
from irtiming.records.camera_frame import CameraIdentity
from irtiming.records.camera_settings import CameraSettings
from irtiming.records.finding import Finding
from irtiming.records.frame_events import FrameEvent, FrameEvents
from irtiming.records.short_repr import short_repr

CameraType = Literal["photon", "microbolometer"]
ReadoutMode = Literal["snapshot", "rolling"]
TimestampClock = Literal["camera", "computer"]
USUAL_READOUT: Mapping[CameraType, ReadoutMode] = {"photon": "snapshot", "microbolometer": "rolling"}
"""How cameras of a type are read where it is not stated."""
FEWEST_FRAMES = 100
"""With fewer frames that show the wheel no timing is determined."""


class FrameStack(Protocol):
    """Frames that are read block by block: a recording is never in memory as a whole."""

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of frames, rows and columns."""
        ...

    def blocks(self) -> Iterator[tuple[int, Pixels]]:
        """Index of the first frame and values (frame, row, column), block after block, in order.

        A block is valid until the next one is asked for.
        """
        ...

    def pick(self, indices: list[int]) -> Pixels:
        """The named frames, shape (len(indices), row, column)."""
        ...


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class NonuniformityReference:
    """Mean frames of the bare blackbody at two temperatures, shape (row, column), DN.

    ``low_noise_dn`` and ``high_noise_dn`` are the standard deviations over the reference frames, same shape.
    ``low_frames`` and ``high_frames`` are the raw stacks, where they are at hand: an archive is written from them.
    """

    __repr__ = short_repr

    low_dn: Array
    high_dn: Array
    low_noise_dn: Array
    high_noise_dn: Array
    n_frames: int
    low_temperature_k: float | None = None
    high_temperature_k: float | None = None
    low_frames: FrameStack | None = None
    high_frames: FrameStack | None = None


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Recording:
    """One recording; all ticks are values of one free-running counter.

    ``frame_number[i]`` is the index in ``camera_trigger_ticks`` of the trigger that made frame i: a gap is a lost frame.
    ``camera_trigger_ticks`` are nominal triggers, before ``trigger_delay_time_set_s`` is added.
    ``lost_after_ticks`` has the last known time before each loss of timestamps; empty: none was lost, None: not known.
    ``start_time`` is text in ISO 8601, empty where unknown. Shapes: frame_number (n_frame,), each ticks array (n_edge,).
    ``frame_event`` says what a frame's delay counts from: its trigger, or, where the camera runs free, its strobe
    (``camera_input_ticks``), its time stamp or its arrival; there are then no triggers, and ``frame_number`` is the camera's
    count. Clock exchanges, shape (n_exchange,): a clock was read at ``..._ticks`` between ``..._before_s`` and ``..._after_s``
    of this computer's clock; ``counter_exchange`` of the counter, ``camera_exchange`` of the camera's clock.
    ``timestamp_clock`` says whose time ``frame_timestamp_ticks`` are. ``events`` is what placing the events in counter time
    found; None until then, or of triggers. What the camera and this computer said of each frame is kept as it came, shape
    (n_frame,): ``frame_id``, ``frame_timestamp_ticks`` of the camera's own clock of ``timestamp_frequency_hz``, and
    ``frame_host_time_s``. ``ending`` is "complete", or why the recording ended early; empty where unknown. ``findings`` are the
    warnings of its file, which do not stop an analysis. ``is_simulated`` says that no camera made it, as far as the file tells.
    """

    __repr__ = short_repr

    name: str
    camera_type: CameraType
    readout_mode: ReadoutMode
    frames: FrameStack
    frame_number: Ticks
    clock_frequency_hz: float
    camera_trigger_ticks: Ticks
    control_slot_ticks: Ticks
    application_slot_ticks: Ticks
    application_edge_ticks: Ticks | None = None
    lost_after_ticks: Ticks | None = None
    camera_trigger_delayed_ticks: Ticks | None = None
    camera_input_ticks: Ticks | None = None
    spare_ticks: Ticks | None = None
    rotation_speed_hz: float
    integration_time_s: float | None = None
    trigger_delay_time_set_s: float = 0.0
    bit_depth: int = 16
    camera_period_ticks: int | None = None
    wheel_period_ticks: int | None = None
    blackbody_temperature_k: float | None = None
    nonuniformity: NonuniformityReference | None = None
    frame_id: Ticks | None = None
    frame_timestamp_ticks: Ticks | None = None
    timestamp_frequency_hz: float | None = None
    timestamp_clock: TimestampClock = "camera"
    frame_host_time_s: Array | None = None
    frame_event: FrameEvent = "trigger"
    counter_exchange_before_s: Array | None = None
    counter_exchange_ticks: Ticks | None = None
    counter_exchange_after_s: Array | None = None
    camera_exchange_before_s: Array | None = None
    camera_exchange_ticks: Ticks | None = None
    camera_exchange_after_s: Array | None = None
    events: FrameEvents | None = None
    camera: CameraIdentity | None = None
    settings: CameraSettings = field(default_factory=CameraSettings)
    start_time: str = ""
    ending: str = ""
    program_version: str = ""
    is_simulated: bool = False
    source: str = ""
    sha256: str = ""
    findings: tuple[Finding, ...] = ()

    @property
    def frame_period_s(self) -> float | None:
        """Nominal time from trigger to trigger, s: as stated, else the median of the timestamps; None of a single one."""
        if self.camera_period_ticks is not None:
            return self.camera_period_ticks / self.clock_frequency_hz
        steps = np.diff(self.camera_trigger_ticks)
        return float(np.median(steps)) / self.clock_frequency_hz if steps.size else None
