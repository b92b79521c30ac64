"""Frames on their way from the thread that receives them to the program that awaits them: bounded, and every loss counted."""

import asyncio
from collections import deque
from collections.abc import AsyncIterator
from dataclasses import replace
from threading import Lock
from typing import final

from irtiming.errors import InstrumentError
from irtiming.records.camera_frame import CameraFrame, StreamCounts

_MOST_BYTES = 512 * 2**20
_FEWEST_FRAMES, _MOST_FRAMES = 64, 4096


def frames_that_fit(frame_bytes: int) -> int:
    """How many frames a queue may hold, so that a slow disk is bridged and a small computer not filled.

    Parameters
    ----------
    frame_bytes
        Of one frame.
    """
    return min(max(_MOST_BYTES // max(frame_bytes, 1), _FEWEST_FRAMES), _MOST_FRAMES)


@final
class FrameQueue:
    """Filled by one thread, emptied by the event loop in which it was made."""

    def __init__(self, *, capacity: int) -> None:
        self._capacity = capacity
        self._waiting: deque[CameraFrame] = deque()
        self._lock = Lock()
        self._loop = asyncio.get_running_loop()
        self._changed = asyncio.Event()
        self._has_ended = False
        self._failure: InstrumentError | None = None
        self._counts = StreamCounts()

    @property
    def failure(self) -> InstrumentError | None:
        """What ended the stream, if it did not end as wished."""
        return self._failure

    def put(self, frame: CameraFrame, *, packets_resent: int = 0) -> None:
        """Add a frame; it is lost, and counted as lost, if the queue is full. For the receiving thread.

        Parameters
        ----------
        frame
            The next one.
        packets_resent
            Packets of it that came only when asked for again.
        """
        with self._lock:
            counts = self._counts
            is_room = len(self._waiting) < self._capacity
            if is_room:
                self._waiting.append(frame)
            self._counts = replace(
                counts,
                frames=counts.frames + 1,
                frames_damaged=counts.frames_damaged + (not frame.is_whole),
                packets_missing=counts.packets_missing + frame.packets_missing,
                packets_resent=counts.packets_resent + packets_resent,
                queue_dropped=counts.queue_dropped + (not is_room),
                longest_queue=max(counts.longest_queue, len(self._waiting)),
            )
        self._tell()

    def end(self, failure: InstrumentError | None = None) -> None:
        """No more frames will come; from any thread, and again does no harm.

        Parameters
        ----------
        failure
            Why, if it was not wished; the first one is kept.
        """
        with self._lock:
            if not self._has_ended:
                self._failure = failure
            self._has_ended = True
        self._tell()

    def counts(self) -> StreamCounts:
        """How the frames came so far."""
        return self._counts

    async def frames(self) -> AsyncIterator[CameraFrame]:
        """Frames as they arrive, until `end`.

        Raises
        ------
        InstrumentError
            The failure that ended the stream, after all that had arrived before it.
        """
        while True:
            self._changed.clear()
            with self._lock:
                frame = self._waiting.popleft() if self._waiting else None
                has_ended = self._has_ended
            if frame is not None:
                yield frame
            elif not has_ended:
                await self._changed.wait()
            elif self._failure is not None:
                raise self._failure
            else:
                return

    def _tell(self) -> None:
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._changed.set)
