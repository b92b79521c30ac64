"""What a capture may ask of whoever reads it: lines, changes and headers of any file, however hostile, are bounded here."""

from collections.abc import Iterator
from pathlib import Path
from typing import IO, AnyStr

from irtiming.archive.captures.capture import broken
from irtiming.errors import ArchiveError

MOST_CHANGES = 2**24
"""Of one line of the capture: 128 MiB, or 15 hours of 100 slots at 3 Hz."""

LONGEST_LINE = 2**16
MOST_HEADER_BYTES = 2**20
MOST_SAMPLE_BYTES = 64


def bounded_lines(path: Path, file: IO[AnyStr]) -> Iterator[AnyStr]:
    """Lines of a file, none of them too long.

    Raises
    ------
    ArchiveError
        At the first that is.
    """
    while line := file.readline(LONGEST_LINE + 1):
        if len(line) > LONGEST_LINE:
            raise broken(path, f"has a line of more than {LONGEST_LINE} characters; no capture has, so export it again")
        yield line


def too_many_changes(path: Path, name: str) -> ArchiveError:
    """Error for a line that changes more often than any line of a rig."""
    return broken(
        path,
        f"line '{name}' changes more than {MOST_CHANGES} times, which no line of a rig does; check its threshold, or cut the "
        "capture into pieces",
    )
