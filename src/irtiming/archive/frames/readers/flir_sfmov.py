"""FLIR SFMOV of ResearchIR: lines of text up to the line DATA, then bare values; as sdypy-io and pysfmov read it."""

import re
from pathlib import Path

import numpy as np

from irtiming.archive.frames.source import FrameFacts, FrameReader, FrameSource
from irtiming.archive.frames.strided import strided
from irtiming.records.camera_frame import CameraIdentity

_MOST_HEADER_BYTES = 2**20
_DATA = b"DATA"
_AFTER = 6  # bytes from the word DATA to the first value
_WHOLE = re.compile(r"\d{1,12}")


def _open(path: Path) -> FrameSource:
    with path.open("rb") as file:
        head = file.read(_MOST_HEADER_BYTES)
    end = head.find(_DATA)
    if end < 0:
        raise ValueError("its header has no line DATA")
    entries: dict[str, str] = {}
    for line in head[:end].split(b"saf_padding")[0].decode("latin-1").splitlines():
        key, _, value = line.partition(" ")
        entries[key] = value.strip()
    columns, rows, declared = (_whole(entries, name) for name in ("xPixls", "yPixls", "NumDPs"))
    kind = entries.get("DaType", "")
    if "flt" in kind.lower() and "32" not in kind:
        raise ValueError(f"its values are {kind}; they must be 16-bit counts or Flt32")
    dtype = "float32" if "flt" in kind.lower() else "uint16"
    frame_bytes = rows * columns * np.dtype(dtype).itemsize
    there, rest = divmod(path.stat().st_size - end - _AFTER, max(1, frame_bytes))
    if rest or there < declared:
        said = f"it says that it has {declared} frames of {frame_bytes} bytes"
        raise EOFError(f"{said}, and has {there} and {rest} bytes: it is cut short")
    camera, serial = (entries.get(name, "") for name in ("Camera", "CameraSerial"))
    identity = CameraIdentity(vendor="FLIR", model=camera, serial_number=serial, firmware="", address="")
    facts = FrameFacts(
        format="a FLIR SFMOV file", frames=there, rows=rows, columns=columns, dtype=dtype,
        unit="" if dtype == "float32" else "DN", camera=identity if camera or serial else None,
        more={key: value[:200] for key, value in entries.items() if value.isprintable() and key.isalnum() and value},
    )  # fmt: skip
    return strided(path, facts, begin=end + _AFTER, stride=facts.frame_bytes, kind=f"<{np.dtype(dtype).str[1:]}")


def _whole(entries: dict[str, str], name: str) -> int:
    text = (entries.get(name, "").split() or [""])[0]
    if not _WHOLE.fullmatch(text):
        raise ValueError(f"its header says {name} = {text[:40]!r}; it must be a whole number")
    return int(text)


READER = FrameReader(title="FLIR SFMOV", takes=lambda _, begin: b"xPixls" in begin and b"yPixls" in begin, open=_open)
