"""The one folder whose files the pages show, and into which they write; nothing outside it is ever touched."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import final

from irtiming.errors import ArchiveError, one_line

MOST_FILES = 2000
"""Files that are listed at most."""

_DEEPEST = 4
_PLAIN_NAME = re.compile(r"[^\w.+=-]+")


@final
class Folder:
    """A folder that a person chose when the server was started.

    Parameters
    ----------
    root
        It exists.
    """

    def __init__(self, root: Path) -> None:
        self.root = root.resolve()

    def inside(self, name: str) -> Path:
        """The path of a file or folder by its name within the folder, such as ``monday/run1.nxs``.

        Raises
        ------
        ArchiveError
            If the name leads out of the folder, by itself or through a link, or is that of a hidden file.
        """
        parts = name.split("/")
        if (
            not name
            or len(name) > 1000
            or not name.isprintable()
            or "\\" in name
            or any(_is_hidden(one) for one in parts)
        ):
            raise self._outside(name)
        try:
            found = (self.root / name).resolve()
        except (OSError, RuntimeError) as error:
            raise self._outside(name) from error
        if not found.is_relative_to(self.root) or found == self.root:
            raise self._outside(name)
        return found

    def existing(self, name: str) -> Path:
        """The same for a file or folder that is there.

        Raises
        ------
        ArchiveError
            As `inside`, and if there is no such file.
        """
        found = self.inside(name)
        if not found.exists():
            raise ArchiveError(f"{one_line(name):.200}: is not there (any more); choose another")
        return found

    def free(self, name: str, *, within: str = "", beside: tuple[str, ...] = ()) -> Path:
        """A path for a new file of about that name, which no other file has; its folder is made.

        With the suffixes ``beside`` in place of its own it is free too: files that belong together have one stem.

        Raises
        ------
        ArchiveError
            As `inside`.
        """
        place = self.inside(within) if within else self.root
        plain = _PLAIN_NAME.sub("-", name.replace("\\", "/").rsplit("/", 1)[-1]).lstrip(".-")[-150:] or "file"
        place.mkdir(parents=True, exist_ok=True)
        stem, dot, suffix = plain.partition(".")
        tries = (place / plain, *(place / f"{stem}-{number}{dot}{suffix}" for number in range(2, 10_000)))
        return self.inside(self.name_of(next(one for one in tries if not _is_taken(one, beside))))

    def name_of(self, path: Path) -> str:
        """Its name within the folder."""
        return path.relative_to(self.root).as_posix()

    def files(self, *suffixes: str) -> list[Path]:
        """All files with one of these suffixes, the newest first, at most `MOST_FILES`."""
        found = [path for path in self._walk(self.root, _DEEPEST) if path.name.lower().endswith(suffixes)]
        return sorted(found, key=_changed_s, reverse=True)[:MOST_FILES]

    def _walk(self, folder: Path, depth: int) -> Iterator[Path]:
        try:
            entries = sorted(folder.iterdir())
        except OSError:
            return
        for entry in entries:
            if entry.name.startswith(".") or entry.is_symlink():
                continue
            if entry.is_file():
                yield entry
            elif entry.is_dir() and depth:
                yield from self._walk(entry, depth - 1)

    def _outside(self, name: str) -> ArchiveError:
        return ArchiveError(f"{one_line(name):.200}: is no file of {self.root}; choose one that the library lists")


def _is_taken(path: Path, beside: tuple[str, ...]) -> bool:
    return any(one.exists() for one in (path, *(path.with_suffix(suffix) for suffix in beside)))


def _is_hidden(part: str) -> bool:
    return not part or part.startswith(".")


def _changed_s(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0
