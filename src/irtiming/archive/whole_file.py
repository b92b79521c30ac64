"""Files that are written whole or not at all: under another name until everything is in them."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from irtiming.archive.layout import PART
from irtiming.errors import ArchiveError


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """Give the name to write under; when the ``with`` block ends well, that file takes the place of ``path``.

    If the block raises, nothing is left behind, and an earlier file of that name stays as it was. The name is this process' own
    (`final_name` tells the other): it is neither that of another writer nor that of an interrupted recording.

    Raises
    ------
    ArchiveError
        If the file cannot be written.
    """
    target = Path(path)
    part = target.with_name(f"{target.name}{_ending()}")
    try:
        yield part
        part.replace(target)
    except OSError as error:
        raise unwritable(target, error) from error
    finally:
        part.unlink(missing_ok=True)


def final_name(part: Path) -> Path:
    """What a file that `whole_file` gave the name of will be called."""
    return part.with_name(part.name.removesuffix(_ending()))


def _ending() -> str:
    return f".{os.getpid()}{PART}"


def unwritable(path: Path, error: OSError) -> ArchiveError:
    """Error for a file that could not be written, with the reason and the cure."""
    if not path.parent.is_dir():
        return ArchiveError(f"{path}: cannot be written: there is no folder {path.parent}; make it first")
    return ArchiveError(f"{path}: cannot be written ({error.strerror or error}); choose another place")
