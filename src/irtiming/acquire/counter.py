"""The trigger generator's counter beside this computer's clock: when a tick was, at the earliest."""

from bisect import bisect_right
from time import monotonic
from typing import final

from irtiming.gateware.event_model import COUNTER_CYCLES
from irtiming.instruments.protocols import TriggerGenerator

_READINGS = 16
"""Of which the one that says most counts; all within some seconds."""


@final
class Counter:
    """Readings of the counter, unwrapped, each with the time of this computer at which it was asked for.

    ``speed`` is seconds of the generator per second of this computer.
    """

    def __init__(self, generator: TriggerGenerator, *, speed: float = 1.0) -> None:
        self._generator = generator
        self._ticks_per_s = generator.clock_frequency_hz * speed
        self._ticks: list[int] = []
        self._asked_s: list[float] = []

    async def now(self) -> int:
        """The counter now, kept for `earliest_s`."""
        asked_s = monotonic()
        ticks = await self._generator.counter_ticks()
        if self._ticks:
            ticks = self._ticks[-1] + (ticks - self._ticks[-1]) % COUNTER_CYCLES
        self._ticks.append(ticks)
        self._asked_s.append(asked_s)
        return ticks

    def earliest_s(self, ticks: int) -> float:
        """Time of this computer, monotonic clock, before which the counter cannot have stood at a tick.

        A reading says that its tick came after it was asked for, and a later tick came as much later as lies between, or still
        later where a simulated device is held up. So readings after a tick tell nothing of it; nor do old ones, as no two
        clocks agree for long.
        """
        after = bisect_right(self._ticks, ticks)
        near = range(max(0, after - _READINGS), max(1, after))
        return max(self._asked_s[k] + (ticks - self._ticks[k]) / self._ticks_per_s for k in near)

    def pace(self) -> float | None:
        """Counter's time over this computer's, as it was said to be: 1 if both clocks are right; None after few readings."""
        if len(self._ticks) < 2 or self._asked_s[-1] == self._asked_s[0]:
            return None
        return (self._ticks[-1] - self._ticks[0]) / self._ticks_per_s / (self._asked_s[-1] - self._asked_s[0])
