"""TOML files that people write: read as a table, with unknown sections and keys refused by their nearest name."""

import hashlib
import tomllib
from collections.abc import Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from irtiming.errors import ArchiveError

_LONGEST = 60


def read_table(path: Path, known: Mapping[str, tuple[str, ...]], *, what: str) -> tuple[dict[str, Any], str]:
    """Sections of a file, and the SHA-256 checksum of its bytes.

    Parameters
    ----------
    path
        The file.
    known
        Keys of each section that there may be.
    what
        Kind of file, for messages, such as ``"rig.toml"``.

    Raises
    ------
    ArchiveError
        If it cannot be read, is no TOML, or has an unknown section or key.
    """
    content = _bytes_of(path, what)
    try:
        table = tomllib.loads(content.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise ArchiveError(f"{path}: is not UTF-8 text (byte {error.start}); save it as UTF-8") from error
    except tomllib.TOMLDecodeError as error:
        raise ArchiveError(f"{path}: is not valid TOML: {error}; correct that place") from error
    _refuse_unknown(table, path, known, what=what)
    return table, hashlib.sha256(content).hexdigest()


def shown(value: Any) -> str:
    """A value as it stands in a message: one line, not too long.

    Parameters
    ----------
    value
        Any.
    """
    text = " ".join(repr(value).split())
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


def _bytes_of(path: Path, what: str) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError as error:
        raise ArchiveError(f"{path}: does not exist; name the {what}") from error
    except IsADirectoryError as error:
        raise ArchiveError(f"{path}: is a folder; name the {what} in it") from error
    except OSError as error:
        raise ArchiveError(f"{path}: cannot be read ({error.strerror}); check its permissions") from error


def _refuse_unknown(table: dict[str, Any], path: Path, known: Mapping[str, tuple[str, ...]], *, what: str) -> None:
    for name, section in table.items():
        if name not in known:
            raise ArchiveError(
                f"{path}: [{name}] is not a section of {what}; {_nearest(name, tuple(known), 'section')}"
            )
        if not isinstance(section, dict):
            raise ArchiveError(f"{path}: {name} is {shown(section)}; it must be a section [{name}]")
        for key in section:
            if key not in known[name]:
                raise ArchiveError(
                    f"{path}: [{name}] {key} is not a key of this section; {_nearest(key, known[name], 'key')}"
                )


def _nearest(word: str, known: tuple[str, ...], sort: str) -> str:
    near = get_close_matches(word.lower(), known, n=1)
    return f"did you mean '{near[0]}'?" if near else f"the {sort}s are {', '.join(known)}"
