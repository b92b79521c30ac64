"""What a person does with files of frames: look what is in one, make another of it."""

import hashlib
from pathlib import Path
from typing import Any

import numpy as np

from irtiming.archive.frames.opening import open_frames
from irtiming.archive.frames.source import FrameFacts
from irtiming.archive.frames.writing import Progress, write_frames

_UNITS = {"_s": "s", "_hz": "Hz", "_k": "K"}


def look_into(path: Path) -> dict[str, Any]:
    """What a file of frames holds and tells, for JSON and for the screen.

    Raises
    ------
    ArchiveError
        If it cannot be read.
    """
    source = open_frames(path)
    facts = source.facts
    first = np.ascontiguousarray(source.pick([0])[0])
    found: dict[str, Any] = {
        "file": str(path),
        "format": facts.format,
        "frames": facts.frames,
        "rows": facts.rows,
        "columns": facts.columns,
        "dtype": facts.dtype,
        "unit": facts.unit,
        "bit_depth": facts.bit_depth,
        "first_frame_sha256": hashlib.sha256(first.astype(first.dtype.newbyteorder("<"), copy=False).data).hexdigest(),
        "first_frame_lowest": first.min().item(),
        "first_frame_highest": first.max().item(),
        "camera": None if facts.camera is None else vars(facts.camera),
        "start_time": facts.start_time or None,
        "integration_time": _seconds(facts.integration_time_s),
        "frame_period": _seconds(facts.frame_period_s),
        "frame_times": _times(facts),
        "trigger_times": None if facts.trigger_times_s is None else _span(facts.trigger_times_s),
        "frame_id": None if facts.frame_id is None else {"first": int(facts.frame_id[0]), "last": int(facts.frame_id[-1])},
        "more": dict(facts.more),
    }  # fmt: skip
    return found


def convert(path: Path, out: Path, *, progress: Progress | None = None) -> list[str]:
    """Frames of one file, with what is known of them, into one of another format.

    Parameters
    ----------
    path, out
        The ending of ``out`` says the format.
    progress
        Called with frames written and all frames.

    Returns
    -------
    What is known and has no place in the format.

    Raises
    ------
    ArchiveError
        If the frames cannot be read, or not written in that format.
    """
    return [
        name.removesuffix("_s").replace("_", " ") for name in write_frames(open_frames(path), out, progress=progress)
    ]


def _seconds(value: float | None) -> dict[str, object] | None:
    return None if value is None else {"value": value, "unit": "s"}


def _times(facts: FrameFacts) -> dict[str, object] | None:
    if facts.times_s is None:
        return None
    return _span(facts.times_s) | {"scale": facts.time_scale, "step": facts.time_step_s}


def _span(times_s: np.ndarray) -> dict[str, object]:
    between = np.diff(times_s)
    return {
        "unit": "s",
        "first": float(times_s[0]),
        "last": float(times_s[-1]),
        "median_interval": float(np.median(between)) if between.size else None,
        "values": times_s,
    }
