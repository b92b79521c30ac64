"""Bare values of pixels, with a JSON file of the same name that says what they are."""

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from irtiming.archive.frames.facts_model import Told, told_beside
from irtiming.archive.frames.source import FrameReader, FrameSource
from irtiming.archive.frames.strided import strided
from irtiming.errors import ArchiveError

_SUFFIXES = (".raw", ".bin", ".dat", ".img")
_Size = Annotated[int, Field(ge=1, le=2**24)]


class _RawStack(Told):
    """Sizes, in pixels and bytes, and what else is known."""

    rows: _Size
    columns: _Size
    frames: _Size | None = None
    dtype: Literal["uint8", "uint16", "int16", "uint32", "int32", "float32", "float64"] = "uint16"
    byte_order: Literal["little", "big"] = "little"
    header_bytes: Annotated[int, Field(ge=0, le=2**40)] = 0
    between_frames_bytes: Annotated[int, Field(ge=0, le=2**32)] = 0


def _both(path: Path) -> tuple[Path, Path]:
    """Names of the file that describes a raw one: run.json, or run.raw.json."""
    return path.with_suffix(".json"), path.with_name(f"{path.name}.json")


def _beside(path: Path) -> Path | None:
    return next((one for one in _both(path) if one.is_file()), None)


def _open(path: Path) -> FrameSource:
    beside = _beside(path)
    if beside is None:
        raise FileNotFoundError
    stack: _RawStack = told_beside(beside, _RawStack)
    frame_bytes = stack.rows * stack.columns * np.dtype(stack.dtype).itemsize
    stride = frame_bytes + stack.between_frames_bytes
    there, rest = divmod(path.stat().st_size - stack.header_bytes + stack.between_frames_bytes, stride)
    if rest and rest != stack.between_frames_bytes:
        raise ArchiveError(
            f"has {rest} bytes more than {there} frames of {frame_bytes} bytes: it is cut short, or {beside.name} says a wrong "
            "size; correct that, or copy it again",
            where=str(path),
        )
    facts = stack.facts(
        format="a raw file with JSON beside it", frames=stack.frames or there, rows=stack.rows, columns=stack.columns,
        dtype=stack.dtype,
    )  # fmt: skip
    order = "<" if stack.byte_order == "little" else ">"
    return strided(path, facts, begin=stack.header_bytes, stride=stride, kind=f"{order}{np.dtype(stack.dtype).str[1:]}")


READER = FrameReader(
    title="raw values with a JSON file",
    takes=lambda path, _: path.suffix.lower() in _SUFFIXES and _beside(path) is not None,
    open=_open,
    beside=_both,
)
