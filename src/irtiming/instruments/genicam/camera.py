"""A triggered GenICam camera, whatever brings its registers and frames: the `Camera` of a measurement."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from time import monotonic
from typing import Protocol, TypeVar, final

from irtiming.errors import InstrumentError, InstrumentRefused
from irtiming.instruments.frame_queue import FrameQueue, frames_that_fit
from irtiming.instruments.genicam.camera_trigger import (
    FoundTriggers,
    found_triggers,
    prepare_free,
    prepare_trigger,
    restore_triggers,
)
from irtiming.instruments.genicam.features import Features
from irtiming.instruments.genicam.frame_numbers import FrameNumbers
from irtiming.records.camera_frame import CameraFrame, CameraIdentity, CameraSetup, StreamCounts
from irtiming.records.clock_exchange import ClockExchange

Result = TypeVar("Result")

_LATCHES = (("TimestampLatch", "TimestampLatchValue"), ("GevTimestampControlLatch", "GevTimestampValue"))
"""Command and value by which a camera tells its clock, in words of GenICam SFNC, the newer first."""


class Link(Protocol):
    """Connection to a camera. All calls block; all errors are `InstrumentError`."""

    name: str
    identity: CameraIdentity
    features: Features
    tick_frequency_hz: float
    heartbeat_s: float
    first_number: int

    def require_control(self) -> None:
        """Nothing, if the camera is there and under this program's control."""
        ...

    def start_stream(self, setup: CameraSetup, *, queue: FrameQueue, numbers: FrameNumbers) -> None:
        """Receive frames into the queue from now on; a failure ends it."""
        ...

    def stop_stream(self) -> None:
        """Receive what is on its way and end the queue; again does no harm."""
        ...

    def release(self) -> None:
        """Give the camera back; again does no harm."""
        ...


@asynccontextmanager
async def connected_by(open_link: Callable[[], Link]) -> AsyncIterator["GenicamCamera"]:
    """Camera behind a link, for the length of an ``async with`` block.

    Parameters
    ----------
    open_link
        Opens it; it blocks, and is called in a thread.
    """
    opening = asyncio.ensure_future(asyncio.to_thread(open_link))
    try:
        link = await asyncio.shield(opening)
    except asyncio.CancelledError:
        with suppress(InstrumentError):
            (await opening).release()
        raise
    camera = GenicamCamera(link)
    try:
        yield camera
    finally:
        await camera.close()


@final
class GenicamCamera:
    """Camera behind a link; calls wait for each other, and block nothing else."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._lock = asyncio.Lock()
        self._queue: FrameQueue | None = None
        self._numbers = FrameNumbers()
        self._found: FoundTriggers | None = None
        self._watch: asyncio.Task[None] | None = None
        self._is_armed = False
        self._is_open = True

    @property
    def name(self) -> str:
        """For messages."""
        return self._link.name

    @property
    def identity(self) -> CameraIdentity:
        """What it says of itself."""
        return self._link.identity

    async def feature(self, name: str) -> str:
        """Value of a feature.

        Parameters
        ----------
        name
            In words of GenICam SFNC.

        Raises
        ------
        InstrumentError
            If there is no such feature, it cannot be read, or the camera does not answer.
        """
        return await self._call(lambda: self._link.features.read(name))

    async def set_feature(self, name: str, *, value: str) -> str:
        """Set a feature and read it back.

        Parameters
        ----------
        name
            In words of GenICam SFNC.
        value
            As one would type it; ``execute`` for a command, such as a non-uniformity correction.

        Raises
        ------
        InstrumentError
            If there is no such feature, it cannot be set to this value, or the camera does not answer.
        """
        return await self._call(lambda: self._link.features.write(name, value=value))

    async def arm(self, *, free_hz: float | None = None) -> CameraSetup:
        """Hardware trigger on, 16 bits per pixel, and acquisition started.

        Parameters
        ----------
        free_hz
            With it triggers are off, and the camera makes frames by itself at this rate, if that can be set.

        Returns
        -------
        What the camera then says of its settings.

        Raises
        ------
        InstrumentError
            If the camera is armed already, has no hardware trigger or no such pixels, or does not answer.
        """
        if self._is_armed:
            raise InstrumentRefused(f"{self.name} is armed already; disarm it first")
        setup = await self._call(lambda: self._prepare(free_hz))
        queue = FrameQueue(capacity=frames_that_fit(2 * setup.rows * setup.columns))
        self._numbers = FrameNumbers(last_number=self._numbers.last_number, first_number=self._link.first_number)
        self._queue, self._is_armed = queue, True
        try:
            await self._call(lambda: self._start(setup, queue))
        except InstrumentError:
            with suppress(InstrumentError):
                await self.disarm()
            raise
        self._watch = asyncio.create_task(self._watch_over(queue))
        return setup

    def frames(self) -> AsyncIterator[CameraFrame]:
        """Frames since `arm` as they arrive, until `disarm`.

        Raises
        ------
        InstrumentError
            If the camera was never armed; after the frames that had arrived, if it fell silent.
        """
        if self._queue is None:
            raise InstrumentRefused(f"{self.name} has no frames before it is armed")
        return self._queue.frames()

    async def disarm(self) -> StreamCounts:
        """End the acquisition; `frames` ends when it has given what had arrived.

        Returns
        -------
        How the frames came.

        Raises
        ------
        InstrumentError
            If the camera does not take it, unless `frames` tells of a failure anyway.
        """
        if not self._is_armed or self._queue is None:
            return self.counts()
        self._is_armed = False
        if self._watch is not None:
            self._watch.cancel()
        problem: InstrumentError | None = None
        try:
            await self._call(self._stop)
        except InstrumentError as error:
            problem = error
        await self._call(self._link.stop_stream)
        self._queue.end()
        with suppress(InstrumentError):
            await self._call(lambda: self._lock_settings(False))
        if problem is not None and self._queue.failure is None:
            raise problem
        return self.counts()

    async def clock_exchange(self) -> ClockExchange | None:
        """The camera's clock between two looks at this computer's; None where it cannot be latched.

        Raises
        ------
        InstrumentError
            If the camera does not answer.
        """
        return await self._call(self._latched)

    def counts(self) -> StreamCounts:
        """How the frames came so far."""
        return self._queue.counts() if self._queue is not None else StreamCounts()

    async def close(self) -> None:
        """Give the camera back, with its triggers as they were; again does no harm."""
        if not self._is_open:
            return
        self._is_open = False
        with suppress(InstrumentError):
            await self.disarm()
        with suppress(InstrumentError):
            await self._call(self._restore)
        await self._call(self._link.release)

    async def _call(self, action: Callable[[], Result]) -> Result:
        async with self._lock:
            return await asyncio.to_thread(action)

    def _prepare(self, free_hz: float | None) -> CameraSetup:
        link = self._link
        if self._found is None:
            self._found = found_triggers(link.features)
        clock_hz = link.tick_frequency_hz
        if free_hz is None:
            return prepare_trigger(link.features, name=link.name, timestamp_frequency_hz=clock_hz)
        return prepare_free(link.features, name=link.name, timestamp_frequency_hz=clock_hz, frame_rate_hz=free_hz)

    def _latched(self) -> ClockExchange | None:
        features = self._link.features
        for command, value in _LATCHES:
            if features.has(value):
                before_s = monotonic()
                features.execute(command)
                after_s = monotonic()
                features.forget()
                return ClockExchange(before_s=before_s, ticks=int(features.number(value)), after_s=after_s)
        return None

    def _start(self, setup: CameraSetup, queue: FrameQueue) -> None:
        self._link.start_stream(setup, queue=queue, numbers=self._numbers)
        self._lock_settings(True)
        self._link.features.execute("AcquisitionStart")

    def _stop(self) -> None:
        self._link.features.execute("AcquisitionStop")

    def _lock_settings(self, is_locked: bool) -> None:
        """Some cameras start only on command; most have no such feature for this program to set."""
        if self._link.features.has("TLParamsLocked"):
            self._link.features.write("TLParamsLocked", value=str(int(is_locked)))

    def _restore(self) -> None:
        if self._found is not None and self._link.features.has("TriggerMode"):
            restore_triggers(self._link.features, found=self._found)

    async def _watch_over(self, queue: FrameQueue) -> None:
        """A camera that waits for triggers and one that is unplugged are both quiet; only the heartbeat tells."""
        while True:
            await asyncio.sleep(self._link.heartbeat_s)
            try:
                await asyncio.to_thread(self._link.require_control)
            except InstrumentError as error:
                queue.end(error)
                return
