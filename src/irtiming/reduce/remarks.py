"""Findings that every reduction may make about a recording."""

import numpy as np

from irtiming.records.arrays import Mask, Ticks
from irtiming.records.finding import Finding
from irtiming.records.recording import Recording
from irtiming.records.reduced import ShutterEvent
from irtiming.records.wheel_track import WheelTrack
from irtiming.units import counted


def doubt(*, code: str, recording: Recording, what: str, cure: str = "") -> Finding:
    """A warning about a recording.

    Parameters
    ----------
    code
        Kind of finding.
    recording, what, cure
        What it is about, what is, and what to do.
    """
    return Finding(severity="warning", code=code, recording=recording.name, what=what, cure=cure)


def of_input(recording: Recording, track: WheelTrack) -> tuple[Finding, ...]:
    """What was found when the file was read, and when its timestamps became wheel angles.

    Parameters
    ----------
    recording, track
        The wheel angles of the former.
    """
    uneven = []
    if recording.camera_type == "photon" and recording.nonuniformity is None:
        what = "no nonuniformity_reference in the recording: frames used as they are"
        uneven.append(doubt(code="no-nonuniformity-reference", recording=recording, what=what))
    return (*recording.findings, *uneven, *track.findings)


def without_angle(recording: Recording, outside: Mask) -> tuple[Finding, ...]:
    """Frames that are dropped since no control slots were recorded when they were triggered.

    Parameters
    ----------
    recording
        That they belong to.
    outside
        Shape (n_frame,); which they are.
    """
    if not np.any(outside):
        return ()
    what = f"{counted(int(outside.sum()), 'frame')} dropped: triggered where no control slots were recorded"
    return (doubt(code="frames-without-angle", recording=recording, what=what),)


def odd_frames(recording: Recording, odd: Mask) -> Finding:
    """Single frames that show something else.

    Parameters
    ----------
    recording
        It.
    odd
        Shape (n_frame,).
    """
    what = f"{counted(int(odd.sum()), 'single frame')} dropped: not what the wheel angle demands"
    return doubt(code="odd-frames", recording=recording, what=what)


def pixels_replaced(recording: Recording, n_pixels: int, *, by: str) -> Finding:
    """Pixels of the opening that the frames show to be dead, stuck or blinking.

    Parameters
    ----------
    recording, n_pixels
        It, and how many they are.
    by
        What stands in for them.
    """
    what = f"{counted(n_pixels, 'pixel')} found not to follow the wheel: replaced by {by}"
    return doubt(code="bad-pixels", recording=recording, what=what)


def rows_left_out(recording: Recording, row_px: Ticks, *, instead: str = "") -> Finding:
    """Image rows that are not summed.

    Parameters
    ----------
    recording, row_px
        It, and the rows, shape (n,).
    instead
        What is done in their place, if anything.
    """
    rows = ", ".join(str(row) for row in row_px)
    if len(row_px) == 1:
        what = f"image row {rows} left out{instead}: it has too few live pixels, or is a copy of a row beside it"
    else:
        what = f"image rows {rows} left out{instead}: they have too few live pixels, or are copies of a row beside them"
    return doubt(code="rows-left-out", recording=recording, what=what)


def shutter_closed(recording: Recording, event: ShutterEvent) -> Finding:
    """Frames of a closed shutter.

    Parameters
    ----------
    recording, event
        Where it was, and when.
    """
    first, last = event.first_frame, event.end_frame - 1
    if first == last:
        what = f"the shutter is closed in frame {first}: dropped with the frames around it"
    else:
        what = f"the shutter is closed in frames {first} to {last}: dropped with the frames around them"
    return doubt(code="shutter-closed", recording=recording, what=what)


def lost_frames(recording: Recording) -> tuple[Finding, ...]:
    """Triggers that made no frame.

    Parameters
    ----------
    recording
        To count in.
    """
    lost = int(recording.frame_number[-1] - recording.frame_number[0]) + 1 - recording.frame_number.size
    if not lost:
        return ()
    what = f"{counted(lost, 'frame')} lost between the first and the last: triggers without a frame are skipped"
    return (doubt(code="lost-frames", recording=recording, what=what),)
