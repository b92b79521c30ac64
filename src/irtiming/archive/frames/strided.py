"""Frames that lie in a file one after the other, each as far from the one before."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from irtiming.archive.frames.bounds import require_bytes, require_size
from irtiming.archive.frames.source import FrameFacts, Frames, FrameValues, Read


def strided(path: Path, facts: FrameFacts, *, begin: int, stride: int, kind: str) -> Frames:
    """Frames of which the first begins at byte ``begin``; the next ones follow at every ``stride`` bytes.

    Parameters
    ----------
    path, facts
        The file and what it tells.
    begin, stride
        Bytes.
    kind
        Type of a pixel in the file with its byte order, such as ``"<u2"``.

    Raises
    ------
    ArchiveError
        If the file says sizes that cannot be, or is too short for them.
    """
    require_size(path, frames=facts.frames, rows=facts.rows, columns=facts.columns, dtype=facts.dtype)
    frame_bytes = facts.rows * facts.columns * np.dtype(kind).itemsize
    if begin < 0 or stride < frame_bytes:
        raise ValueError(f"frames of {frame_bytes} bytes, {stride} bytes apart, from byte {begin}")
    require_bytes(path, needed=begin + (facts.frames - 1) * stride + frame_bytes)

    @contextmanager
    def reading() -> Iterator[Read]:
        with path.open("rb") as file:

            def read(first: int, count: int) -> FrameValues:
                n_bytes = (count - 1) * stride + frame_bytes
                file.seek(begin + first * stride)
                content = np.fromfile(file, np.uint8, n_bytes)
                if content.size < n_bytes:
                    raise EOFError(f"frame {first + content.size // stride} is not all there")
                item = np.dtype(kind).itemsize
                steps = (stride, facts.columns * item, item)
                return np.ndarray((count, facts.rows, facts.columns), np.dtype(kind), content.data, 0, steps)

            yield read

    return Frames(path, facts, reading)


def column(path: Path, *, begin: int, stride: int, n: int, kind: str) -> np.ndarray:
    """One number beside each frame, shape (n,): the first at byte ``begin``, the next ones at every ``stride`` bytes."""
    require_bytes(path, needed=begin + (n - 1) * stride + np.dtype(kind).itemsize)
    content = np.memmap(path, np.uint8, mode="r")
    values = np.ndarray((n,), np.dtype(kind), content.data, begin, (stride,))
    return values.astype(np.dtype(kind).newbyteorder("="))
