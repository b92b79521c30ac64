"""ENVI: bare values of pixels with a text header; each band is a frame."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from irtiming.archive.frames.bounds import require_bytes, require_size
from irtiming.archive.frames.source import FrameFacts, FrameReader, Frames, FrameSource, FrameValues, Read
from irtiming.archive.frames.strided import strided
from irtiming.records.camera_frame import CameraIdentity

_KINDS = {1: "u1", 2: "i2", 3: "i4", 4: "f4", 5: "f8", 12: "u2", 13: "u4"}
_HEADER = ".hdr"
_SUFFIXES = (".dat", ".img", ".raw", ".bin", ".bsq", ".bil", ".bip", "")
_MOST_HEADER_BYTES = 2**22
_ENTRY = re.compile(r"^\s*([^=;\n]+?)\s*=\s*(\{[^}]*\}|[^\n]*)", re.MULTILINE)


def _pair(path: Path) -> tuple[Path, Path] | None:
    """Header and data, whichever of the two is named."""
    if path.suffix.lower() == _HEADER:
        bare = path.with_suffix("")
        both = (bare, *(path.with_suffix(end) for end in _SUFFIXES if end))
        data = next((one for one in both if one.is_file()), None)
        return None if data is None else (path, data)
    headers = (path.with_name(path.name + _HEADER), path.with_suffix(_HEADER))
    header = next((one for one in headers if one.is_file()), None)
    return None if header is None else (header, path)


def _takes(path: Path, begin: bytes) -> bool:
    if path.suffix.lower() == _HEADER:
        return begin.lstrip().startswith(b"ENVI")
    if path.suffix.lower() not in _SUFFIXES or path.is_dir():
        return False
    pair = _pair(path)
    if pair is None:
        return False
    with pair[0].open("rb") as file:
        return file.read(64).lstrip().startswith(b"ENVI")


def _open(path: Path) -> FrameSource:
    pair = _pair(path)
    if pair is None:
        raise ValueError("the file with its data is not beside it")
    header, data = pair
    with header.open("rb") as file:
        text = file.read(_MOST_HEADER_BYTES).decode("utf-8", "replace")
    entries = {key.lower(): value.strip() for key, value in _ENTRY.findall(text)}
    frames, rows, columns, begin = (_whole(entries, key) for key in ("bands", "lines", "samples", "header offset"))
    code = _whole(entries, "data type")
    if code not in _KINDS:
        raise ValueError(f"its data type is {code}; it must be one of {', '.join(map(str, _KINDS))}")
    kind = f"{'>' if _whole(entries, 'byte order') else '<'}{_KINDS[code]}"
    facts = FrameFacts(
        format="an ENVI file", frames=frames, rows=rows, columns=columns, dtype=np.dtype(kind).newbyteorder("=").name,
        **_told(entries),
    )  # fmt: skip
    require_size(data, frames=frames, rows=rows, columns=columns, dtype=facts.dtype)
    order = entries.get("interleave", "bsq").lower()
    if order == "bsq":
        return strided(data, facts, begin=begin, stride=facts.frame_bytes, kind=kind)
    if order not in ("bil", "bip"):
        raise ValueError(f"its interleave is {order!r}; it must be bsq, bil or bip")
    require_bytes(data, needed=begin + frames * facts.frame_bytes)

    @contextmanager
    def reading() -> Iterator[Read]:
        shape = (rows, frames, columns) if order == "bil" else (rows, columns, frames)
        values = np.memmap(data, kind, mode="r", offset=begin, shape=shape)
        stack = values.transpose((1, 0, 2) if order == "bil" else (2, 0, 1))

        def read(first: int, count: int) -> FrameValues:
            return np.ascontiguousarray(stack[first : first + count])

        yield read

    return Frames(data, facts, reading)


def _whole(entries: dict[str, str], key: str) -> int:
    text = entries.get(key, "0" if key in ("header offset", "byte order") else "")
    if not re.fullmatch(r"\d{1,15}", text):
        raise ValueError(f"its header says '{key} = {text[:40]}'; it must be a whole number")
    return int(text)


def _told(entries: dict[str, str]) -> dict[str, Any]:
    sensor = entries.get("sensor type", "")[:200]
    fps = _number(entries.get("fps", ""))
    tint = _number(entries.get("tint", ""))  # milliseconds in the headers of Specim's cameras
    identity = CameraIdentity(vendor="", model=sensor, serial_number="", firmware="", address="")
    return {
        "camera": identity if sensor else None,
        "start_time": entries.get("acquisition time", "")[:100],
        "integration_time_s": None if tint is None else tint * 1e-3,
        "frame_period_s": None if fps is None else 1.0 / fps,
    }


def _number(text: str) -> float | None:
    return float(text) if re.fullmatch(r"\d{1,12}(\.\d{1,12})?", text) and float(text) > 0 else None


READER = FrameReader(title="ENVI", takes=_takes, open=_open, beside=lambda path: _pair(path) or ())
