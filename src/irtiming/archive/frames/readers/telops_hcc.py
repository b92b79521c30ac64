"""Telops HCC, by fasthcc: two lines of header before each frame, with the time, integration time and what else was set."""

from pathlib import Path
from typing import Any

import numpy as np

from irtiming.archive.frames.bounds import require_size
from irtiming.archive.frames.source import FrameFacts, FrameReader, FrameSource
from irtiming.archive.frames.strided import column, strided
from irtiming.records.arrays import read_only
from irtiming.records.camera_frame import CameraIdentity

_LATEST = 50
_FRAME_ID, _SECOND, _FRACTION = 8, 100, 104
_STEP_S = 1e-7
_WITH_TIME = 10  # version of the header since which times are known
_LEAST_HEADER = 108
_MODES = {0: "raw counts", 1: "counts, corrected for non-uniformity", 2: "temperatures", 3: "in-band radiance"}
_MORE = {
    "DataOffset": "data_offset", "DataExp": "data_exponent", "TriggerMode": "trigger_mode", "TriggerSource": "trigger_source",
    "TriggerDelay": "trigger_delay_us", "IntegrationMode": "integration_mode",
}  # fmt: skip


def _takes(path: Path, begin: bytes) -> bool:
    return begin.startswith(b"TC") and len(begin) > 4 and 5 <= begin[3] < _LATEST


def _open(path: Path) -> FrameSource:
    from fasthcc.header import frame_stride, header_raw_size, parse_header

    with path.open("rb") as file:
        head = parse_header(file.read(512))
    rows, columns = head["Height"], head["Width"]
    require_size(path, frames=1, rows=rows, columns=columns, dtype="uint16")
    stride, header_bytes = frame_stride(columns, rows), header_raw_size(columns)
    frames, rest = divmod(path.stat().st_size, stride)
    if rest or not frames:
        raise EOFError(f"behind {frames} frames of {stride} bytes there are {rest} bytes: it is cut short")
    told = _told(path, head, n=frames, stride=stride) if header_bytes >= _LEAST_HEADER else {}
    facts = FrameFacts(
        format="a Telops HCC file", frames=frames, rows=rows, columns=columns, dtype="uint16",
        integration_time_s=head["ExposureTime"] * 1e-6 or None, **told,
    )  # fmt: skip
    return strided(path, facts, begin=header_bytes, stride=stride, kind="<u2")


def _told(path: Path, head: dict[str, Any], *, n: int, stride: int) -> dict[str, Any]:
    def each(at: int) -> np.ndarray:
        return column(path, begin=at, stride=stride, n=n, kind="<u4")

    rate_hz = head["AcquisitionFrameRate"]
    version = f"{head['DeviceXMLMajorVersion']}.{head['DeviceXMLMinorVersion']}"
    more = {ours: float(head[theirs]) for theirs, ours in _MORE.items() if np.isfinite(head.get(theirs, np.nan))}
    told: dict[str, Any] = {
        "camera": CameraIdentity(vendor="Telops", model="", serial_number="", firmware="", address=""),
        "frame_period_s": 1.0 / rate_hz if rate_hz > 0 else None,
        "frame_id": read_only(each(_FRAME_ID).astype(np.int64)),
        "more": {"header_version": version, "values": _MODES.get(head["CalibrationMode"], "unknown"), **more},
    }
    if head["DeviceXMLMajorVersion"] >= _WITH_TIME and (second := each(_SECOND))[0]:
        told |= {"times_s": read_only(second + _STEP_S * each(_FRACTION)), "time_scale": "UTC", "time_step_s": _STEP_S}
    return told


READER = FrameReader(title="Telops HCC", takes=_takes, open=_open)
