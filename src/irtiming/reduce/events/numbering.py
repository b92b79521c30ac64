"""The camera's count of each frame: which frames came, and where some are missing between them."""

from dataclasses import dataclass
from typing import Literal, final

import numpy as np

from irtiming.errors import ReductionError
from irtiming.inference.stamp_line import numbered
from irtiming.records.arrays import Array, Ticks
from irtiming.records.recording import Recording

Source = Literal["frame_id", "frame_timestamp", "frame_number", "frame_host_time", "none"]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Counts:
    """Count of each frame from 0 for the first, shape (n_frame,), and the field that tells it; "none": that none is missing."""

    number: Ticks
    source: Source


def counts(recording: Recording) -> Counts:
    """How many frames the camera made from the first to each, shape (n_frame,), by the best that the recording holds.

    The camera's own count first, then its own clock, then numbers written by hand, then the frames' arrival.

    Parameters
    ----------
    recording
        Its frames are not read.

    Raises
    ------
    ReductionError
        If that does not rise from frame to frame.
    """
    stamps = stamps_s(recording)
    arrivals = recording.frame_host_time_s
    written = recording.frame_number - recording.frame_number[0]
    if recording.frame_id is not None:
        return _rising(recording.frame_id - recording.frame_id[0], "frame_id", recording)
    if stamps is not None:
        return _rising(numbered(stamps), "frame_timestamp", recording)
    if np.any(np.diff(written) != 1):
        return _rising(written, "frame_number", recording)
    if arrivals is not None:
        return _rising(numbered(arrivals - arrivals[0]), "frame_host_time", recording)
    return Counts(number=written, source="none")


def stamps_s(recording: Recording) -> Array | None:
    """What the camera's clock said of each frame after the first, s, shape (n_frame,); None where it did not say."""
    ticks, frequency_hz = recording.frame_timestamp_ticks, recording.timestamp_frequency_hz
    if ticks is None or frequency_hz is None or (ticks[0] != 0 and bool(np.any(ticks == 0))):
        return None
    return np.asarray((ticks - ticks[0]) / frequency_hz)


def _rising(number: Ticks, source: Source, recording: Recording) -> Counts:
    steps = np.diff(number)
    if steps.size and int(steps.min()) < 1:
        at = int(np.argmax(steps < 1))
        raise ReductionError(
            f"{recording.name}: {source} does not rise from frame {at} to frame {at + 1}, it must from each frame to the next; "
            "write the camera's count of its frames, from one start of the camera"
        )
    return Counts(number=number.astype(np.int64), source=source)
