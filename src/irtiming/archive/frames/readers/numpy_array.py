"""Arrays of NumPy: ``.npy``, with what is known of its frames in ``.npy.json`` beside it, and ``.npz`` with ``frames``."""

import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np

from irtiming.archive.frames.bounds import native, require_bytes, require_size
from irtiming.archive.frames.facts_model import Told, told_beside
from irtiming.archive.frames.source import FrameReader, Frames, FrameSource, FrameValues, Read
from irtiming.archive.frames.strided import strided

SIDECAR = ".json"
"""What the name of the file with the facts ends in, after that of the array."""

_NPY, _ZIP = b"\x93NUMPY", b"PK"
_MEMBER = "frames.npy"


def _open(path: Path) -> FrameSource:
    with path.open("rb") as file:
        if file.read(len(_NPY)) != _NPY:
            return _open_zipped(path)
        file.seek(0)
        stack, kind = _header(file)
        begin = file.tell()
    require_size(path, **stack)
    beside = path.with_name(path.name + SIDECAR)
    told: Told = told_beside(beside, Told) if beside.is_file() else Told()
    facts = told.facts(format="a NumPy array", **stack)
    return strided(path, facts, begin=begin, stride=facts.frame_bytes, kind=kind.str)


def _open_zipped(path: Path) -> FrameSource:
    with zipfile.ZipFile(path) as archive:
        if _MEMBER not in archive.namelist():
            raise ValueError("it holds no array 'frames'; save it with numpy.savez(file, frames=...)")
        member = archive.getinfo(_MEMBER)
        with archive.open(member) as file:
            stack, kind = _header(file)
            begin = file.tell()
    require_size(path, **stack)
    facts = Told().facts(format="NumPy arrays (.npz)", **stack)
    if begin + facts.frames * facts.frame_bytes != member.file_size:
        raise ValueError(f"'frames' says that it is {kind} {facts.shape}, but has {member.file_size - begin} bytes")
    require_bytes(path, needed=member.compress_size)

    @contextmanager
    def reading() -> Iterator[Read]:
        with zipfile.ZipFile(path) as archive, archive.open(_MEMBER) as file:

            def read(first: int, count: int) -> FrameValues:
                file.seek(begin + first * facts.frame_bytes)  # forwards costs what it passes, backwards begins anew
                content = file.read(count * facts.frame_bytes)
                return np.frombuffer(content, kind).reshape(count, facts.rows, facts.columns)

            yield read

    return Frames(path, facts, reading)


def _header(file: IO[bytes]) -> tuple[dict[str, Any], np.dtype]:
    """Sizes and type that an array says it has."""
    version = np.lib.format.read_magic(file)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, is_fortran, kind = read(file)
    if len(shape) != 3 or is_fortran or kind.kind not in "uif":
        order = " in Fortran's order" if is_fortran else ""
        raise ValueError(f"it is {kind} {shape}{order}; it must be numbers (frame, row, column) in C order")
    frames, rows, columns = shape
    return {"frames": frames, "rows": rows, "columns": columns, "dtype": native(kind)}, kind


READER = FrameReader(
    title="NumPy",
    takes=lambda path, begin: begin.startswith(_NPY) or (begin.startswith(_ZIP) and path.suffix.lower() == ".npz"),
    open=_open,
    beside=lambda path: () if path.suffix.lower() == ".npz" else (path.with_name(path.name + SIDECAR),),
)
