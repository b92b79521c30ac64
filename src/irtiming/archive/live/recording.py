"""A recording that is written while the camera is triggered, and that outlives whatever stops it."""

import os
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any, Literal, Self, final, get_args

import h5py
import numpy as np

from irtiming.archive import frame_status, layout
from irtiming.archive.finding import Complaint
from irtiming.archive.hdf5_file import H5_ERRORS, reason_of
from irtiming.archive.hdf5_output import abandon
from irtiming.archive.layout import Field
from irtiming.archive.live import growing_file
from irtiming.archive.live.finish import conclude, give_name, require_free_name
from irtiming.archive.live.head import ExchangedClock, RecordingHead
from irtiming.archive.live.unfinished import claimed, part_of
from irtiming.archive.whole_file import unwritable
from irtiming.errors import ArchiveError, IrTimingError
from irtiming.records.arrays import Pixels, Ticks
from irtiming.records.camera_frame import CameraFrame
from irtiming.records.clock_exchange import ClockExchange
from irtiming.records.timestamps import Timestamps

TickStream = Literal[
    "camera_trigger", "camera_trigger_delayed", "control_slot", "application_slot", "application_edges", "camera_input",
    "spare", "lost_after",
]  # fmt: skip
"""Tick streams of the file by their names there."""

COMPLETE = layout.COMPLETE
"""What `LiveRecording.finish` is given for a run in which everything came; any other text says why it ended early."""

_RESERVE_BYTES = 16 * 2**20
"""Left free on the disk when frames are refused: timestamps still come, and the file must be finished."""

_COLUMNS = (*layout.PER_FRAME, layout.FRAME_STATUS)
_FIELDS: dict[str, Field] = {field.name: field for field in growing_file.STREAMS}
_TICKS_OF: dict[TickStream, str] = {"application_edges": "application_edge_ticks"}


@final
class LiveRecording:
    """Frames and timestamps of one run as they come, into one file; use it in a ``with`` statement, from one thread.

    The file has the suffix ``.part`` until `finish`. It can be read at any time by other processes
    (`so_far.read_so_far`), and after a kill -9 it has all but the last frame (`irtiming recover`).

    ``path`` is the file to make, with suffix ``.nxs``. Nothing is ever overwritten: a file of that name, or one
    of an interrupted run (``.part``), is refused.

    If the block raises before `finish`, `finish` is called with the reason, and the exception goes on with a note
    where the file is. If it ends without `finish`, that is an `ArchiveError`, and the ``.part`` stays.
    """

    def __init__(self, path: str | Path, *, head: RecordingHead) -> None:
        self._path = Path(path)
        self._part = part_of(path)
        self._head = head
        self._file: h5py.File | None = None
        self._datasets: dict[Field, h5py.Dataset] = {}
        self._held = ExitStack()
        self._trouble = ""
        self._n_frames = self._n_ticks = 0
        self._last_number = -1
        self._blank = np.zeros((head.setup.rows, head.setup.columns), np.uint16)

    def __enter__(self) -> Self:
        """Create the file under its temporary name, with everything in it that is known beforehand.

        Raises
        ------
        ArchiveError
            If a file of either name exists, or none can be made.
        """
        require_free_name(self._path)
        if self._part.exists():
            cure = "finish that with irtiming recover, or choose another name"
            raise ArchiveError(f"{self._part}: exists already: a recording that was interrupted; {cure}")
        try:
            growing_file.create(self._part, self._head)
            self._file = growing_file.open_for_writing(self._part)
            self._held.enter_context(claimed(self._part))
        except OSError as error:
            raise unwritable(self._path, error) from error
        exchanged = (field for fields in growing_file.EXCHANGES.values() for field in fields)
        growing = (layout.FRAMES, *_COLUMNS, *growing_file.STREAMS, *exchanged)
        self._datasets = {field: self._file[field.path] for field in growing if field.path in self._file}
        return self

    @property
    def path(self) -> Path:
        """The finished file."""
        return self._path

    @property
    def part(self) -> Path:
        """The file until it is finished."""
        return self._part

    @property
    def n_frames(self) -> int:
        """Frames that are in the file, blank and damaged ones among them."""
        return self._n_frames

    def append_frame(self, frame: CameraFrame, *, frame_number: int) -> None:
        """Add a frame, whole or damaged; when this returns it is in the file, and survives a kill of this process.

        Parameters
        ----------
        frame
            Its pixels are uint16 (row, column) of the size in the head; ``packets_missing`` marks it as damaged.
        frame_number
            Index of the trigger that made it, larger than those before; `finish` may correct it.

        Raises
        ------
        ArchiveError
            If the frame has another size or type, or the disk is full: what came before is safe, call `finish`.
        """
        status = frame_status.WHOLE if frame.is_whole else frame_status.DAMAGED
        if frame.pixels.dtype != np.uint16 or frame.pixels.shape != self._blank.shape:
            got = f"got a frame of {frame.pixels.dtype} {frame.pixels.shape}"
            raise self._error(layout.FRAMES, f"{got}; give uint16 {self._blank.shape}")
        values = {
            layout.FRAME_ID: frame.frame_id,
            layout.FRAME_TIMESTAMP: frame.device_timestamp_ticks,
            layout.FRAME_HOST_TIME: frame.host_time_s,
            layout.FRAME_STATUS: status,
        }
        self._append(frame.pixels, frame_number, values)

    def append_blank(self, *, frame_number: int, frame_id: int, host_time_s: float) -> None:
        """Put a zero frame where one is known to be missing: nothing of it arrived.

        Parameters
        ----------
        frame_number
            Index of the trigger that should have made it.
        frame_id
            That the camera gave it, or would have.
        host_time_s
            When this computer noticed, monotonic clock.

        Raises
        ------
        ArchiveError
            If the disk is full.
        """
        values = {
            layout.FRAME_ID: frame_id,
            layout.FRAME_TIMESTAMP: 0,
            layout.FRAME_HOST_TIME: host_time_s,
            layout.FRAME_STATUS: frame_status.BLANK,
        }
        self._append(self._blank, frame_number, values)

    def append_ticks(self, stream: TickStream, ticks: Ticks) -> None:
        """Add unwrapped ticks to a stream, shape (n,); an empty array does nothing.

        Raises
        ------
        ArchiveError
            If the disk is full.
        """
        if stream not in _FIELDS:
            raise ArchiveError(
                f"{self._part}: there is no stream '{stream}'; give one of {', '.join(get_args(TickStream))}"
            )
        if len(ticks) == 0:
            return
        self._opened()
        dataset = self._datasets[_FIELDS[stream]]
        least = 1 if stream == "camera_trigger" else 0
        before = dataset[-1:] if len(dataset) else np.empty(0, np.int64)
        steps = np.diff(np.concatenate([before, np.asarray(ticks, np.int64)]))
        if steps.size and int(steps.min()) < least:
            at = int(np.argmin(steps))
            what = f"got ticks that {'go back' if steps[at] < 0 else 'repeat'} by {-steps[at]}"
            raise self._error(_FIELDS[stream], f"{what}; they must be of one unwrapped counter, in order")
        self._extend(_FIELDS[stream], ticks)
        self._n_ticks += len(ticks)

    def append_exchange(self, clock: ExchangedClock, exchange: ClockExchange) -> None:
        """Add a look at a clock; only where the head says that the camera runs free.

        Raises
        ------
        ArchiveError
            If the disk is full, or the camera is triggered.
        """
        self._opened()
        fields = growing_file.EXCHANGES[clock]
        if any(field not in self._datasets for field in fields):
            raise self._error(fields[1], "has no place where the camera is triggered; say what its frames count from")
        for field, value in zip(fields, (exchange.before_s, exchange.ticks, exchange.after_s), strict=True):
            self._extend(field, [value])

    def append_rest_of(self, timestamps: Timestamps) -> None:
        """Add to every stream what the timestamps of the whole run have beyond the ticks that are in the file.

        Raises
        ------
        ArchiveError
            If they contradict the ticks that are in the file, or the disk is full.
        """
        for stream in get_args(TickStream):
            ticks: Ticks = getattr(timestamps, _TICKS_OF.get(stream, f"{stream}_ticks"))
            written = self._opened()[_FIELDS[stream].path][()]
            if not np.array_equal(ticks[: written.size], written):
                n_different = int(np.count_nonzero(ticks[: written.size] != written[: ticks.size]))
                what = f"has {written.size} ticks, the whole run has {ticks.size}, of which {n_different} are others"
                raise self._error(_FIELDS[stream], f"{what}; what is in the file stays")
            self.append_ticks(stream, ticks[written.size :])

    def finish(self, ended: str = COMPLETE, *, frame_number: Ticks | None = None) -> Path:
        """Check the file, bring it to the disk and give it its name.

        Frames for whose trigger there is no timestamp stay in the file, marked as such; readers leave them out.
        Everything is allowed to be missing but the first frame and the first turn of the wheel.

        Parameters
        ----------
        ended
            `COMPLETE`, or why the run ended early, such as ``"stopped by Ctrl-C"``.
        frame_number
            Index of the trigger of each frame in the file, shape (n_frame,), where it has turned out to be another.

        Returns
        -------
        The finished file.

        Raises
        ------
        ArchiveError
            If the file is not one that the reader takes: it says why, and the ``.part`` stays with all that came.
        """
        file = self._opened()
        try:
            conclude(file, ending=ended, frame_number=frame_number)
            file.flush()
            file.close()
            give_name(self._part, self._path)
        except (Complaint, ArchiveError, *H5_ERRORS) as error:
            raise self._not_finished(error) from error
        finally:
            self._close()
        return self._path

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, *_: object) -> None:
        """Finish the file if that is still to be done, and leave it if it cannot be."""
        if self._file is None:
            return
        if error is None:
            self._close()
            raise ArchiveError(f"{self._part}: finish() was never called; finish the file with irtiming recover")
        try:
            error.add_note(f"what came until then is in {self.finish(_reason(error).removeprefix(f'{self._part}: '))}")
        except ArchiveError as failure:
            error.add_note(str(failure))

    def _append(self, pixels: Pixels, frame_number: int, values: dict[Field, float]) -> None:
        if frame_number <= self._last_number:
            what = f"got trigger {frame_number} after {self._last_number}"
            raise self._error(layout.FRAME_NUMBER, f"{what}; each frame must belong to a later trigger")
        self._require_room()
        try:
            self._extend(layout.FRAMES, pixels[np.newaxis])
            for field, value in ({layout.FRAME_NUMBER: frame_number} | values).items():
                self._extend(field, [value])
        except ArchiveError:
            for field in (layout.FRAMES, *_COLUMNS):
                with suppress(*H5_ERRORS):
                    self._datasets[field].resize(self._n_frames, axis=0)
            raise
        self._n_frames += 1
        self._last_number = frame_number

    def _extend(self, field: Field, values: Any) -> None:
        self._opened()
        if self._trouble:
            raise ArchiveError(self._trouble)
        try:
            growing_file.extend(self._datasets[field], values)
        except H5_ERRORS as error:
            self._trouble = f"{self._part}: {field.path} could not be written ({reason_of(error)}); is the disk full?"
            raise ArchiveError(self._trouble) from error

    def _require_room(self) -> None:
        room = os.statvfs(self._part.parent)
        free = room.f_bavail * room.f_frsize
        if free < _RESERVE_BYTES + 2 * self._blank.nbytes:
            what = f"the disk is full: {free // 2**20} MiB are left, {_RESERVE_BYTES // 2**20} of them for the end"
            raise ArchiveError(f"{self._part}: {what}; make room, or record to another disk")

    def _opened(self) -> h5py.File:
        if self._file is None:
            raise ArchiveError(f"{self._path}: is not being recorded; use the recording inside its 'with' block")
        return self._file

    def _close(self) -> None:
        """Let go of the file, whatever state it is in; the first error is the one to tell."""
        if self._file is not None and self._file.id.valid:
            try:
                self._file.flush()
                self._file.close()
            except H5_ERRORS:
                abandon(self._file)
        self._file = None
        self._datasets = {}
        self._held.close()

    def _not_finished(self, error: Exception) -> ArchiveError:
        reason = error.finding.sentence() if isinstance(error, Complaint) else str(error)
        if not isinstance(error, Complaint | ArchiveError):
            reason = self._trouble or f"could not be written ({reason_of(error)}); is the disk full?"
        reason = reason.removeprefix(f"{self._part}: ")
        if self._n_frames:
            after = f"{self._n_frames} frames are in it; when that is cured, finish it with irtiming recover"
        elif self._n_ticks:
            after = "it has no frame"
        else:
            self._part.unlink(missing_ok=True)
            after = "nothing was recorded, and no file is left"
        return ArchiveError(f"{self._part}: is not finished: {reason}; {after}")

    def _error(self, field: Field, what: str) -> ArchiveError:
        return ArchiveError(f"{self._part}: {field.path} {what}")


def _reason(error: BaseException) -> str:
    if isinstance(error, KeyboardInterrupt):
        return "stopped by Ctrl-C"
    if isinstance(error, IrTimingError):
        return str(error).split("; ")[0]  # what happened, without what to do
    return f"{type(error).__name__}: {error}".rstrip(": ")
