"""What the frames of a camera that runs free count from, and what was found when these events were placed in counter time."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, final

from irtiming.records.arrays import Array
from irtiming.records.finding import Finding
from irtiming.records.short_repr import short_repr

FrameEvent = Literal["trigger", "strobe", "stamp", "arrival"]
"""What a delay counts from: the trigger, or, where the camera runs free, its strobe, its time stamp or the frame's arrival."""


FreeEvent = Literal["strobe", "stamp", "arrival"]
"""Those of a camera that runs free."""

DELAYS: Mapping[FrameEvent, str] = {
    "trigger": "trigger_delay", "strobe": "strobe_delay", "stamp": "timestamp_delay", "arrival": "timestamp_delay",
}  # fmt: skip
"""Name of the first delay by the event that it counts from."""

NOUNS: Mapping[FrameEvent, str] = {
    "trigger": "the trigger edge that the camera accepts", "strobe": "the edge of the camera's strobe",
    "stamp": "the frame's stamp (median)", "arrival": "the frame's arrival (median)",
}  # fmt: skip
"""The event in words."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class FrameEvents:
    """Events of the frames of one recording, one per frame.

    Parameters
    ----------
    kind
        What they are.
    period_s
        From one to the next, s of the counter.
    deviation_s
        Shape (n_frame,); of each event from the regular grid that was laid through them, s: their jitter.
    relative_rate, u_relative_rate
        By how much the clock that stamped the events is faster than the counter, and its standard uncertainty; None where the
        counter itself stamped them.
    offset_s
        Zero of that clock in the counter's time, s; None where the counter itself stamped them.
    u_grid_s
        Standard uncertainty of the grid, from the scatter of the events; 0 where each event stands by itself.
    u_clock_s
        Standard uncertainty with which the two clocks are related, from the bounds of their exchanges; 0 for the counter itself.
    findings
        What is to be said of the pairing of frames and events.
    """

    __repr__ = short_repr

    kind: FrameEvent
    period_s: float
    deviation_s: Array
    relative_rate: float | None = None
    u_relative_rate: float | None = None
    offset_s: float | None = None
    u_grid_s: float = 0.0
    u_clock_s: float = 0.0
    findings: tuple[Finding, ...] = ()
