"""What a measurement asks of its devices; a driver, a simulation or a test's own thing may stand behind each."""

from collections.abc import AsyncIterator
from typing import Protocol

from irtiming.instruments.timestamp_stream import Stamp
from irtiming.records.timestamps import Timestamps
from irtiming.records.trigger_plan import PlannedRun


class TriggerGenerator(Protocol):
    """Device that drives chopper and camera from one clock and stamps every edge with it (Schatz 2023, 2.2).

    In order: `load`, `arm`, `start`, `stop`; all errors are `InstrumentError`.
    """

    @property
    def name(self) -> str:
        """For messages."""
        ...

    @property
    def clock_frequency_hz(self) -> int:
        """Of the device's own clock: plans must be made for it."""
        ...

    async def load(self, run: PlannedRun, *, clock_frequency_hz: int) -> None:
        """Set the periods, delay and number of triggers of a run that was planned for this clock; the chopper follows."""
        ...

    async def arm(self) -> None:
        """Check that the device holds what was loaded, forget earlier timestamps and begin to record."""
        ...

    async def start(self) -> None:
        """Begin the train of camera triggers."""
        ...

    async def counter_ticks(self) -> int:
        """The device's counter now."""
        ...

    async def has_finished(self) -> bool:
        """Whether all camera triggers are over."""
        ...

    def stamps(self) -> AsyncIterator[Stamp]:
        """Timestamps since `arm` as they arrive, until `stop`."""
        ...

    async def stop(self) -> Timestamps:
        """End recording, fetch what still waits in the device and give all timestamps since `arm`."""
        ...

    def captured(self) -> Timestamps:
        """What arrived so far, marked as lossy unless `stop` has confirmed it."""
        ...

    async def close(self) -> None:
        """Stop the device and give its line back."""
        ...
