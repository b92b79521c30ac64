"""FITS, by astropy: the first stack of images."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from irtiming.archive.frames.bounds import native, require_bytes, require_size
from irtiming.archive.frames.source import FrameFacts, FrameReader, Frames, FrameSource, FrameValues, Read
from irtiming.records.camera_frame import CameraIdentity

_MOST_HDUS = 100
_BYTES = {8: 1, 16: 2, 32: 4, 64: 8, -32: 4, -64: 8}


def _open(path: Path) -> FrameSource:
    from astropy.io import fits

    with fits.open(path, memmap=False, lazy_load_hdus=True) as file:
        place = _place(file)
        hdu = file[place]
        frames, rows, columns = ((1,) * 3 + tuple(hdu.shape))[-3:]
        require_size(path, frames=frames, rows=rows, columns=columns, dtype="uint16")
        begin = 0 if hdu.fileinfo() is None else hdu.fileinfo()["datLoc"]
        if not hasattr(hdu, "compressed_data"):
            require_bytes(path, needed=begin + frames * rows * columns * _BYTES[hdu.header["BITPIX"]])
        kind = native(np.dtype(_section(hdu, 0, 1).dtype))
        require_size(path, frames=frames, rows=rows, columns=columns, dtype=kind)
        told = _told(hdu.header)
    facts = FrameFacts(format="a FITS file", frames=frames, rows=rows, columns=columns, dtype=kind, **told)

    @contextmanager
    def reading() -> Iterator[Read]:
        with fits.open(path, memmap=False, lazy_load_hdus=True) as file:

            def read(first: int, count: int) -> FrameValues:
                return np.asarray(_section(file[place], first, count)).reshape(count, rows, columns)

            yield read

    return Frames(path, facts, reading)


def _place(file: Any) -> int:
    """Number of the first part with images."""
    for place in range(_MOST_HDUS):
        try:
            hdu = file[place]
        except IndexError:
            break
        if getattr(hdu, "is_image", False) and len(hdu.shape) in (2, 3):
            return place
    raise ValueError("it holds no stack of images (frame, row, column)")


def _section(hdu: Any, first: int, count: int) -> Any:
    return hdu.section[:, :] if len(hdu.shape) == 2 else hdu.section[first : first + count, :, :]


def _told(header: Any) -> dict[str, Any]:
    model, serial = _text(header, "INSTRUME", "CAMERA", "DETECTOR"), _text(header, "SERIAL", "SERNO", "CAMSER")
    unit = _text(header, "BUNIT").upper()
    identity = CameraIdentity(
        vendor=_text(header, "VENDOR", "ORIGIN"), model=model, serial_number=serial, firmware="", address=""
    )
    return {
        "camera": identity if model or serial else None,
        "start_time": _text(header, "DATE-OBS"),
        "integration_time_s": _number(header, "EXPTIME", "EXPOSURE", "XPOSURE"),
        "frame_period_s": _number(header, "FRAMEPER", "CYCLETIM"),
        "unit": "K" if unit in ("K", "KELVIN") else "DN" if unit in ("", "ADU", "DN", "COUNT", "COUNTS") else "",
    }


def _text(header: Any, *names: str) -> str:
    found = next((header[name] for name in names if isinstance(header.get(name), str)), "")
    return str(found).strip()[:200]


def _number(header: Any, *names: str) -> float | None:
    found = next((header[name] for name in names if isinstance(header.get(name), int | float)), 0)
    return float(found) if 0 < found < 1e6 else None


READER = FrameReader(title="FITS", takes=lambda _, begin: begin.startswith(b"SIMPLE  ="), open=_open)
