"""Video that loses nothing, by PyAV: FFV1 and others of grey pixels in Matroska or AVI, up to 16 bits."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from irtiming.archive.frames.bounds import MOST_FRAMES, require_size
from irtiming.archive.frames.source import FrameFacts, FrameReader, Frames, FrameSource, FrameValues, Read
from irtiming.records.arrays import read_only

_MATROSKA, _AVI = b"\x1aE\xdf\xa3", b"RIFF"
_LOSSLESS = ("ffv1", "rawvideo", "huffyuv", "ffvhuff", "utvideo", "png")
_GREY = re.compile(r"gray(\d*)(le|be)?")


def _container(path: Path) -> str:
    """Name of the container, once all of it is there: a decoder would take what is left of a file that is cut."""
    with path.open("rb") as file:
        head = file.read(4096)
    form = "matroska" if head.startswith(_MATROSKA) else "avi"
    end = 8 + int.from_bytes(head[4:8], "little")
    if form == "matroska":
        end = _end_of_element(head, _end_of_element(head, 0))
    if (size := path.stat().st_size) < end:
        raise EOFError(f"it has {size} bytes of {end}: it is cut short")
    return form


def _end_of_element(head: bytes, begin: int) -> int:
    """Where an element of Matroska ends that begins there (RFC 8794: identifier, size, contents); 0 where it does not say."""
    if begin + 2 > len(head):
        raise EOFError("its header is not all there")
    at = begin + 9 - max(1, head[begin].bit_length())
    if at >= len(head):
        raise EOFError("its header is not all there")
    length = 9 - max(1, head[at].bit_length())
    size = int.from_bytes(head[at : at + length], "big") & ((1 << 7 * length) - 1)
    return 0 if size == (1 << 7 * length) - 1 else at + length + size


def _open(path: Path) -> FrameSource:
    import av

    form = _container(path)
    with path.open("rb") as file, av.open(file, format=form) as container:
        stream = container.streams.video[0]
        codec = stream.codec_context
        grey = _GREY.fullmatch(codec.pix_fmt or "")
        if codec.name not in _LOSSLESS:
            raise ValueError(
                f"its codec {codec.name} loses what the camera saw; record it as {' or '.join(_LOSSLESS[:2])}"
            )
        if grey is None:
            raise ValueError(f"its pixels are {codec.pix_fmt}; they must be grey (gray, gray10le, ..., gray16le)")
        rows, columns, bits = codec.height, codec.width, int(grey[1] or 8)
        order = ">" if grey[2] == "be" else "<"
        kind, stored = ("uint8", "u1") if bits == 8 else ("uint16", f"{order}u2")
        require_size(path, frames=1, rows=rows, columns=columns, dtype=kind)
        stamps = _stamps(container, stream)
        more = {
            key: value[:200] for key, value in (container.metadata | stream.metadata).items() if value.isprintable()
        }
        name = {"ffv1": "FFV1"}.get(codec.name, codec.name)
    require_size(path, frames=len(stamps), rows=rows, columns=columns, dtype=kind)
    facts = FrameFacts(
        format=f"a video ({name} in {form.capitalize()})", frames=len(stamps), rows=rows, columns=columns, dtype=kind,
        bit_depth=bits, start_time=more.pop("creation_time", ""), more=more, **_times(stamps, stream.time_base),
    )  # fmt: skip

    @contextmanager
    def reading() -> Iterator[Read]:
        with path.open("rb") as file, av.open(file, format=form) as container:
            decoded = _Decoded(container, size=(rows, columns), kind=stored)
            yield decoded.read

    return Frames(path, facts, reading)


class _Decoded:
    """Frames of an open video; they come in order, and an earlier one begins anew."""

    def __init__(self, container: Any, *, size: tuple[int, int], kind: str) -> None:
        self._container, self._size, self._kind = container, size, kind
        self._place, self._frames = 0, container.decode(video=0)

    def read(self, first: int, count: int) -> FrameValues:
        """Frames from the first on, shape (count, row, column)."""
        if first < self._place:
            self._container.seek(0)
            self._place, self._frames = 0, self._container.decode(video=0)
        block = np.empty((count, *self._size), np.dtype(self._kind).newbyteorder("="))
        while self._place < first + count:
            frame = next(self._frames, None)
            if frame is None:
                raise EOFError(f"frame {self._place} cannot be decoded")
            if self._place >= first:
                block[self._place - first] = self._values(frame)
            self._place += 1
        return block

    def _values(self, frame: Any) -> FrameValues:
        rows, columns = self._size
        plane = frame.planes[0]
        if (frame.height, frame.width) != self._size:
            raise ValueError(f"a frame of {frame.height} x {frame.width} pixels among frames of {rows} x {columns}")
        kind = np.dtype(self._kind)
        return np.frombuffer(plane, kind).reshape(rows, plane.line_size // kind.itemsize)[:, :columns]


def _stamps(container: Any, stream: Any) -> list[int | None]:
    """Time of each frame in the stream's own steps, read without decoding."""
    found: list[int | None] = []
    for packet in container.demux(stream):
        if packet.size:
            found.append(packet.pts)
        if len(found) > MOST_FRAMES:
            raise ValueError(f"it has more than {MOST_FRAMES} frames")
    return found


def _times(stamps: list[int | None], time_base: Any) -> dict[str, Any]:
    if not time_base or any(stamp is None for stamp in stamps):
        return {}
    step_s = float(time_base)
    times_s = np.sort(np.array(stamps, np.float64)) * step_s
    return {"times_s": read_only(times_s), "time_scale": "first frame", "time_step_s": step_s}


READER = FrameReader(
    title="FFV1 video",
    takes=lambda _, begin: begin.startswith(_MATROSKA) or (begin.startswith(_AVI) and begin[8:12] == b"AVI "),
    open=_open,
)
