"""Files of the folder as a browser gets them: pictures of frames, reports to look at, and files to keep."""

from collections import OrderedDict
from pathlib import Path
from typing import Any
from urllib.parse import quote

from fastapi import Response
from fastapi.responses import FileResponse
from nicegui import app as pages_app

from irtiming.errors import ArchiveError
from irtiming.records.frame_view import ViewOrder
from irtiming.web.desk import Desk

FRAMES = (
    ".nxs", ".h5", ".hdf5", ".tif", ".tiff", ".npy", ".npz", ".raw", ".bin", ".dat", ".img", ".fff", ".seq", ".csq", ".sfmov",
    ".ptw", ".irb", ".hcc", ".fits", ".fit", ".mkv", ".avi", ".hdr", ".bag", ".png", ".pgm",
)  # fmt: skip
"""Endings of files that may hold frames; what they are is recognised by their content."""

_SHOWN = {".html": "text/html; charset=utf-8", ".pdf": "application/pdf", ".svg": "image/svg+xml"}
_KEPT = (*FRAMES, ".json", ".toml", ".xml", ".csv", ".zip", ".yaml", ".parquet")
_NOTHING_RUNS = (
    "sandbox allow-same-origin; default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:; "
    "frame-ancestors 'self'"
)
_PDF_ONLY = "default-src 'none'; object-src 'self'; frame-ancestors 'self'"
_NO_PICTURE = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 96 72"><text x="48" y="40" font-size="11" font-family="sans-serif" '
    'text-anchor="middle" fill="#a3afbb">no frames</text></svg>'
)
_MOST_PICTURES, _THUMB_PX = 400, 96


def add(desk: Desk) -> None:
    """Serve them."""
    kept: OrderedDict[Any, bytes] = OrderedDict()

    @pages_app.get("/file")
    def file(name: str = "") -> Response:
        try:
            path = desk.folder.existing(name)
        except ArchiveError as error:
            return _refused(error)
        suffix = path.suffix.lower()
        if not path.is_file() or suffix not in (*_SHOWN, *_KEPT):
            return _refused(f"{path.name}: is no file that is served")
        if suffix not in _SHOWN:
            return FileResponse(path, media_type="application/octet-stream", filename=path.name)
        policy = _PDF_ONLY if suffix == ".pdf" else _NOTHING_RUNS
        headers = {"content-security-policy": policy, "cache-control": "no-cache"}
        return FileResponse(path, media_type=_SHOWN[suffix], headers=headers)

    @pages_app.get("/picture")
    async def picture(name: str = "", index: int = -1, width: int = 640) -> Response:
        try:
            path = desk.folder.existing(name)
        except ArchiveError as error:
            return _refused(error)
        width = _THUMB_PX if width == _THUMB_PX else 640
        key = (path, path.stat().st_mtime_ns, index, width)
        if key not in kept:
            found = await desk.ask("files:picture", ViewOrder(path=path, index=max(-1, index), widest_px=width))
            if not found.is_good:
                return Response(_NO_PICTURE, media_type="image/svg+xml") if width == _THUMB_PX else _refused(found.text)
            kept[key] = found.answer["content"]
            while len(kept) > _MOST_PICTURES:
                kept.popitem(last=False)
        return Response(kept[key], media_type="image/jpeg", headers={"cache-control": "private, max-age=60"})


def link(desk: Desk, path: Path) -> str:
    """Address of a file of the folder."""
    return f"/file?name={quote(desk.folder.name_of(path))}"


def picture_link(name: str, *, index: int = -1, is_thumb: bool = False) -> str:
    """Address of a picture of one of its frames; -1 is the one in the middle."""
    return f"/picture?name={quote(name)}&index={index}&width={_THUMB_PX if is_thumb else 640}"


def _refused(why: Exception | str) -> Response:
    return Response(f"irtiming: {why}\n", status_code=404, media_type="text/plain; charset=utf-8")
