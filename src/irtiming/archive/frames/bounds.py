"""What a file of frames may ask of whoever reads it, and how one that asks for more, or is damaged, is refused."""

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from irtiming.archive.finding import Complaint
from irtiming.errors import ArchiveError, IrTimingError

MOST_PIXELS = 2**25
"""Of one frame."""

MOST_FRAMES = 2**24
MOST_TEXT_BYTES = 2**26
"""Of what a file says beside its frames: moments of all frames among it."""

KINDS = ("uint8", "uint16", "int16", "uint32", "int32", "float32", "float64")
"""Types of pixel values that are read."""


@contextmanager
def _silent() -> Iterator[None]:
    """Tifffile logs what is odd in a file: what matters is raised."""
    logger = logging.getLogger("tifffile")
    before, logger.disabled = logger.disabled, True
    try:
        yield
    finally:
        logger.disabled = before


@contextmanager
def refusing(path: Path, title: str) -> Iterator[None]:
    """Turn what a reader or its library throws at a file into one line, and keep libraries from writing to the screen.

    Raises
    ------
    ArchiveError
        In place of everything else.
    """
    try:
        with warnings.catch_warnings(), _silent():
            warnings.simplefilter("ignore")
            yield
    except Complaint as complaint:
        raise complaint.as_error(path) from complaint
    except IrTimingError:
        raise
    except ModuleNotFoundError as error:
        what = f"is a file of {title}, which needs the library {error.name}: pip install 'irtiming[frames]'"
        raise ArchiveError(what, where=str(path)) from error
    except FileNotFoundError as error:
        raise ArchiveError("does not exist; check the name", where=str(path)) from error
    except PermissionError as error:
        raise ArchiveError("may not be read; give yourself read permission (chmod u+r)", where=str(path)) from error
    except Exception as error:  # of many kinds: every library raises its own
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise ArchiveError(f"cannot be read as {title} ({reason}); copy or export it again", where=str(path)) from error


def require_size(path: Path, *, frames: int, rows: int, columns: int, dtype: str) -> None:
    """Refuse a file that says it has no frames, or more or larger ones than can be, before anything is made for them.

    Raises
    ------
    ArchiveError
        Saying which number is wrong.
    """
    said = f"says that it has {frames} frames of {rows} x {columns} pixels of {dtype}"
    if min(frames, rows, columns) < 1:
        raise ArchiveError(f"{said}: there is nothing to read; copy or export it again", where=str(path))
    if frames > MOST_FRAMES or rows * columns > MOST_PIXELS:
        bound = f"there may be {MOST_FRAMES} of {MOST_PIXELS} pixels"
        raise ArchiveError(f"{said}; {bound}: the file is damaged, copy or export it again", where=str(path))
    if dtype not in KINDS:
        raise ArchiveError(f"{said}; pixels must be one of {', '.join(KINDS)}: export it so", where=str(path))


def require_bytes(path: Path, *, needed: int) -> None:
    """Refuse a file that is shorter than what it says it holds.

    Raises
    ------
    ArchiveError
        With both numbers.
    """
    size = path.stat().st_size
    if size < needed:
        raise ArchiveError(
            f"has {size} bytes where what it says it holds needs {needed}: it is cut short, or says a wrong size; "
            "copy or export it again",
            where=str(path),
        )


def native(kind: np.dtype) -> str:
    """Name of a type of pixel values, whatever its byte order in the file."""
    return kind.newbyteorder("=").name
