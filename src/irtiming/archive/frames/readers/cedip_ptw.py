"""FLIR/Cedip PTW: a main header, then each frame behind a header of its own.

Fields as the Altair reference guide (DL002U-D) lists them, and as pyradi's reader takes them; the microseconds of a frame follow
its milliseconds.
"""

import struct
from pathlib import Path
from typing import Any

import numpy as np

from irtiming.archive.frames.bounds import require_bytes, require_size
from irtiming.archive.frames.source import FrameFacts, FrameReader, FrameSource
from irtiming.archive.frames.strided import column, strided
from irtiming.records.arrays import Array, read_only
from irtiming.records.camera_frame import CameraIdentity

_LEAST_BYTES = 2048
_LOCK_IN = (1220, 3907, 1204, 2382)
_DAY_S = 86400.0
_MINUTE, _HOUR, _HUNDREDTH, _SECOND, _THOUSANDTH, _MICROSECOND = 80, 81, 82, 83, 160, 161
_LEAST_FRAME_HEADER = 163


def _open(path: Path) -> FrameSource:
    with path.open("rb") as file:
        head = file.read(_LEAST_BYTES)
        if len(head) < _LEAST_BYTES:
            raise EOFError(f"its header has {len(head)} bytes of {_LEAST_BYTES}")
        main_bytes, frame_head, _, _, frames = struct.unpack_from("<5I", head, 11)
        columns, rows, bits = struct.unpack_from("<3H", head, 377)
        require_size(path, frames=frames, rows=rows, columns=columns, dtype="uint16")
        stride, begin = frame_head + 2 * rows * columns, main_bytes + frame_head
        require_bytes(path, needed=main_bytes + frames * stride)
        file.seek(begin)
        first_line = np.fromfile(file, "<u2", columns)
    if tuple(first_line[: len(_LOCK_IN)]) == _LOCK_IN:  # the first row holds the lock-in signal
        rows, begin = rows - 1, begin + 2 * columns
    times_s = _times(path, begin=main_bytes, stride=stride, n=frames) if frame_head >= _LEAST_FRAME_HEADER else None
    facts = FrameFacts(
        format="a FLIR/Cedip PTW file", frames=frames, rows=rows, columns=columns, dtype="uint16",
        bit_depth=bits if 1 <= bits <= 16 else None, times_s=times_s,
        time_scale="" if times_s is None else "time of day", time_step_s=None if times_s is None else 1e-6,
        **_told(head),
    )  # fmt: skip
    return strided(path, facts, begin=begin, stride=stride, kind="<u2")


def _times(path: Path, *, begin: int, stride: int, n: int) -> Array:
    """Seconds after midnight, shape (n,), beyond a day where midnight passes."""
    places = {_HOUR: 3600.0, _MINUTE: 60.0, _SECOND: 1.0, _HUNDREDTH: 1e-2, _THOUSANDTH: 1e-3}
    times_s = np.zeros(n)
    for place, unit_s in places.items():
        times_s += unit_s * column(path, begin=begin + place, stride=stride, n=n, kind="u1")
    times_s += 1e-6 * column(path, begin=begin + _MICROSECOND, stride=stride, n=n, kind="<u2")
    nights = np.concatenate([[0], np.cumsum(np.diff(times_s) < -_DAY_S / 2)])
    return read_only(times_s + _DAY_S * nights)


def _told(head: bytes) -> dict[str, Any]:
    period_s, integration_s = struct.unpack_from("<2f", head, 403)
    year, day, month, minute, hour, hundredth, second = struct.unpack_from("<H6B", head, 35)
    is_date = 1 <= month <= 12 and 1 <= day <= 31 and hour < 24 and minute < 60 and second < 60 and hundredth < 100
    model, serial = _text(head, 44, 20), _text(head, 220, 11)
    more = {"lens": _text(head, 64, 20), "filter": _text(head, 84, 20), "version": _text(head, 5, 5)}
    return {
        "camera": CameraIdentity(vendor="FLIR/Cedip", model=model, serial_number=serial, firmware="", address=""),
        "start_time": (
            f"{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{hundredth:02}" if is_date else ""
        ),
        "integration_time_s": _positive(integration_s),
        "frame_period_s": _positive(period_s),
        "more": {name: text for name, text in more.items() if text} | {"external_trigger": float(head[397] == 1)},
    }


def _positive(value: float) -> float | None:
    return float(np.float32(value)) if 0 < value < 1e6 else None


def _text(head: bytes, at: int, length: int) -> str:
    text = head[at : at + length].split(b"\0")[0].decode("latin-1")
    return "".join(letter for letter in text if letter.isprintable()).strip()


READER = FrameReader(title="FLIR/Cedip PTW", takes=lambda _, begin: begin.startswith(b"CED\0"), open=_open)
