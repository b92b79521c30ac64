"""What a person does with files of frames: look what is in one, make another of it."""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from irtiming.archive.frames.opening import open_frames
from irtiming.archive.frames.source import FrameFacts
from irtiming.archive.frames.writing import Progress, write_frames
from irtiming.records.arrays import Ticks

_SHOWN = 5  # missing numbers
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
        "frame_id": None if facts.frame_id is None else _numbers(facts.frame_id),
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


def numbers_in_words(numbers: Mapping[str, Any] | None) -> str:
    """What ``frame_id`` of `look_into` says, such as "0 to 299, 1 missing: 150"; empty where it says nothing."""
    if numbers is None:
        return ""
    span = f"{numbers['first']} to {numbers['last']}"
    n_missing = numbers["missing"]
    if n_missing is None:
        return f"{span}, not rising"
    after = ", ..." if n_missing > len(numbers["first_missing"]) else ""
    which = ", ".join(map(str, numbers["first_missing"]))
    return f"{span}, {n_missing} missing: {which}{after}" if n_missing else span


def _numbers(numbers: Ticks) -> dict[str, object]:
    """First and last, and which are missing between them: how many, None where they do not rise, and the first few."""
    steps = np.diff(numbers)
    rises = not steps.size or int(steps.min()) > 0
    missing: list[int] = []
    for at in np.flatnonzero(steps > 1)[:_SHOWN] if rises else ():
        missing += range(int(numbers[at]) + 1, min(int(numbers[at + 1]), int(numbers[at]) + 1 + _SHOWN))
    return {
        "first": int(numbers[0]), "last": int(numbers[-1]),
        "missing": int(np.sum(steps - 1)) if rises else None, "first_missing": missing[:_SHOWN],
    }  # fmt: skip


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
