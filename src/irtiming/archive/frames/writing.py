"""Frames of any source into a file of another format, block by block; the file is whole or not there."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from irtiming.archive.frames.bounds import refusing
from irtiming.archive.frames.facts_model import as_told
from irtiming.archive.frames.nexus_stack import write_nexus
from irtiming.archive.frames.readers.numpy_array import SIDECAR
from irtiming.archive.frames.readers.tiff import described
from irtiming.archive.frames.source import FrameFacts, FrameSource, FrameValues
from irtiming.archive.hdf5_file import reason_of
from irtiming.archive.json_file import write_atomically
from irtiming.archive.nexus import bring_to_disk
from irtiming.archive.whole_file import final_name, whole_file
from irtiming.errors import ArchiveError

Progress: TypeAlias = Callable[[int, int], None]
"""Called with frames written and all frames."""

_LEAST_HCC_COLUMNS, _MOST_HCC_COLUMNS = 27, 16_383
_HCC_STEPS_PER_S = 10**7


def write_frames(source: FrameSource, out: Path, *, progress: Progress | None = None) -> list[str]:
    """Write frames and what is known of them; the ending of the name says the format.

    Parameters
    ----------
    source
        Where they come from.
    out
        A new file: ``.nxs`` or ``.h5`` (NeXus), ``.tif`` (BigTIFF), ``.npy`` (with ``.npy.json`` beside it), ``.hcc``.
    progress
        Called after each block.

    Returns
    -------
    What was known and the format has no place for, in words.

    Raises
    ------
    ArchiveError
        If the file exists, the format is none of these or cannot hold such pixels, or the file cannot be written.
    """
    write = _WRITERS.get(out.suffix.lower())
    if write is None:
        raise ArchiveError(f"ends in no format that is written; end it in {', '.join(_WRITERS)}", where=str(out))
    if out.exists():
        raise ArchiveError("exists already; choose another name", where=str(out))
    beside = Path(f"{out}{SIDECAR}")
    facts = _facts_beside(source.facts, beside) if out.suffix.lower() == ".npy" else ""
    with whole_file(out) as part:
        try:
            lost = write(source.facts, _counted(source, progress), part)
        except RuntimeError as error:  # of HDF5, on a disk that is full
            raise ArchiveError(f"cannot be written ({reason_of(error)}); is the disk full?", where=str(out)) from error
        bring_to_disk(part)
        if facts:  # at the last moment: without the frames it would be in the way of the next try
            write_atomically(facts, beside)
    return lost


def _facts_beside(facts: FrameFacts, beside: Path) -> str:
    """Text of the file beside one that has no place for facts; empty where nothing is known."""
    stated = as_told(facts)
    if stated and beside.exists():
        raise ArchiveError("exists already, and is where the facts would go; choose another name", where=str(beside))
    return json.dumps(stated, indent=1) + "\n" if stated else ""


def _counted(source: FrameSource, progress: Progress | None) -> Iterator[FrameValues]:
    for first, block in source.blocks():
        yield block
        if progress is not None:
            progress(first + len(block), source.facts.frames)


def _write_npy(facts: FrameFacts, blocks: Iterator[FrameValues], part: Path) -> list[str]:
    kind = np.lib.format.dtype_to_descr(np.dtype(facts.dtype))
    with part.open("wb") as file:
        np.lib.format.write_array_header_2_0(file, {"descr": kind, "fortran_order": False, "shape": facts.shape})
        for block in blocks:
            file.write(np.ascontiguousarray(block).data)
    return []


def _write_tiff(facts: FrameFacts, blocks: Iterator[FrameValues], part: Path) -> list[str]:
    with refusing(final_name(part), "TIFF"):
        import tifffile
    with tifffile.TiffWriter(part, bigtiff=True) as writer:
        writer.write(
            (frame for block in blocks for frame in block), shape=facts.shape, dtype=facts.dtype, photometric="minisblack",
            metadata=None, software="irtiming", description=described(facts),
        )  # fmt: skip
    return []


def _write_hcc(facts: FrameFacts, blocks: Iterator[FrameValues], part: Path) -> list[str]:
    with refusing(final_name(part), "Telops HCC"):
        from fasthcc import HCCWriter
    if facts.dtype not in ("uint8", "uint16"):
        raise ArchiveError(
            f"HCC holds counts of 16 bits, these are {facts.dtype}; choose .tif, .npy or .nxs",
            where=str(final_name(part)),
        )
    if not _LEAST_HCC_COLUMNS <= facts.columns <= _MOST_HCC_COLUMNS:
        bounds = f"{_LEAST_HCC_COLUMNS} to {_MOST_HCC_COLUMNS}"
        raise ArchiveError(
            f"HCC holds rows of {bounds} pixels, these have {facts.columns}", where=str(final_name(part))
        )
    is_dated = facts.times_s is not None and facts.time_scale == "UTC"
    with HCCWriter(
        part, facts.columns, facts.rows, calibration_mode=0, exposure_time=(facts.integration_time_s or 0.0) * 1e6,
        frame_rate=1.0 / facts.frame_period_s if facts.frame_period_s else 0.0,
        data_offset=float(facts.more.get("data_offset", 0.0)), data_exp=int(facts.more.get("data_exponent", 0)),
    ) as writer:  # fmt: skip
        done = 0
        for block in blocks:
            for frame in block:
                writer.write_frame(frame.astype(np.uint16, copy=False), _hcc_header(facts, done, is_dated=is_dated))
                done += 1
    kept = {"integration_time_s", "frame_period_s", "frame_id", "unit", "more"}
    kept |= {"times_s", "time_scale", "time_step_s"} if is_dated else set()
    return sorted(set(as_told(facts)) - kept)


def _hcc_header(facts: FrameFacts, place: int, *, is_dated: bool) -> dict[str, Any]:
    header: dict[str, Any] = {"FrameID": int(place if facts.frame_id is None else facts.frame_id[place]) % 2**32}
    if is_dated and facts.times_s is not None:
        second, part = divmod(round(float(facts.times_s[place]) * _HCC_STEPS_PER_S), _HCC_STEPS_PER_S)
        header |= {"POSIXTime": second % 2**32, "SubSecondTime": part}
    return header


def _write_nexus(facts: FrameFacts, blocks: Iterator[FrameValues], part: Path) -> list[str]:
    return write_nexus(facts, blocks, part=part)


_WRITERS: dict[str, Callable[[FrameFacts, Iterator[FrameValues], Path], list[str]]] = {
    ".nxs": _write_nexus, ".h5": _write_nexus, ".hdf5": _write_nexus, ".tif": _write_tiff, ".tiff": _write_tiff,
    ".npy": _write_npy, ".hcc": _write_hcc,
}  # fmt: skip
