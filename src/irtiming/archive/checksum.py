"""SHA-256 of a file, read piece by piece."""

import hashlib
from pathlib import Path

from irtiming.errors import ArchiveError


def sha256_of(path: str | Path) -> str:
    """Hexadecimal SHA-256 of a file of any length.

    Raises
    ------
    ArchiveError
        If the file cannot be read.
    """
    try:
        with Path(path).open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        reason = error.strerror or error
        raise ArchiveError(f"{path}: cannot be read ({reason}); check its name and permissions") from error
