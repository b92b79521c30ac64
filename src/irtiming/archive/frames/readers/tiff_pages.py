"""A first look at the pages of a TIFF: a library would follow them wherever the file says, and for ever in a circle."""

import struct
from pathlib import Path

from irtiming.archive.frames.bounds import MOST_FRAMES

_MOST_TAGS = 4096


def require_sound_pages(path: Path) -> None:
    """Refuse a file whose pages are not all in it, or turn in a circle.

    Parameters
    ----------
    path
        A TIFF or BigTIFF.

    Raises
    ------
    ValueError, EOFError
        Saying which page is wrong.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(16).ljust(16, b"\0")
        order = "<" if head.startswith(b"II") else ">"
        is_big = struct.unpack_from(f"{order}H", head, 2)[0] == 43
        count, link, tag_bytes = (f"{order}Q", f"{order}Q", 20) if is_big else (f"{order}H", f"{order}I", 12)
        place = struct.unpack_from(link, head, 8 if is_big else 4)[0]
        seen: set[int] = set()
        while place:
            number = len(seen)
            if place in seen:
                raise ValueError(f"its pages turn in a circle behind page {number - 1}")
            if number > MOST_FRAMES:
                raise ValueError(f"it has more than {MOST_FRAMES} pages")
            seen.add(place)
            file.seek(place)
            n_tags = struct.unpack(count, _all_of(file.read(struct.calcsize(count)), struct.calcsize(count), number))[0]
            end = place + struct.calcsize(count) + n_tags * tag_bytes
            if n_tags > _MOST_TAGS or end + struct.calcsize(link) > size:
                raise EOFError(
                    f"page {number} has {n_tags} entries from byte {place}, the file {size} bytes: it is cut short"
                )
            file.seek(end)
            place = struct.unpack(link, _all_of(file.read(struct.calcsize(link)), struct.calcsize(link), number))[0]


def _all_of(content: bytes, n_bytes: int, number: int) -> bytes:
    if len(content) < n_bytes:
        raise EOFError(f"page {number} is not all there: the file is cut short")
    return content
