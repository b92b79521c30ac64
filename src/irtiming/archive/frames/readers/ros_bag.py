"""Bags of ROS 1 and ROS 2, by rosbags: images of one topic, with the stamps of their headers. No ROS is needed."""

import struct
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from irtiming.archive.frames.bounds import require_size
from irtiming.archive.frames.source import FrameFacts, FrameReader, Frames, FrameSource, FrameValues, Read
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Array, read_only

_IMAGE = "sensor_msgs/msg/Image"
_TYPES = {
    "mono8": "u1", "8UC1": "u1", "mono16": "u2", "16UC1": "u2", "16SC1": "i2", "32SC1": "i4", "32FC1": "f4", "64FC1": "f8",
}  # fmt: skip
"""Type of a pixel by the message's encoding: of one grey channel."""

_STAMP = 4
"""Where in a message the header's stamp stands: after the number of ROS 1, after the four bytes of CDR in ROS 2."""

_METADATA = "metadata.yaml"


def _takes(path: Path, begin: bytes) -> bool:
    return begin.startswith(b"#ROSBAG V2.0") or (path.is_dir() and (path / _METADATA).is_file())


def _files(path: Path) -> Iterable[Path]:
    return path.iterdir() if path.is_dir() else ()


@contextmanager
def _opened(path: Path) -> Iterator[tuple[Any, Any]]:
    """The bag, and its one topic of images."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as bag:
        topics = sorted({one.topic for one in bag.connections if one.msgtype == _IMAGE and one.msgcount})
        if len(topics) != 1:
            held = f"{len(topics)} topics of images ({', '.join(topics)})" if topics else "no topic of images"
            cure = f"it must hold one ({_IMAGE}); filter it when you record or convert it"
            raise ArchiveError(f"holds {held}; {cure}", where=str(path))
        yield bag, [one for one in bag.connections if one.topic == topics[0]]


def _open(path: Path) -> FrameSource:
    with _opened(path) as (bag, topic):
        connection, _, raw = next(bag.messages(connections=topic))
        first = bag.deserialize(raw, connection.msgtype)
        kind = _TYPES.get(first.encoding)
        if kind is None:
            known = ", ".join(_TYPES)
            raise ArchiveError(
                f"has images encoded as {first.encoding[:40]}; they must be one of {known}", where=str(path)
            )
        stamps = [_stamp(message, is_ros2=bag.is2) for _, _, message in bag.messages(connections=topic)]
    facts = FrameFacts(
        format="a bag of ROS 2" if bag.is2 else "a bag of ROS 1",
        frames=len(stamps), rows=int(first.height), columns=int(first.width), dtype=np.dtype(kind).name,
        times_s=_times(stamps), time_scale="UTC", time_step_s=1e-9,
        more={"topic": topic[0].topic, "frame_id": str(first.header.frame_id)[:200]},
    )  # fmt: skip
    require_size(path, frames=facts.frames, rows=facts.rows, columns=facts.columns, dtype=facts.dtype)

    @contextmanager
    def reading() -> Iterator[Read]:
        with _opened(path) as (bag, topic):
            yield _Images(bag, topic)

    return Frames(path, facts, reading)


class _Images:
    """Images of a bag that is open, one after the other; one further back begins anew."""

    def __init__(self, bag: Any, topic: Any) -> None:
        self._bag, self._topic = bag, topic
        self._messages, self._next = bag.messages(connections=topic), 0

    def __call__(self, first: int, count: int) -> FrameValues:
        """Frames by the index of the first and their number, shape (count, row, column)."""
        if first < self._next:
            self._messages, self._next = self._bag.messages(connections=self._topic), 0
        while self._next < first:
            next(self._messages)
            self._next += 1
        self._next += count
        return np.stack([self._image(*next(self._messages)) for _ in range(count)])

    def _image(self, connection: Any, _: int, raw: bytes) -> FrameValues:
        one = self._bag.deserialize(raw, connection.msgtype)
        kind = np.dtype(_TYPES[one.encoding]).newbyteorder(">" if one.is_bigendian else "<")
        rows, columns, step = int(one.height), int(one.width), int(one.step)
        if step < columns * kind.itemsize or len(one.data) < rows * step:
            raise ValueError(f"an image of {rows} x {columns} pixels in {len(one.data)} bytes, {step} for each row")
        bytes_of = np.asarray(one.data, np.uint8)[: rows * step].reshape(rows, step)[:, : columns * kind.itemsize]
        return np.ascontiguousarray(bytes_of).view(kind)


def _stamp(message: bytes, *, is_ros2: bool) -> tuple[int, int]:
    """Seconds and nanoseconds of the header, which every image begins with."""
    if is_ros2:
        order = "<" if message[1] & 1 else ">"
        found = struct.unpack_from(f"{order}iI", message, _STAMP)
    else:
        found = struct.unpack_from("<II", message, _STAMP)
    return int(found[0]), int(found[1])


def _times(stamps: list[tuple[int, int]]) -> Array | None:
    """Seconds since 1970, shape (n_frames,); None where the driver left the stamps at zero."""
    if not any(seconds or rest for seconds, rest in stamps):
        return None
    return read_only(np.array([seconds + 1e-9 * rest for seconds, rest in stamps], np.float64))


READER = FrameReader(title="ROS 1 or ROS 2 bag", takes=_takes, open=_open, beside=_files)
