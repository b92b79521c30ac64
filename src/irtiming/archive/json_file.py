"""JSON and text, written whole or not at all, and places where they may be written."""

import json
import math
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from irtiming.archive.suffixes import NEVER_REPLACED, NO_TEXT, Kind, require_suffix
from irtiming.archive.whole_file import place_of, stays_as_it_is, text_output, unwritable
from irtiming.errors import ArchiveError


def write_json(content: Mapping[str, Any], path: str | Path) -> None:
    """Write strict JSON; an existing file is replaced only when the new one is complete.

    Numpy numbers and arrays, tuples and paths become plain numbers, lists and text. A number that JSON does
    not have (not-a-number, infinity) becomes null.

    Raises
    ------
    ArchiveError
        If the file cannot be written, its name says another format, or the content holds something that JSON cannot express.
    """
    require_suffix(Path(path), "JSON")
    write_atomically(json_text(content), path)


def json_text(content: Mapping[str, Any]) -> str:
    """What `write_json` writes.

    Raises
    ------
    ArchiveError
        If the content holds something that JSON cannot express.
    """
    return json.dumps(plain(content), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


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
    with text_output(path) as file:
        file.write(content.encode() if isinstance(content, str) else content)


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


def require_place(
    path: str | Path, *kinds: Kind, besides: Iterable[str | Path] = (), is_text: bool = True, is_new: bool = False
) -> None:
    """Refuse a place where no result may be written, before the long work whose result should go there.

    Parameters
    ----------
    path
        Where the result should go.
    kinds
        What may be written there, by its suffix; none where the caller asks that itself.
    besides
        Files that are read or written too: none of them may be overwritten.
    is_text
        The result is text, which the standard output, a pipe or a device takes too.
    is_new
        No file is replaced: recordings and frames, and what is made of them to be worked on, may be the only copy.

    Raises
    ------
    ArchiveError
        If the path is a folder or one of the other files, has the suffix of another format, its folder does not exist or may
        not be written to, it is no file where it must be one, or there where it must be new.
    """
    target = Path(path)
    if target.resolve() in {Path(other).resolve() for other in besides}:
        raise ArchiveError(
            f"{target}: is another file of this command and would be overwritten; name a new file to write"
        )
    if kinds:
        require_suffix(target, *kinds)
    if is_text and stays_as_it_is(target):
        return
    place = place_of(target)
    if is_new and place.exists():
        raise ArchiveError(f"{target}: exists already; choose another name")
    if not place.parent.is_dir() or not os.access(place.parent, os.W_OK):
        raise unwritable(place, PermissionError("no permission"))


def require_places(
    places: Mapping[Kind, Iterable[str | Path | None]],
    *,
    files: Iterable[str | Path | None] = (),
    inputs: Iterable[str | Path | None] = (),
) -> None:
    """`require_place` for all that a command writes, None for what it does not: each to a file of its own.

    Parameters
    ----------
    places
        Where each kind of file should go.
    files
        Where other files should go, which are no text.
    inputs
        All files that are read, or written to in another way: none of them may be overwritten.

    Raises
    ------
    ArchiveError
        As `require_place`.
    """
    taken = [one for one in inputs if one is not None]
    for kind, paths in places.items():
        for path in paths:
            if path is not None:
                require_place(path, kind, besides=taken, is_text=kind not in NO_TEXT, is_new=kind in NEVER_REPLACED)
                taken.append(path)
    for path in files:
        if path is not None:
            require_place(path, besides=taken, is_text=False)
            taken.append(path)
