"""Single pictures of grey pixels: PNG of 8 or 16 bits by imagecodecs, and PGM."""

import re
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from irtiming.archive.frames.bounds import require_size
from irtiming.archive.frames.source import FrameFacts, FrameReader, Frames, FrameSource, FrameValues, Read
from irtiming.archive.frames.strided import strided

_PNG = b"\x89PNG\r\n\x1a\n"
_GAP = rb"(?:\s++#[^\n]*+)*+\s++"  # white space and comments; possessive, for else a line of comments takes for ever to refuse
_PGM = re.compile(rb"P5" + _GAP + rb"(\d{1,9})" + _GAP + rb"(\d{1,9})" + _GAP + rb"(\d{1,9})\s")
_GREY = 0


def _open(path: Path) -> FrameSource:
    with path.open("rb") as file:
        begin = file.read(4096)
    if begin.startswith(_PNG):
        return _open_png(path, begin)
    found = _PGM.match(begin)
    if found is None:
        raise ValueError("it has no header of a PGM")
    columns, rows, highest = (int(one) for one in found.groups())
    kind = ">u2" if highest > 255 else "u1"
    facts = FrameFacts(
        format="a PGM picture", frames=1, rows=rows, columns=columns, dtype="uint16" if highest > 255 else "uint8",
        bit_depth=min(highest, 2**16 - 1).bit_length(),
    )  # fmt: skip
    return strided(path, facts, begin=found.end(), stride=facts.frame_bytes, kind=kind)


def _open_png(path: Path, begin: bytes) -> FrameSource:
    columns, rows, bits, colour = struct.unpack_from(">IIBB", begin, 16)
    if colour != _GREY or bits not in (8, 16):
        raise ValueError(f"its pixels are of colour type {colour} with {bits} bits; export it in grey of 8 or 16 bits")
    kind = f"uint{bits}"
    require_size(path, frames=1, rows=rows, columns=columns, dtype=kind)
    facts = FrameFacts(format="a PNG picture", frames=1, rows=rows, columns=columns, dtype=kind, bit_depth=bits)
    import imagecodecs

    @contextmanager
    def reading() -> Iterator[Read]:
        content = path.read_bytes()

        def read(first: int, count: int) -> FrameValues:
            return np.asarray(imagecodecs.png_decode(content))[np.newaxis]

        yield read

    return Frames(path, facts, reading)


READER = FrameReader(title="PNG or PGM", takes=lambda _, begin: begin.startswith((_PNG, b"P5")), open=_open)
