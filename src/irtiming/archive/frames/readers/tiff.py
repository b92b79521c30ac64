"""TIFF and BigTIFF stacks, by tifffile: frames in pages, or all behind one page."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from irtiming.archive.frames.bounds import MOST_TEXT_BYTES, native, require_size
from irtiming.archive.frames.facts_model import Told, as_told, told_in
from irtiming.archive.frames.readers.tiff_pages import require_sound_pages
from irtiming.archive.frames.source import FrameFacts, FrameReader, Frames, FrameSource, FrameValues, Read
from irtiming.archive.frames.strided import strided
from irtiming.records.camera_frame import CameraIdentity

_SIGNATURES = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_OURS = '{"irtiming": '
_MAKE, _MODEL, _SOFTWARE, _DATE_TIME, _CAMERA_SERIAL = 271, 272, 305, 306, 50735
_PLANES = 2
_EXIF_EXPOSURE_TIME, _EXIF_SERIAL = "ExposureTime", "BodySerialNumber"


def _open(path: Path) -> FrameSource:
    from tifffile import TiffFile

    require_sound_pages(path)
    with TiffFile(path) as tiff:
        first = tiff.pages[0]
        _require_grey(first, is_stack=tiff.is_shaped and _contiguous(tiff) is not None)
        frames, rows, columns = _shape(tiff)
        kind = native(np.dtype(first.dtype))
        require_size(path, frames=frames, rows=rows, columns=columns, dtype=kind)
        form = f"a {'BigTIFF' if tiff.is_bigtiff else 'TIFF'} stack"
        facts = _facts(path, first, format=form, frames=frames, rows=rows, columns=columns, dtype=kind)
        if (begin := _contiguous(tiff)) is not None:
            stored = f"{tiff.byteorder}{np.dtype(kind).str[1:]}"
            return strided(path, facts, begin=begin, stride=facts.frame_bytes, kind=stored)

    @contextmanager
    def reading() -> Iterator[Read]:
        with TiffFile(path) as tiff:

            def read(first: int, count: int) -> FrameValues:
                block = np.empty((count, rows, columns), kind)
                for place in range(count):
                    page = tiff.pages[first + place].aspage()
                    if (page.imagelength, page.imagewidth, page.samplesperpixel) != (rows, columns, 1):
                        raise ValueError(f"page {first + place} is of another size")
                    block[place] = page.asarray().reshape(rows, columns)
                return block

            yield read

    return Frames(path, facts, reading)


def described(facts: FrameFacts) -> str:
    """Facts as they stand in the description of the first page of a file that irtiming wrote."""
    return f"{_OURS}{json.dumps(as_told(facts))}}}"


def _shape(tiff: Any) -> Any:
    """Frames, rows and columns; frames that lie behind one page count as pages do."""
    size = tiff.pages[0].imagelength, tiff.pages[0].imagewidth
    if _contiguous(tiff) is not None:
        return int(np.prod(tiff.series[0].shape[:-2], dtype=object)), *size
    return len(tiff.pages), *size


def _contiguous(tiff: Any) -> int | None:
    """First byte of frames that all follow each other, none packed; None where they do not."""
    first, series = tiff.pages[0], tiff.series[0]
    is_whole = len(series.pages) == len(tiff.pages) and tuple(series.shape[-2:]) == (
        first.imagelength,
        first.imagewidth,
    )
    return series.dataoffset if is_whole else None


def _require_grey(page: Any, *, is_stack: bool) -> None:
    """One value for each pixel; tifffile writes three or four frames as planes, and says their shape."""
    if page.samplesperpixel != 1 and not (is_stack and page.planarconfig == _PLANES):
        raise ValueError(f"it has {page.samplesperpixel} values for each pixel; export it in grey, with one")
    if page.dtype is None:
        raise ValueError(f"pixels of {page.bitspersample} bits are not known")
    if page.imagedepth != 1:
        raise ValueError("its pages are volumes")


def _facts(path: Path, page: Any, **stack: Any) -> FrameFacts:
    description = page.description
    if description.startswith(_OURS) and len(description) <= MOST_TEXT_BYTES:
        text = description[len(_OURS) : description.rindex("}")]
        told: Told = told_in(text, Told, path=path)
        return told.facts(**stack)
    identity = CameraIdentity(
        vendor=_text(page, _MAKE), model=_text(page, _MODEL), serial_number=_text(page, _CAMERA_SERIAL), firmware="", address=""
    )  # fmt: skip
    exif = page.tags.valueof("ExifTag", {})
    exif = exif if isinstance(exif, dict) else {}
    is_known = any((identity.vendor, identity.model, identity.serial_number))
    software = _text(page, _SOFTWARE)
    return FrameFacts(
        camera=identity if is_known else None,
        start_time=_iso(_text(page, _DATE_TIME)),
        integration_time_s=_exposure(exif.get(_EXIF_EXPOSURE_TIME)),
        more={"software": software} if software else {},
        **stack,
    )


def _text(page: Any, code: int) -> str:
    value = page.tags.valueof(code)
    return value.strip("\0 ")[:200] if isinstance(value, str) else ""


def _iso(text: str) -> str:
    """ISO 8601 from "2026:11:23 12:00:00"; other text as it is."""
    date, space, time = text.partition(" ")
    return f"{date.replace(':', '-')}T{time}" if space and date.count(":") == 2 else text


def _exposure(value: Any) -> float | None:
    if isinstance(value, tuple) and len(value) == 2 and value[0] > 0 and value[1] > 0:
        return float(value[0] / value[1])
    return None


READER = FrameReader(title="TIFF", takes=lambda _, begin: begin.startswith(_SIGNATURES), open=_open)
