"""Recordings of this program, and any other HDF5 file with a stack of frames."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, get_args

import h5py
import numpy as np

from irtiming.archive import layout
from irtiming.archive.fields import as_text, read_field
from irtiming.archive.frames.bounds import native, require_size
from irtiming.archive.frames.nexus_stack import FRAME_TIME, SCALE
from irtiming.archive.frames.source import (
    FrameFacts,
    FrameReader,
    Frames,
    FrameSource,
    FrameValues,
    Read,
    TimeScale,
)  # fmt: skip
from irtiming.archive.hdf5_bounds import require_bounded_stack, stack_in
from irtiming.archive.hdf5_file import damage_at, missing_filters, opened
from irtiming.archive.layout import Field
from irtiming.records.arrays import Ticks, read_only
from irtiming.records.camera_frame import CameraIdentity

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_OTHERS = (
    layout.CAMERA_TYPE, layout.READOUT_MODE, layout.TITLE, layout.ENDING, layout.PROGRAM_VERSION, layout.ROTATION_SPEED,
    layout.BLACKBODY_TEMPERATURE, layout.TRIGGER_DELAY_TIME_SET, layout.CLOCK_FREQUENCY,
)  # fmt: skip
_UNITS = {"s": "_s", "Hz": "_hz", "K": "_k"}


def _open(path: Path) -> FrameSource:
    with opened(path) as file:
        where = stack_in(file)
        if where is None:
            raise ValueError("it holds no stack of frames: no numbers of three axes (frame, row, column)")
        dataset = file[where]
        require_bounded_stack(where, dataset)
        if missing := missing_filters(dataset):
            raise ValueError(f"{where} is packed by filter {', '.join(missing)}, which is not installed")
        frames, rows, columns = dataset.shape
        kind = native(dataset.dtype)
        require_size(path, frames=frames, rows=rows, columns=columns, dtype=kind)
        is_ours, is_recording = where == layout.FRAMES.path, layout.CAMERA_TYPE.path in file
        form = "a recording (NeXus/HDF5)" if is_recording else "a NeXus stack" if is_ours else "an HDF5 stack"
        told = _told(file, frames) if is_ours else {"more": {"dataset": where}}
    facts = FrameFacts(
        format=form,
        frames=frames, rows=rows, columns=columns, dtype=kind, **told,
    )  # fmt: skip

    @contextmanager
    def reading() -> Iterator[Read]:
        with opened(path) as file, damage_at(where):
            stack = file[where]

            def read(first: int, count: int) -> FrameValues:
                return stack[first : first + count]

            yield read

    return Frames(path, facts, reading)


def _told(file: h5py.File, n_frames: int) -> dict[str, Any]:
    """What a recording says beside its frames."""

    def of(field: Field) -> Any:
        return None if field.path not in file else read_field(file, field)

    def each(field: Field) -> Any:
        found = of(field)
        if found is not None and len(found) != n_frames:
            raise ValueError(f"{field.path} has {len(found)} entries for {n_frames} frames")
        return found

    clock_hz, numbers = of(layout.CLOCK_FREQUENCY), each(layout.FRAME_NUMBER)
    stamps, stamp_hz, host = each(layout.FRAME_TIMESTAMP), of(layout.TIMESTAMP_FREQUENCY), each(layout.FRAME_HOST_TIME)
    identity = {field.name: of(field) or "" for field in layout.IDENTITY}
    period = of(layout.CAMERA_PERIOD)
    told: dict[str, Any] = {
        "unit": "K" if as_text(file[layout.FRAMES.path].attrs.get("units")) == "K" else "DN",
        "bit_depth": of(layout.BIT_DEPTH),
        "camera": CameraIdentity(**identity) if any(identity.values()) else None,
        "start_time": of(layout.START_TIME) or "",
        "integration_time_s": of(layout.INTEGRATION_TIME),
        "frame_period_s": period / clock_hz if period and clock_hz else _frame_time(file),
        "trigger_times_s": _trigger_times(of(layout.CAMERA_TRIGGER), numbers, n=n_frames, clock_hz=clock_hz),
        "frame_id": each(layout.FRAME_ID),
        "more": {f"{one.name}{_UNITS.get(one.unit, '')}": of(one) for one in _OTHERS if of(one) is not None},
    }
    if stamps is not None and stamp_hz:
        scale = as_text(file[layout.FRAME_TIMESTAMP.path].attrs.get(SCALE))
        told |= {"times_s": read_only(stamps / stamp_hz), "time_step_s": 1.0 / stamp_hz}
        told["time_scale"] = scale if scale in get_args(TimeScale) and scale else "camera clock"
    elif host is not None:
        told |= {"times_s": host, "time_scale": "host clock"}
    return told


def _frame_time(file: h5py.File) -> float | None:
    """Seconds from frame to frame where a file says so with one number."""
    found = file.get(FRAME_TIME)
    if not isinstance(found, h5py.Dataset) or found.size != 1 or found.dtype.kind != "f" or not _is_seconds(found):
        return None
    period_s = float(np.ravel(found[()])[0])
    return period_s if 0 < period_s < 1e6 else None


def _is_seconds(dataset: h5py.Dataset) -> bool:
    return as_text(dataset.attrs.get("units")) == "s"


def _trigger_times(triggers: Ticks | None, numbers: Ticks | None, *, n: int, clock_hz: float | None) -> Any:
    """Of the trigger that made each frame, shape (n,); None where they are not there."""
    if triggers is None or not clock_hz:
        return None
    made_by = np.arange(n) if numbers is None else numbers
    if not len(made_by) or made_by.min() < 0 or made_by.max() >= len(triggers):
        return None
    return read_only(triggers[made_by] / clock_hz)


READER = FrameReader(
    title="NeXus/HDF5", takes=lambda _, begin: begin.startswith(_SIGNATURE), open=_open
)  # fmt: skip
