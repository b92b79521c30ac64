"""The result of an analysis: written only if it is what its model says, and read back by whoever goes on with it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from irtiming.archive.json_file import plain, write_json
from irtiming.archive.result_model import FORMAT, VERSION, Result
from irtiming.archive.result_sense import require_names
from irtiming.archive.typed_file import fitted, read_json
from irtiming.archive.typed_misfit import FileKind
from irtiming.errors import ArchiveError

_KIND = FileKind(name="result", format=FORMAT, version=VERSION, cure="write it anew with irtiming analyse --json")


def write_result(result: Mapping[str, Any], path: str | Path) -> None:
    """Write a result as JSON with its format and version; an existing file is replaced only when the new one is complete.

    Raises
    ------
    ArchiveError
        If the file cannot be written, or the result has a key that `Result` does not know, lacks one, or has another value.
    """
    content = _content(result)
    fitted(content, Result, path=Path(path), kind=_KIND)
    write_json(content, path)


def checked_result(result: Mapping[str, Any]) -> Result:
    """The same in memory, as `read_result` would give it back.

    Raises
    ------
    ArchiveError
        As `write_result` does for what is no result.
    """
    return fitted(_content(result), Result, path=Path("result"), kind=_KIND)


def _content(result: Mapping[str, Any]) -> dict[str, Any]:
    return {"format": FORMAT, "version": VERSION, **plain(result)}


def read_result(path: str | Path) -> Result:
    """The result in a file that `write_result` wrote, also one of a later minor version, whose further keys are left out.

    Raises
    ------
    ArchiveError
        If the file cannot be read, is no result, is of a later major version, is not what the model says, or lacks a parameter
        that every result of its camera has.
    """
    found = read_json(Path(path), Result, kind=_KIND)
    try:
        require_names(
            {**found.parameters, **found.bounds},
            camera=found.camera, readout_mode=found.readout_mode, frame_event=found.frame_event,
        )  # fmt: skip
    except ValueError as error:
        raise ArchiveError(f"{path}: {error}; {_KIND.cure}") from error
    return found
