"""Frames and what is known of them as a NeXus file: the camera's part of a recording, at the same places."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from irtiming.archive import layout
from irtiming.archive.frames.source import FrameFacts, FrameValues
from irtiming.archive.hdf5_output import writing
from irtiming.archive.layout import Field
from irtiming.archive.nexus import create_stack, describe_for_viewers, group, set_units

SCALE = "scale"
"""Attribute of the camera's timestamps: the scale of times in another format that they come from."""

FRAME_TIME = f"{layout.CAMERA}/frame_time"
"""Seconds from frame to frame, as NXdetector calls it."""

_MOST_TICKS = 2.0**62


def write_nexus(facts: FrameFacts, blocks: Iterator[FrameValues], *, part: Path) -> list[str]:
    """Write a stack with its facts.

    Parameters
    ----------
    facts
        What is known.
    blocks
        Of frames, each of shape (frame, row, column).
    part
        The file.

    Returns
    -------
    What has no place in the file.
    """
    with writing(part) as (file, output):
        stack = create_stack(file, layout.FRAMES, size=(facts.rows, facts.columns), dtype=facts.dtype)
        done = 0
        for block in blocks:
            stack.resize(done + len(block), axis=0)
            stack[done:] = block
            done += len(block)
            output.require_written()
        _write_facts(file, facts)
        describe_for_viewers(file)
    return _lost(facts)


def _write_facts(file: h5py.File, facts: FrameFacts) -> None:
    values: dict[Field, Any] = {
        layout.FRAME_NUMBER: np.arange(facts.frames),
        layout.BIT_DEPTH: facts.bit_depth if facts.bit_depth and facts.bit_depth <= layout.BIT_DEPTH.highest else None,
        layout.INTEGRATION_TIME: facts.integration_time_s,
        layout.START_TIME: facts.start_time or None,
        layout.FRAME_ID: facts.frame_id,
    }
    values |= _clock_values(facts)
    if facts.camera is not None:
        values |= {field: getattr(facts.camera, field.name) or None for field in layout.IDENTITY}
    if (clock_hz := _trigger_clock(facts)) is not None and facts.trigger_times_s is not None:
        values[layout.CLOCK_FREQUENCY] = clock_hz
        values[layout.CAMERA_TRIGGER] = np.rint(facts.trigger_times_s * clock_hz).astype(np.int64)
    for field, value in values.items():
        if value is not None:
            set_units(group(file, field.group).create_dataset(field.name, data=value), field.unit)
    if layout.FRAME_TIMESTAMP.path in file:
        file[layout.FRAME_TIMESTAMP.path].attrs[SCALE] = facts.time_scale
    if facts.frame_period_s is not None:
        set_units(file.create_dataset(FRAME_TIME, data=facts.frame_period_s), "s")
    if facts.unit:
        file[layout.FRAMES.path].attrs["units"] = facts.unit


def _clock_values(facts: FrameFacts) -> dict[Field, Any]:
    """Times of frames as ticks of the step in which the file has them; those of the computer's clock as they are."""
    if facts.times_s is None:
        return {}
    if facts.time_scale == "host clock":
        return {layout.FRAME_HOST_TIME: facts.times_s}
    frequency_hz = round(1.0 / facts.time_step_s) if facts.time_step_s and facts.time_step_s <= 1.0 else 10**6
    ticks = np.rint(facts.times_s * frequency_hz)
    if not np.all(np.abs(ticks) < _MOST_TICKS) or ticks.min() < 0:
        return {}
    return {layout.FRAME_TIMESTAMP: ticks.astype(np.int64), layout.TIMESTAMP_FREQUENCY: float(frequency_hz)}


def _trigger_clock(facts: FrameFacts) -> float | None:
    found = facts.more.get("clock_frequency_hz")
    return found if isinstance(found, float) else None


def _lost(facts: FrameFacts) -> list[str]:
    is_lost = {
        "times_s": facts.times_s is not None and not _clock_values(facts),
        "trigger_times_s": facts.trigger_times_s is not None and _trigger_clock(facts) is None,
        "more": bool(facts.more),
    }
    return sorted(name for name, lost in is_lost.items() if lost)
