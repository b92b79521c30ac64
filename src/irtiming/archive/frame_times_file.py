"""Times of frames and rows written: as CSV, as Parquet, or into a copy of the recording as NeXus fields."""

import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, final

import numpy as np
from numpy.typing import NDArray

from irtiming.archive.hdf5_output import whole_hdf5
from irtiming.archive.layout import ENTRY
from irtiming.archive.parquet import require_parquet
from irtiming.archive.whole_file import text_output, whole_file
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Array, Ticks

FRAME_TIMES = f"{ENTRY}/frame_times"
"""Group of the times in a copy of a recording."""

_ROWS_TOGETHER = 2**18  # lines of Parquet that are written at once


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TimesToWrite:
    """What is written: of each moment the time after the trigger edge, its uncertainty and correlations, all shape (row,).

    ``trigger_s`` has the triggers, shape (n_frame,), since ``origin_s``; ``frames`` their numbers as their file has them,
    ``rows`` the rows, both whole. ``head`` are lines of what the numbers mean.
    """

    frames: Ticks
    trigger_s: Array
    origin_s: int
    rows: Ticks
    offset_s: Mapping[str, Array]
    u_s: Mapping[str, Array]
    correlation: Mapping[str, Array]
    correlation_of_rows: Mapping[str, Array]
    head: tuple[str, ...]


def write_csv(times: TimesToWrite, path: str | Path) -> None:
    """One line per frame and row, to the nanosecond, into a place as `text_output` has it.

    Raises
    ------
    ArchiveError
        If it cannot be written.
    """
    with text_output(path) as output:
        file = io.TextIOWrapper(output, encoding="utf-8", newline="\n")
        try:
            _write_lines(times, file)
        finally:
            file.detach()


def write_parquet(times: TimesToWrite, path: str | Path) -> None:
    """The same columns in Parquet, times as whole nanoseconds (``NAME_ns``); what they mean stands in the metadata ``irtiming``.

    Raises
    ------
    ArchiveError
        If it cannot be written, or its library is missing.
    """
    arrow, parquet = require_parquet()
    fields = [arrow.field("frame", arrow.int64()), arrow.field("row", arrow.int32())]
    for name in times.offset_s:
        fields += [arrow.field(f"{name}_ns", arrow.int64())]
        fields += [arrow.field(f"{kind}_{name}{unit}", arrow.float64()) for kind, unit in (("u", "_s"), ("r", ""))]
    schema = arrow.schema(fields, metadata={"irtiming": "\n".join(times.head)})
    together = max(1, _ROWS_TOGETHER // times.rows.size)
    with whole_file(path) as part, parquet.ParquetWriter(part, schema) as writer:
        for first in range(0, times.frames.size, together):
            table = list(_columns(times, slice(first, first + together)))
            writer.write_table(arrow.table(table, schema=schema))


def _columns(times: TimesToWrite, at: slice) -> Iterator[NDArray[Any]]:
    """Columns of some frames, frame after frame, shape (n_line,) each."""
    frames, rows = times.frames[at], times.rows
    yield np.repeat(frames, rows.size)
    yield np.tile(rows, frames.size).astype(np.int32)
    for name, offset_s in times.offset_s.items():
        since_s = (times.trigger_s[at, None] + offset_s).ravel()
        yield _whole_nanoseconds(times.origin_s, since_s)
        yield np.tile(times.u_s[name], frames.size)
        yield np.tile(times.correlation[name], frames.size)


def _write_lines(times: TimesToWrite, file: IO[str]) -> None:
    file.writelines(f"# {line}\n" for line in times.head)
    names = list(times.offset_s)
    columns = ["frame", "row"]
    for name in names:
        columns += [f"{name}_s", f"u_{name}_s", f"r_{name}"]
    file.write(",".join(columns) + "\n")
    fixed = [
        [f",{times.u_s[name][row]:.4g},{times.correlation[name][row]:.6f}" for row in range(times.rows.size)]
        for name in names
    ]
    for frame, trigger_s in zip(times.frames.tolist(), times.trigger_s.tolist(), strict=True):
        late = {name: _nanoseconds(times.origin_s, trigger_s + times.offset_s[name]) for name in names}
        file.writelines(
            f"{frame},{row}" + "".join(f",{late[name][place]}{fixed[k][place]}" for k, name in enumerate(names)) + "\n"
            for place, row in enumerate(times.rows.tolist())
        )


def _nanoseconds(origin_s: int, since_s: Array) -> list[str]:
    """Seconds with nine decimals, exact for any whole origin, shape (row,)."""
    total = _whole_nanoseconds(origin_s, since_s)
    return [f"{'-' if one < 0 else ''}{abs(one) // 10**9}.{abs(one) % 10**9:09d}" for one in total.tolist()]


def _whole_nanoseconds(origin_s: int, since_s: Array) -> Ticks:
    """The same as whole numbers, same shape."""
    whole = np.floor(since_s)
    nanos = np.rint((since_s - whole) * 1e9).astype(np.int64)
    return (origin_s + whole.astype(np.int64)) * 10**9 + nanos


def write_into_copy(times: TimesToWrite, recording: str | Path, *, path: str | Path) -> None:
    """Copy a recording and add the times to the copy: per moment ``NAME_time`` with ``NAME_time_errors``, as NeXus names them.

    Parameters
    ----------
    times
        Of its frames.
    recording
        The file to copy; it is left as it is.
    path
        The copy; a file of that name is replaced when the new one is whole.

    Raises
    ------
    ArchiveError
        If it cannot be written, or already holds times.
    """
    with whole_hdf5(path, copy_of=recording) as file:
        if FRAME_TIMES in file:
            raise ArchiveError(f"{recording}: already holds {FRAME_TIMES}; give the recording as it was made")
        group = file.create_group(FRAME_TIMES)
        group.attrs["NX_class"] = "NXcollection"
        group.attrs["description"] = "\n".join(times.head)
        for name, values in _fields(times):
            field = group.create_dataset(name, data=values)
            if name.endswith(("time", "errors", "origin")):
                field.attrs["units"] = "s"


def _fields(times: TimesToWrite) -> Iterator[tuple[str, object]]:
    yield "frame", times.frames
    yield "row", times.rows
    yield "time_origin", times.origin_s
    yield "trigger_time", times.trigger_s
    for name, offset in times.offset_s.items():
        yield f"{name}_time", times.trigger_s[:, None] + offset
        yield f"{name}_time_errors", times.u_s[name]
        yield f"{name}_correlation_of_frames", times.correlation[name]
        yield f"{name}_correlation_with_first_row", times.correlation_of_rows[name]
