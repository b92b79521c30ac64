"""What a camera that runs free has of its own: clocks, strobe, stamps, and the way of its frames to a computer."""

from dataclasses import dataclass
from typing import final

from irtiming.records.frame_events import FrameEvent


@final
@dataclass(frozen=True, kw_only=True)
class FreeRunning:
    """A camera that needs no trigger: its clock, what it tells of each frame, and the way of its frames to a computer.

    The camera's clock and the computer's are faster than true by their rate errors. The first frame begins ``phase`` of a period
    after what would be the first trigger; strobe and stamp come so much after a frame begins, each with its normal jitter. The
    strobe also marks some frames before and after those recorded. A frame arrives after ``arrival_shortest_s`` and a
    gamma-distributed time, a share of them later by up to ``hiccup_s``. Each way of an exchange with a clock takes its shortest
    time and an exponential one.
    """

    event: FrameEvent = "strobe"
    rate_error: float = 12e-6
    phase: float = 0.37
    strobe_after_s: float = 600e-6
    strobe_jitter_s: float = 0.1e-6
    stamp_after_s: float = 900e-6
    stamp_jitter_s: float = 50e-6
    frames_before: int = 0
    frames_after: int = 0
    timestamp_frequency_hz: float = 125e6
    camera_zero_ticks: int = 77_000_000_000
    computer_rate_error: float = -8e-6
    computer_zero_s: float = 54_321.0
    arrival_shortest_s: float = 9e-3
    arrival_shape: float = 2.0
    arrival_scale_s: float = 0.4e-3
    hiccup_share: float = 0.02
    hiccup_s: float = 20e-3
    n_exchanges: int = 60
    exchange_shortest_s: float = 30e-6
    exchange_scale_s: float = 60e-6
