"""What is known of a recording before its first frame."""

from dataclasses import dataclass
from typing import Literal, final

from irtiming.records.camera_frame import CameraIdentity, CameraSetup
from irtiming.records.frame_events import FrameEvent
from irtiming.records.instrument_state import BlackbodyState, ChopperState
from irtiming.records.recording import CameraType, NonuniformityReference, ReadoutMode
from irtiming.records.trigger_plan import PlannedRun

ExchangedClock = Literal["camera", "counter"]
"""Clocks that are looked at between two looks at this computer's."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RecordingHead:
    """All that stands in the file before its first frame: what was planned, and what the instruments said of themselves.

    Periods, wheel rate and set delay are those of ``run``; size, bit depth and clock of the frames those of ``setup``;
    the blackbody's temperature is that of ``blackbody``. ``clock_frequency_hz`` is the trigger generator's.
    ``integration_time_s`` is that of a photon camera which does not tell its own, else ``setup`` has it. ``nonuniformity``
    must carry its raw stacks. ``frame_event`` is what a frame's delay counts from.
    ``start_time`` is ISO 8601; empty: the time at which the file is made, UTC.
    """

    name: str
    camera_type: CameraType
    readout_mode: ReadoutMode
    clock_frequency_hz: int
    run: PlannedRun
    camera: CameraIdentity
    setup: CameraSetup
    chopper: ChopperState | None = None
    blackbody: BlackbodyState | None = None
    integration_time_s: float | None = None
    nonuniformity: NonuniformityReference | None = None
    frame_event: FrameEvent = "trigger"
    start_time: str = ""
