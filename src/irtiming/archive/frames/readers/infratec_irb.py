"""InfraTec IRB: a directory of blocks, of which pictures hold temperatures as places in a table of 256, and what is between them.

As two descriptions have it: jonathanschilling/irb (docs/irb_file_format.md) and tomsoftware/Irbis-File-Format.
"""

import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np

from irtiming.archive.frames.bounds import MOST_FRAMES, require_size
from irtiming.archive.frames.source import FrameFacts, FrameReader, Frames, FrameSource, FrameValues, Read
from irtiming.records.arrays import Array, read_only
from irtiming.records.camera_frame import CameraIdentity

_MAGIC = b"\xffIRB\0"
_FILE_HEAD, _BLOCK_BYTES, _PICTURE_HEAD = 64, 32, 60 + 1024 + 644
_IMAGE, _NEXT = 1, 4
_MOST_BLOCKS = 2**16
_META = 1084
_DAYS_TO_1970 = 25569.0  # from 1899-12-30, where the days of the file count from
_DAY_S = 86400.0
_PLAIN, _RUNS = 0, 1


def _open(path: Path) -> FrameSource:
    size = path.stat().st_size
    with path.open("rb") as file:
        places = list(_places(file, size))
        if not places:
            raise ValueError("it holds no picture")
        heads = []
        for begin, n_bytes in places:
            file.seek(begin)
            heads.append(file.read(_PICTURE_HEAD))
            _require(heads[-1], n_bytes, like=heads[0])
        _, _, columns, rows = struct.unpack_from("<4H", heads[0])
    require_size(path, frames=len(places), rows=rows, columns=columns, dtype="float32")
    facts = FrameFacts(
        format="an InfraTec IRB file",
        frames=len(places),
        rows=rows,
        columns=columns,
        dtype="float32",
        unit="K",
        **_told(heads),
    )

    @contextmanager
    def reading() -> Iterator[Read]:
        with path.open("rb") as file:

            def read(first: int, count: int) -> FrameValues:
                block = np.empty((count, rows, columns), np.float32)
                for place in range(count):
                    begin, n_bytes = places[first + place]
                    file.seek(begin)
                    block[place] = _temperatures(file.read(n_bytes), rows=rows, columns=columns)
                return block

            yield read

    return Frames(path, facts, reading)


def _places(file: IO[bytes], size: int) -> Iterator[tuple[int, int]]:
    """Begin and bytes of each picture; frames of a film follow one another from block to block."""
    file.seek(0)
    head = file.read(_FILE_HEAD)
    if len(head) < _FILE_HEAD:
        raise EOFError(f"its header has {len(head)} bytes of {_FILE_HEAD}")
    begin, n_blocks = struct.unpack_from("<2I", head, 25)
    if n_blocks > _MOST_BLOCKS or begin + n_blocks * _BLOCK_BYTES > size:
        raise EOFError(f"it says that it has {n_blocks} blocks from byte {begin}; the file has {size} bytes")
    todo, seen = [(begin, n_blocks)], set()
    while todo:
        at, count = todo.pop(0)
        if at in seen:
            raise ValueError(f"its blocks turn in a circle at byte {at}")
        seen.add(at)
        file.seek(at)
        content = file.read(count * _BLOCK_BYTES)
        for kind, _, _, offset, n_bytes, *_ in struct.iter_unpack("<8I", content[: len(content) // 32 * 32]):
            if kind == _IMAGE and n_bytes > _PICTURE_HEAD:
                if offset + n_bytes > size:
                    raise EOFError(f"a picture ends at byte {offset + n_bytes}, the file at {size}: it is cut short")
                yield offset, n_bytes
            elif kind == _NEXT and offset:
                todo.append((offset, 2))
        if len(seen) > MOST_FRAMES:
            raise ValueError(f"it has more than {MOST_FRAMES} blocks")


def _require(head: bytes, n_bytes: int, *, like: bytes) -> None:
    pixel_bytes, packing, columns, rows = struct.unpack_from("<4H", head)
    if (columns, rows) != struct.unpack_from("<2H", like, 4):
        raise ValueError("its pictures are not all of one size")
    if packing not in (_PLAIN, _RUNS):
        raise ValueError(
            f"its pictures are packed by method {packing}, which is not known; export them without packing"
        )
    if packing == _PLAIN and pixel_bytes != 2:
        raise ValueError(f"its pixels have {pixel_bytes} bytes; they must have 2")
    if n_bytes - _PICTURE_HEAD < rows * columns * (1 if packing else 2):
        raise EOFError(f"a picture of {rows} x {columns} pixels has {n_bytes} bytes: it is cut short")


def _temperatures(content: bytes, *, rows: int, columns: int) -> FrameValues:
    """Temperatures of one picture, shape (row, column), K: between two entries of its table, in steps of 1/256."""
    _, packing = struct.unpack_from("<2H", content)
    table = np.frombuffer(content, "<f4", 256, 60)
    upper = np.append(table[1:], 2 * table[-1] - table[-2])
    values = np.frombuffer(content, np.uint8, offset=_PICTURE_HEAD)
    n_pixels = rows * columns
    if packing == _PLAIN:
        part, entry = values[: 2 * n_pixels : 2], values[1 : 2 * n_pixels : 2]
    else:
        part, runs = values[:n_pixels], values[n_pixels:]
        runs = runs[: len(runs) // 2 * 2].reshape(-1, 2)
        ends = np.cumsum(runs[:, 0], dtype=np.int64)
        needed = int(np.searchsorted(ends, n_pixels)) + 1
        entry = np.repeat(runs[:needed, 1], runs[:needed, 0])[:n_pixels]
        if len(entry) < n_pixels:
            raise EOFError(f"its runs end at pixel {len(entry)} of {n_pixels}: it is cut short")
    share = part.astype(np.float32) / np.float32(256)
    found = upper[entry] * share + table[entry] * (np.float32(1) - share)
    return np.maximum(found, np.float32(0)).reshape(rows, columns)


def _told(heads: list[bytes]) -> dict[str, Any]:
    first = heads[0]
    serial = _text(first, _META + 186, 16) or _text(first, _META + 164, 16)
    identity = CameraIdentity(
        vendor="InfraTec", model=_text(first, _META + 142, 12), serial_number=serial, firmware="", address=""
    )
    optics = {"optics": _text(first, _META + 202, 32), "optics_serial_number": _text(first, _META + 450, 16)}
    more: dict[str, str | float] = {name: text for name, text in optics.items() if text}
    emissivity = struct.unpack_from("<f", first, 24)[0]
    if 0 < emissivity <= 1:
        more["emissivity"] = float(emissivity)
    times_s = _times(heads)
    return {
        "camera": identity,
        "more": more,
        "times_s": times_s,
        "time_scale": "" if times_s is None else "local time",
        "time_step_s": None if times_s is None else 1e-3,
    }


def _times(heads: list[bytes]) -> Array | None:
    """Seconds since 1970 in the camera's local time, shape (n,); frames of a film count milliseconds from its beginning."""
    days = np.array([struct.unpack_from("<d", head, _META + 540)[0] for head in heads])
    thousandths = np.array([struct.unpack_from("<I", head, _META + 548)[0] for head in heads], np.float64)
    if not np.all((days > 1) & (days < 1e5)):
        return None
    first_s = (days[0] - _DAYS_TO_1970) * _DAY_S
    if len(heads) > 1 and np.all(np.diff(thousandths) > 0):
        return read_only(first_s + (thousandths - thousandths[0]) * 1e-3)
    return read_only((days - _DAYS_TO_1970) * _DAY_S)


def _text(head: bytes, at: int, length: int) -> str:
    text = head[at : at + length].split(b"\0")[0].decode("latin-1")
    return "".join(letter for letter in text if letter.isprintable() and letter != "ÿ").strip()


READER = FrameReader(title="InfraTec IRB", takes=lambda _, begin: begin.startswith(_MAGIC), open=_open)
