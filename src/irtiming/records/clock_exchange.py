"""One look at another clock between two looks at this computer's."""

from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True, kw_only=True)
class ClockExchange:
    """The other clock stood at ``ticks`` at some moment between ``before_s`` and ``after_s`` of this computer's monotonic clock.

    Whatever the way there and back took, the moment lies between the two: that is all that is claimed.
    """

    before_s: float
    ticks: int
    after_s: float

    def at_speed(self, speed: float) -> "ClockExchange":
        """The same in seconds of a simulated rig, of which ``speed`` go by in one of this computer's."""
        return ClockExchange(before_s=self.before_s * speed, ticks=self.ticks, after_s=self.after_s * speed)
