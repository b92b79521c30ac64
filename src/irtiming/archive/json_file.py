"""JSON and text, written whole or not at all, and places where they may be written."""

import json
import math
import os
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from irtiming.archive.whole_file import unwritable, whole_file
from irtiming.errors import ArchiveError

STANDARD_OUTPUT = Path("-")
"""What a person writes for the standard output in place of a file."""


def write_json(content: Mapping[str, Any], path: str | Path) -> None:
    """Write strict JSON; an existing file is replaced only when the new one is complete.

    Numpy numbers and arrays, tuples and paths become plain numbers, lists and text. A number that JSON does
    not have (not-a-number, infinity) becomes null.

    Raises
    ------
    ArchiveError
        If the file cannot be written, or the content holds something that JSON cannot express.
    """
    text = json.dumps(plain(content), indent=1, ensure_ascii=False, allow_nan=False)
    write_atomically(text + "\n", path)


def plain(value: Any) -> Any:
    """The same value of types that JSON has: dict, list, str, int, float, bool, None.

    Raises
    ------
    ArchiveError
        If it holds an object of another type.
    """
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, Path):
        return str(value)
    raise ArchiveError(f"a result holds {type(value).__name__} {value!r:.60}; JSON has numbers, text and lists only")


def write_atomically(content: str | bytes, path: str | Path) -> None:
    """Write text as UTF-8, or bytes, under a temporary name and rename it when it is complete.

    What is no file of its own, such as a pipe, is written to as it stands; ``-`` is the standard output.

    Raises
    ------
    ArchiveError
        If the folder does not exist, or the file cannot be written.
    """
    target, stored = Path(path), content.encode() if isinstance(content, str) else content
    if target == STANDARD_OUTPUT:
        _print(stored)
    elif target.is_dir():
        raise ArchiveError(f"{target}: is a folder; name a file to write")
    elif target.exists() and not target.is_file():
        _write_into(stored, target)
    else:
        with whole_file(target) as part:
            part.write_bytes(stored)


def _print(content: bytes) -> None:
    """To what was the standard output when the program began, wherever its other words go."""
    stream = sys.__stdout__
    if stream is None:
        raise ArchiveError("there is no standard output to write to; name a file")
    stream.flush()
    stream.buffer.write(content)
    stream.buffer.flush()


def _write_into(content: bytes, target: Path) -> None:
    try:
        with target.open("wb") as file:
            file.write(content)
    except OSError as error:
        raise unwritable(target, error) from error


def make_folder(path: str | Path) -> None:
    """Make a folder and those above it, where they are not there.

    Raises
    ------
    ArchiveError
        If it cannot be made.
    """
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ArchiveError(f"{path} cannot be made ({error.strerror}); give another folder") from error


def require_place(path: str | Path, *, besides: Iterable[str | Path] = ()) -> None:
    """Refuse a place where no result may be written, before the long work whose result should go there.

    Parameters
    ----------
    path
        Where the result should go.
    besides
        Files that are read or written too: none of them may be overwritten.

    Raises
    ------
    ArchiveError
        If the path is a folder or one of the other files, or its folder does not exist or may not be written to.
    """
    target = Path(path)
    if target == STANDARD_OUTPUT:
        return
    if target.is_dir():
        raise ArchiveError(f"{target}: is a folder; name a file to write")
    if target.resolve() in {Path(other).resolve() for other in besides}:
        raise ArchiveError(
            f"{target}: is another file of this command and would be overwritten; name a new file to write"
        )
    if not target.parent.is_dir() or not os.access(target.parent, os.W_OK):
        raise unwritable(target, PermissionError("no permission"))
