"""What a camera hands over while it is triggered: itself, its settings, its frames, and what became of them on the way."""

from dataclasses import dataclass, field
from typing import final

from irtiming.records.arrays import Pixels
from irtiming.records.camera_settings import CameraSettings
from irtiming.records.short_repr import short_repr

SIMULATED_VENDOR = "irtiming"
"""Maker of every camera that this program simulates; no other camera names it."""


@final
@dataclass(frozen=True, kw_only=True)
class CameraIdentity:
    """What a camera says of itself; texts are empty where it does not say."""

    vendor: str
    model: str
    serial_number: str
    firmware: str
    address: str


@final
@dataclass(frozen=True, kw_only=True)
class CameraSetup:
    """Settings of an armed camera as read back from it.

    ``timestamp_frequency_hz`` is 0 for a camera without clock. ``integration_time_s`` is None where the camera has
    no such feature. ``settings`` has what its timing may depend on besides. ``trigger_source`` and ``trigger_activation``
    are in words of GenICam SFNC.
    """

    rows: int
    columns: int
    pixel_format: str
    bit_depth: int
    trigger_source: str
    trigger_activation: str
    timestamp_frequency_hz: float = 0.0
    integration_time_s: float | None = None
    settings: CameraSettings = field(default_factory=CameraSettings)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CameraFrame:
    """One frame. ``pixels`` has shape (row, column); in a damaged one, what did not arrive is 0.

    ``frame_id`` counts the frames that the camera sent since it was armed, from 0, whatever the width of its counter
    on the wire: a gap is a frame of which nothing arrived. ``device_timestamp_ticks`` are of the camera's clock, 0 where
    it has none. ``host_time_s`` is this computer's monotonic clock when the last of the frame had come.
    """

    __repr__ = short_repr

    pixels: Pixels
    frame_id: int
    device_timestamp_ticks: int
    host_time_s: float
    packets_missing: int = 0

    @property
    def is_whole(self) -> bool:
        """Whether every pixel arrived."""
        return self.packets_missing == 0


@final
@dataclass(frozen=True, kw_only=True)
class StreamCounts:
    """How the frames came since the camera was armed.

    ``queue_dropped`` are frames that arrived whole and were lost because they were not taken in time; ``longest_queue`` is the
    largest number that waited.
    """

    frames: int = 0
    frames_damaged: int = 0
    packets_missing: int = 0
    packets_resent: int = 0
    queue_dropped: int = 0
    longest_queue: int = 0
