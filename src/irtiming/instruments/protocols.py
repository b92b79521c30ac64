"""What a measurement asks of its devices; a driver, a simulation or a test's own thing may stand behind each."""

from collections.abc import AsyncIterator
from typing import Protocol

from irtiming.instruments.generator.timestamp_stream import Stamp
from irtiming.records.camera_frame import CameraFrame, CameraIdentity, CameraSetup, StreamCounts
from irtiming.records.clock_exchange import ClockExchange
from irtiming.records.instrument_state import BlackbodyState, ChopperState
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

    async def clock_exchange(self) -> ClockExchange:
        """The counter between two looks at this computer's monotonic clock, as close together as the line allows."""
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


class Camera(Protocol):
    """Camera that makes one frame per edge at its trigger input, or runs free; features have their names of GenICam SFNC.

    In order: `arm`, `frames`, `disarm`; all errors are `InstrumentError`. Opening one changes no setting.
    """

    @property
    def name(self) -> str:
        """For messages."""
        ...

    @property
    def identity(self) -> CameraIdentity:
        """What it says of itself."""
        ...

    async def feature(self, name: str) -> str:
        """Value of any feature by its standard name, such as ``"TriggerSource"``, as text."""
        ...

    async def set_feature(self, name: str, *, value: str) -> str:
        """Set a feature, read it back and give what it holds, or ``execute`` a command; `InstrumentRefused` if it cannot be."""
        ...

    async def arm(self, *, free_hz: float | None = None) -> CameraSetup:
        """16 bits per pixel, and acquisition started: from now on each trigger makes a frame.

        With ``free_hz`` triggers are off, and the camera makes frames by itself, at that rate as far as it can be set.
        """
        ...

    async def clock_exchange(self) -> ClockExchange | None:
        """The camera's clock between two looks at this computer's monotonic clock; None where it cannot be read."""
        ...

    def frames(self) -> AsyncIterator[CameraFrame]:
        """Frames since `arm` in the order of their identifiers, as they arrive, until `disarm`."""
        ...

    async def disarm(self) -> StreamCounts:
        """End the acquisition; `frames` ends when it has given what had arrived."""
        ...

    def counts(self) -> StreamCounts:
        """How the frames came so far."""
        ...

    async def close(self) -> None:
        """Give the camera back, with its trigger as it was set; again does no harm."""
        ...


class Chopper(Protocol):
    """Controller of the chopper wheel; opening one neither starts nor stops the wheel. All errors are `InstrumentError`."""

    @property
    def name(self) -> str:
        """For messages."""
        ...

    async def state(self) -> ChopperState:
        """All settings and readings now."""
        ...

    async def prepare(self) -> ChopperState:
        """Set it to follow the external reference with its control slots; refuse a wrong blade, and to alter a turning wheel."""
        ...

    async def start(self) -> None:
        """Let the wheel turn; one that turns already goes on undisturbed."""
        ...

    async def stop(self) -> None:
        """Let the wheel come to rest."""
        ...

    async def close(self) -> None:
        """Give the line back and leave the wheel as it is; again does no harm."""
        ...


class Blackbody(Protocol):
    """Blackbody before which the wheel turns; opening one changes no temperature. All errors are `InstrumentError`."""

    @property
    def name(self) -> str:
        """For messages."""
        ...

    async def state(self) -> BlackbodyState:
        """Temperatures now."""
        ...

    async def set_target(self, temperature_k: float) -> None:
        """Go to a temperature, K; read back."""
        ...

    async def close(self) -> None:
        """Give the line back and leave the temperature as it is; again does no harm."""
        ...
