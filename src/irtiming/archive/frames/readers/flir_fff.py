"""FLIR FFF: a directory of records, one with the picture and one with the camera; SEQ and CSQ are many of them in a row.

Records and fields as ExifTool documents them (FLIR tags). Pictures are plain, PNG (whose bytes FLIR swaps), or JPEG-LS.
"""

import struct
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Literal, final

import numpy as np

from irtiming.archive.frames.bounds import MOST_FRAMES, require_size
from irtiming.archive.frames.source import FrameFacts, FrameReader, Frames, FrameSource, FrameValues, Read
from irtiming.records.arrays import read_only
from irtiming.records.camera_frame import CameraIdentity

_MAGIC = (b"FFF\0", b"AFF\0")
_HEAD_BYTES, _RECORD_BYTES, _RAW_HEAD_BYTES = 64, 32, 32
_MOST_RECORDS = 4096
_PADDING_BYTES = 8
_RAW_DATA, _CAMERA_INFO = 0x01, 0x20
_TEST = 2  # what the first number of a record is in its own byte order
_TIME = 0x384
_FRAME_RATE = 0x464
_PNG, _JPEG = b"\x89PNG", b"\xff\xd8\xff"
_JPEG_LS_FRAME = 0xF7
_PLANCK = {"planck_r1": 0x58, "planck_b": 0x5C, "planck_f": 0x60, "planck_r2": 0x30C, "emissivity": 0x20}


@final
@dataclass(frozen=True, kw_only=True)
class _Picture:
    """Where the values of one frame are, and how they are packed; ``camera`` is the place of what is said of the camera."""

    begin: int
    n_bytes: int
    order: Literal["<", ">"]
    packing: Literal["", "png", "jpeg-ls"]
    rows: int
    columns: int
    camera: tuple[int, int] | None


def _open(path: Path) -> FrameSource:
    size = path.stat().st_size
    with path.open("rb") as file:
        pictures = list(_pictures(file, size))
        first = pictures[0]
        for number, one in enumerate(pictures):
            if (one.rows, one.columns) != (first.rows, first.columns):
                raise ValueError(
                    f"frame {number} has {one.rows} x {one.columns} pixels, frame 0 {first.rows} x {first.columns}"
                )
        require_size(path, frames=len(pictures), rows=first.rows, columns=first.columns, dtype="uint16")
        for number, one in enumerate(pictures):
            if not one.packing and one.n_bytes < 2 * one.rows * one.columns:
                raise EOFError(f"frame {number} has {one.n_bytes} bytes for {one.rows} x {one.columns} pixels")
        told = _told(file, pictures)
    form = "a FLIR FFF file" if len(pictures) == 1 else "a FLIR SEQ file (FFF frames)"
    packed = f" packed as {first.packing.upper()}" if first.packing else ""
    facts = FrameFacts(
        format=form + packed, frames=len(pictures), rows=first.rows, columns=first.columns, dtype="uint16", **told
    )

    @contextmanager
    def reading() -> Iterator[Read]:
        with path.open("rb") as file:

            def read(first: int, count: int) -> FrameValues:
                block = np.empty((count, facts.rows, facts.columns), np.uint16)
                for place in range(count):
                    block[place] = _values(file, pictures[first + place])
                return block

            yield read

    return Frames(path, facts, reading)


def _pictures(file: IO[bytes], size: int) -> Iterator[_Picture]:
    """One after the other; each FFF ends where its last record does."""
    begin = number = 0
    while begin < size:
        found, length = _one(file, begin, size=size, number=number)
        yield found
        begin, number = begin + length, number + 1
        if number > MOST_FRAMES:
            raise ValueError(f"it has more than {MOST_FRAMES} frames")
        begin = _next(file, begin, size=size)


def _next(file: IO[bytes], begin: int, *, size: int) -> int:
    """Where the next frame begins: zeros between frames are passed over."""
    while begin < size:
        file.seek(begin)
        content = file.read(4096)
        rest = content.lstrip(b"\0")
        begin += len(content) - len(rest)
        if rest:
            break
    return begin


def _one(file: IO[bytes], begin: int, *, size: int, number: int) -> Any:
    """The picture of the FFF that begins there, and the bytes of all of it."""
    file.seek(begin)
    head = file.read(_HEAD_BYTES)
    if len(head) < _HEAD_BYTES or not head.startswith(_MAGIC):
        raise ValueError(
            f"no frame begins at byte {begin}, behind frame {number - 1} of it: the file is cut or damaged"
        )
    order = "<" if 100 <= int.from_bytes(head[20:24], "little") < 200 else ">"
    directory, n_records = struct.unpack_from(f"{order}2I", head, 24)
    if n_records > _MOST_RECORDS or begin + directory + n_records * _RECORD_BYTES > size:
        raise EOFError(
            f"frame {number} says that it has {n_records} records from byte {begin + directory}; the file has {size}"
        )
    file.seek(begin + directory)
    entries = file.read(n_records * _RECORD_BYTES)
    length = directory + n_records * _RECORD_BYTES
    raw = camera = None
    for kind, _, _, _, offset, n_bytes, *_ in struct.iter_unpack(f"{order}2H7I", entries):
        beyond = begin + offset + n_bytes - size if kind else 0
        if kind == _RAW_DATA and 0 < beyond < _PADDING_BYTES:  # a packed picture's length is rounded up
            n_bytes, beyond = n_bytes - beyond, 0
        if beyond > 0:
            raise EOFError(
                f"frame {number} ends at byte {begin + offset + n_bytes}, the file at {size}: it is cut short"
            )
        length = max(length, offset + n_bytes) if kind else length
        if kind == _RAW_DATA and raw is None:
            raw = begin + offset, n_bytes
        elif kind == _CAMERA_INFO and camera is None:
            camera = begin + offset, n_bytes
    if raw is None:
        raise ValueError(f"frame {number} has no picture")
    return _picture(file, raw[0], n_bytes=raw[1], camera=camera), length


def _picture(file: IO[bytes], begin: int, *, n_bytes: int, camera: tuple[int, int] | None) -> _Picture:
    file.seek(begin)
    head = file.read(_RAW_HEAD_BYTES + 4)
    order: Literal["<", ">"] = "<" if head[:2] == b"\x02\0" else ">"
    test, columns, rows = struct.unpack_from(f"{order}3H", head)
    if test != _TEST:
        raise ValueError(f"the picture at byte {begin} begins with {test}, not {_TEST}")
    start = head[_RAW_HEAD_BYTES:]
    packing: Literal["", "png", "jpeg-ls"] = "png" if start == _PNG else "jpeg-ls" if start.startswith(_JPEG) else ""
    return _Picture(
        begin=begin + _RAW_HEAD_BYTES, n_bytes=n_bytes - _RAW_HEAD_BYTES, order=order, packing=packing, rows=rows,
        columns=columns, camera=camera,
    )  # fmt: skip


def _values(file: IO[bytes], picture: _Picture) -> FrameValues:
    """Counts of one frame, shape (row, column)."""
    shape = (picture.rows, picture.columns)
    file.seek(picture.begin)
    if not picture.packing:
        return np.fromfile(file, f"{picture.order}u2", shape[0] * shape[1]).reshape(shape)
    content = file.read(picture.n_bytes)
    import imagecodecs

    if picture.packing == "png":
        if struct.unpack_from(">2I", content, 16) != shape[::-1]:
            raise ValueError("its PNG is of another size than it says")
        return np.asarray(imagecodecs.png_decode(content)).astype(np.uint16).byteswap()
    if _jpeg_ls_size(content) != shape:
        raise ValueError("its JPEG-LS is of another size than it says")
    return np.asarray(imagecodecs.jpegls_decode(content))


def _jpeg_ls_size(content: bytes) -> tuple[int, int]:
    """Rows and columns in the header of a picture, which stands behind other segments."""
    at = 2
    while at + 9 <= len(content) and content[at] == 0xFF and content[at + 1] != _JPEG_LS_FRAME:
        at += 2 + int.from_bytes(content[at + 2 : at + 4], "big")
    rows, columns = struct.unpack_from(">2H", content, at + 5)
    return rows, columns


def _told(file: IO[bytes], pictures: list[_Picture]) -> dict[str, Any]:
    """What the records of the camera say: of the first frame, and the time of each."""
    places = [one.camera for one in pictures]
    if places[0] is None:
        return {}
    info = _record(file, places[0])
    order = "<" if info[:2] == b"\x02\0" else ">"
    rate = struct.unpack_from(f"{order}H", info, _FRAME_RATE)[0] if len(info) >= _FRAME_RATE + 2 else 0
    more: dict[str, str | float] = {"part_number": _text(info, 0xF4, 16), "lens": _text(info, 0x170, 32)}
    for name, at in _PLANCK.items():
        if len(info) >= at + 4:
            more[name] = float(struct.unpack_from(f"{order}f", info, at)[0])
    if len(info) >= 0x30C:
        more["planck_o"] = float(struct.unpack_from(f"{order}i", info, 0x308)[0])
    identity = CameraIdentity(
        vendor="FLIR", model=_text(info, 0xD4, 32), serial_number=_text(info, 0x104, 16), firmware=_text(info, 0x114, 16),
        address="",
    )  # fmt: skip
    told: dict[str, Any] = {
        "camera": identity,
        "frame_period_s": 1.0 / rate if rate else None,
        "more": {name: value for name, value in more.items() if value not in ("", 0.0)},
    }
    times = [None if place is None else _time(file, place) for place in places]
    if None not in times:
        told |= {"times_s": read_only(np.array(times, np.float64)), "time_scale": "UTC", "time_step_s": 1e-3}
    return told


def _record(file: IO[bytes], place: tuple[int, int]) -> bytes:
    file.seek(place[0])
    return file.read(min(place[1], 2**16))


def _time(file: IO[bytes], place: tuple[int, int]) -> float | None:
    """Seconds since 1970, UTC; None where there are none."""
    if place[1] < _TIME + 8:
        return None
    file.seek(place[0])
    order = "<" if file.read(2) == b"\x02\0" else ">"
    file.seek(place[0] + _TIME)
    second, thousandths = struct.unpack(f"{order}2I", file.read(8))
    return float(second + (thousandths & 0xFFFF) / 1000) if second else None


def _text(info: bytes, at: int, length: int) -> str:
    text = info[at : at + length].split(b"\0")[0].decode("latin-1")
    return "".join(letter for letter in text if letter.isprintable()).strip()


READER = FrameReader(title="FLIR FFF, SEQ or CSQ", takes=lambda _, begin: begin.startswith(_MAGIC), open=_open)
