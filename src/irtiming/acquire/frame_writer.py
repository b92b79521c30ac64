"""From the capture to the file: a bounded queue, and the one thread that writes."""

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TypeVar, final

import numpy as np

from irtiming.acquire.attendant import Attendant
from irtiming.archive.live.head import ExchangedClock, RecordingHead
from irtiming.archive.live.recording import LiveRecording, TickStream
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Pixels, Ticks
from irtiming.records.camera_frame import CameraFrame
from irtiming.records.clock_exchange import ClockExchange
from irtiming.records.timestamps import Timestamps

_T = TypeVar("_T")
_QUEUE_BYTES = 256 * 2**20
_FEWEST, _MOST = 16, 4096


@final
class FrameWriter:
    """Writes one recording in a thread of its own; nothing here makes the capture wait.

    Frames that find the queue full are not taken: `put_frame` says so. The first error of the file is kept in ``failure``,
    and frames that come after it are let go; `finish` still closes the file with all that is in it.
    """

    def __init__(self, path: Path, *, head: RecordingHead, attendant: Attendant, capacity: int | None = None) -> None:
        frame_bytes = max(1, 2 * head.setup.rows * head.setup.columns)
        self._recording = LiveRecording(path, head=head)
        self._attendant = attendant
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="recording")
        self._stack = ExitStack()
        self._capacity = capacity or min(_MOST, max(_FEWEST, _QUEUE_BYTES // frame_bytes))
        self._put = self._done = 0
        self._last: Pixels | None = None
        self.failure: Exception | None = None
        self.longest_queue = 0
        self.repeated = 0

    @property
    def waiting(self) -> int:
        """Frames in the queue."""
        return self._put - self._done

    async def open(self) -> None:
        """Make the file.

        Raises
        ------
        ArchiveError
            If it exists, or cannot be made.
        """
        try:
            await self._in_thread(lambda: self._stack.enter_context(self._recording))
        except BaseException:
            self._thread.shutdown()
            raise

    def put_frame(self, frame: CameraFrame, *, number: int) -> bool:
        """Queue a frame; false where the queue is full."""
        if self.waiting >= self._capacity:
            return False
        self._put += 1
        self.longest_queue = max(self.longest_queue, self.waiting)
        self._thread.submit(self._write_frame, frame, number)
        return True

    def put_blank(self, *, number: int, frame_id: int, host_time_s: float) -> None:
        """Queue a blank for a frame that is lost."""
        self._thread.submit(
            self._do,
            lambda: self._recording.append_blank(frame_number=number, frame_id=frame_id, host_time_s=host_time_s),
        )

    def put_ticks(self, stream: TickStream, ticks: Ticks) -> None:
        """Queue timestamps, shape (n_edge,)."""
        self._thread.submit(self._try, lambda: self._recording.append_ticks(stream, ticks))

    def put_exchange(self, clock: ExchangedClock, exchange: ClockExchange) -> None:
        """Queue a look at a clock."""
        self._thread.submit(self._try, lambda: self._recording.append_exchange(clock, exchange))

    async def put_rest_of(self, timestamps: Timestamps) -> None:
        """Add what the timestamps of the whole run have beyond those in the file, and wait until all that was queued is there."""
        await self._in_thread(lambda: self._try(lambda: self._recording.append_rest_of(timestamps)))

    async def finish(self, ended: str) -> Path:
        """Close the file when all that was queued is in it.

        Parameters
        ----------
        ended
            As for `LiveRecording.finish`.

        Returns
        -------
        The finished file.

        Raises
        ------
        ArchiveError
            If no file came of it; what was captured stays under the temporary name, unless there was not one frame.
        """
        try:
            return await self._in_thread(lambda: self._close(ended))
        finally:
            self._thread.shutdown()

    async def abandon(self, why: str) -> Path | None:
        """Close the file with what is in it, whatever went wrong outside; errors of the file are let go, and none came of it."""
        with suppress(ArchiveError):
            return await self.finish(" ".join(why.split()))
        return None

    def _close(self, ended: str) -> Path:
        part, is_empty = self._recording.part, self._recording.n_frames == 0
        try:
            with self._stack:
                return self._recording.finish(ended)
        except ArchiveError:
            if is_empty:
                part.unlink(missing_ok=True)
            raise

    def _write_frame(self, frame: CameraFrame, number: int) -> None:
        try:
            self._do(lambda: self._recording.append_frame(frame, frame_number=number))
            if frame.is_whole:
                self.repeated += self._last is not None and bool(np.array_equal(self._last, frame.pixels))
                self._last = frame.pixels
            if self.failure is None:
                self._do(lambda: self._attendant.written(frame, number=number))
        finally:
            self._done += 1

    def _do(self, job: Callable[[], None]) -> None:
        if self.failure is None:
            self._try(job)

    def _try(self, job: Callable[[], None]) -> None:
        """Timestamps are tried for even after an error: without theirs the frames before it would be worthless."""
        try:
            job()
        except Exception as error:  # whatever it is, it ends the run and is reported there
            self.failure = self.failure or error

    async def _in_thread(self, job: Callable[[], _T]) -> _T:
        return await asyncio.get_running_loop().run_in_executor(self._thread, job)
