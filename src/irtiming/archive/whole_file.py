"""Files that are written whole or not at all, under another name until everything is in them; and what is no file to replace."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TextIO

from irtiming.archive.layout import PART
from irtiming.errors import ArchiveError

STANDARD_OUTPUT = Path("-")
"""What a person writes for the standard output in place of a file."""


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """Give the name to write under; when the ``with`` block ends well, that file takes the place of ``path``.

    If the block raises, nothing is left behind, and an earlier file of that name stays as it was. The name is this process' own
    (`final_name` tells the other): it is neither that of another writer nor that of an interrupted recording.

    Raises
    ------
    ArchiveError
        If the file cannot be written, or ``path`` is no file that may be replaced (`place_of`).
    """
    place = place_of(path)
    part = part_of(place)
    try:
        yield part
        part.replace(place)
    except OSError as error:
        raise unwritable(place, error) from error
    finally:
        part.unlink(missing_ok=True)


@contextmanager
def text_output(path: str | Path) -> Iterator[IO[bytes]]:
    """Open a place for text: ``-`` is the standard output, and a file is whole or not there.

    What is no file of its own, such as a pipe, is written to as it stands; so is the file to which the standard output goes.

    Raises
    ------
    ArchiveError
        If it cannot be written.
    """
    target = Path(path)
    if (stream := _standard_stream(target)) is not None:
        stream.flush()
        yield stream.buffer
        stream.buffer.flush()
    elif _is_no_file(target):
        try:
            with target.open("wb") as file:
                yield file
        except OSError as error:
            raise unwritable(target, error) from error
    else:
        with whole_file(target) as part, part.open("wb") as file:
            yield file


def place_of(path: str | Path) -> Path:
    """The file, there or not yet, that a name stands for: links are followed, so that they stay.

    Raises
    ------
    ArchiveError
        If no whole file can take that place: the standard output, a folder, a device, a pipe.
    """
    target = Path(path)
    if target == STANDARD_OUTPUT:
        raise ArchiveError(f"{target}: is the standard output, which takes text alone; name a file to write")
    if target.is_dir():
        raise ArchiveError(f"{target}: is a folder; name a file to write")
    if _is_no_file(target):
        raise ArchiveError(f"{target}: is no file but a device or a pipe, which stays as it is; name a file to write")
    if _standard_stream(target) is not None:
        raise ArchiveError(f"{target}: is where the words of this command go; name another file to write")
    return Path(os.path.realpath(target)) if target.is_symlink() else target


def stays_as_it_is(path: Path) -> bool:
    """Whether `text_output` writes into what is there, in place of making a file anew."""
    return _is_no_file(path) or _standard_stream(path) is not None


def _is_no_file(path: Path) -> bool:
    """Whether something is there that is neither a file nor a folder, or leads to such: a device, a pipe."""
    return path.exists() and not path.is_file() and not path.is_dir()


def part_of(place: Path) -> Path:
    """The name under which this process writes what will take a place."""
    return place.with_name(f"{place.name}{_ending()}")


def final_name(part: Path) -> Path:
    """What a file that `whole_file` gave the name of will be called."""
    return part.with_name(part.name.removesuffix(_ending()))


def _ending() -> str:
    return f".{os.getpid()}{PART}"


def _standard_stream(path: Path) -> TextIO | None:
    """The program's standard output or error, where a path is ``-`` or leads there; what others redirected meanwhile is apart."""
    if path == STANDARD_OUTPUT:
        if sys.__stdout__ is None:
            raise ArchiveError("there is no standard output to write to; name a file")
        return sys.__stdout__
    for stream in (sys.__stdout__, sys.__stderr__):
        try:
            if stream is not None and os.path.samestat(path.stat(), os.fstat(stream.fileno())):
                return stream
        except (OSError, ValueError):
            continue
    return None


def unwritable(path: Path, error: OSError) -> ArchiveError:
    """Error for a file that could not be written, with the reason and the cure."""
    if not path.parent.is_dir():
        return ArchiveError(f"{path}: cannot be written: there is no folder {path.parent}; make it first")
    return ArchiveError(f"{path}: cannot be written ({error.strerror or error}); choose another place")
