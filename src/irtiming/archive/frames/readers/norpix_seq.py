"""Norpix StreamPix SEQ: a header, then each picture with its time; pictures that are not packed."""

import struct
from dataclasses import replace
from pathlib import Path

import numpy as np

from irtiming.archive.frames.source import FrameFacts, FrameReader, FrameSource
from irtiming.archive.frames.strided import column, strided
from irtiming.records.arrays import Array, read_only

_MAGIC = struct.pack("<I", 0xFEED)
_HEAD_BYTES = 1024
_LARGE_HEAD_BYTES, _LARGE_SINCE = 8192, 5
_PLAIN = (100, 101)
_STAMP_BYTES = 8


def _open(path: Path) -> FrameSource:
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
    if len(head) < _HEAD_BYTES:
        raise EOFError(f"its header has {len(head)} bytes of {_HEAD_BYTES}")
    version = struct.unpack_from("<i", head, 28)[0]
    columns, rows, bits, real_bits, image_bytes, form, frames, _, stride = struct.unpack_from("<9I", head, 548)
    rate_hz = struct.unpack_from("<d", head, 584)[0]
    if form not in _PLAIN or bits not in (8, 16):
        raise ValueError(
            f"its pictures are of format {form} with {bits} bits; export it unpacked in grey of 8 or 16 bits"
        )
    begin = _LARGE_HEAD_BYTES if version >= _LARGE_SINCE else _HEAD_BYTES
    if image_bytes != rows * columns * bits // 8 or stride < image_bytes:
        raise ValueError(f"its pictures of {rows} x {columns} pixels have {image_bytes} bytes, {stride} bytes apart")
    dtype = f"uint{bits}"
    facts = FrameFacts(
        format="a Norpix SEQ file", frames=frames, rows=rows, columns=columns, dtype=dtype,
        bit_depth=real_bits if 1 <= real_bits <= bits else bits,
        frame_period_s=1.0 / rate_hz if 1e-6 < rate_hz < 1e9 else None,
        more={"version": float(version)},
    )  # fmt: skip
    source = strided(path, facts, begin=begin, stride=stride, kind=f"<u{bits // 8}")
    if stride < image_bytes + _STAMP_BYTES:
        return source
    times_s = _times(path, begin=begin + image_bytes, stride=stride, n=frames)
    facts = replace(facts, times_s=times_s, time_scale="UTC", time_step_s=1e-6)
    return strided(path, facts, begin=begin, stride=stride, kind=f"<u{bits // 8}")


def _times(path: Path, *, begin: int, stride: int, n: int) -> Array:
    """Seconds since 1970, shape (n,): seconds, thousandths and millionths behind each picture."""
    parts = (("<u4", 0, 1.0), ("<u2", 4, 1e-3), ("<u2", 6, 1e-6))
    found = [unit_s * column(path, begin=begin + at, stride=stride, n=n, kind=kind) for kind, at, unit_s in parts]
    return read_only(np.sum(found, axis=0))


READER = FrameReader(title="Norpix SEQ", takes=lambda _, begin: begin.startswith(_MAGIC), open=_open)
