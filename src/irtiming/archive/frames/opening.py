"""Open a file of frames, whatever program wrote it: its format is recognised by what is in it."""

import logging
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from irtiming.archive.frames.bounds import refusing
from irtiming.archive.frames.source import FrameReader, FrameSource
from irtiming.errors import ArchiveError

GROUP = "irtiming.frames"
_READERS = "irtiming.archive.frames.readers"
_BUILT_IN = (
    "hdf5_stack", "tiff", "numpy_array", "telops_hcc", "flir_fff", "flir_sfmov", "cedip_ptw", "infratec_irb", "norpix_seq",
    "fits", "video", "picture", "envi", "raw", "ros_bag", "folder",
)  # fmt: skip
_SNIFFED_BYTES = 4096


def open_frames(path: str | Path) -> FrameSource:
    """Frames of a file, or of all files in a folder.

    Parameters
    ----------
    path
        A file of any format that is known, see docs/reference/frame-files.md, or a folder with one file for each frame.

    Returns
    -------
    The frames; the file is opened anew for each pass, and only a block of them is in memory.

    Raises
    ------
    ArchiveError
        If it cannot be read: one line that says what it is, what must be and what to do.
    """
    where = Path(path)
    reader = reader_of(where)
    if reader is None:
        raise ArchiveError(f"is no file of frames that is known; export it as one of: {_titles()}", where=str(where))
    with refusing(where, reader.title):
        return reader.open(where)


def reader_of(path: Path) -> FrameReader | None:
    """Reader for a file; None where no format fits.

    Raises
    ------
    ArchiveError
        If there is no such file, it is empty, or may not be read.
    """
    begin = b""
    with refusing(path, "frames"):
        if not path.is_dir():
            if path.exists() and not path.is_file():
                raise ArchiveError("is no file but a device or a pipe; name a file of frames", where=str(path))
            with path.open("rb") as file:
                begin = file.read(_SNIFFED_BYTES)
            if not begin:
                raise ArchiveError("is empty (0 bytes); copy or export it again", where=str(path))
    return next((reader for reader in readers().values() if reader.takes(path, begin)), None)


def files_read(path: Path) -> tuple[Path, ...]:
    """A file and those that are read with it as frames, be they there or not: no output may take the place of one of them."""
    try:
        reader = reader_of(path)
    except ArchiveError:  # whoever reads it says so
        return (path,)
    beside = getattr(reader, "beside", None)  # a plug-in may be older than it
    return (path, *(beside(path) if beside is not None else ()))


def describe(path: Path) -> str:
    """A file in a few words, such as "a TIFF stack of 20 frames of 480 x 640 pixels"; empty where it is no file of frames."""
    try:
        reader = reader_of(path)
        if reader is None:
            return ""
        facts = open_frames(path).facts
    except ArchiveError:
        return ""
    return f"{facts.format} with {facts.frames} frames of {facts.rows} x {facts.columns} pixels"


@cache
def readers() -> dict[str, FrameReader]:
    """All readers by name, built-in ones first: a plug-in cannot take a format from them, so a file means the same everywhere."""
    points = {one: EntryPoint(name=one, value=f"{_READERS}.{one}:READER", group=GROUP) for one in _BUILT_IN}
    points |= {point.name: point for point in sorted(entry_points(group=GROUP)) if point.name not in points}
    found = {}
    for name, point in points.items():
        try:
            found[name] = point.load()
        except (ImportError, AttributeError) as error:
            logging.getLogger(__name__).warning("the reader of frames %s cannot be loaded: %s", name, error)
    return found


def _titles() -> str:
    return ", ".join(reader.title for reader in readers().values())
