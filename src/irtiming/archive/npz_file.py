"""Arrays of an ``.npz`` file, held against bounds before they are unpacked."""

import math
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from irtiming.errors import ArchiveError

MOST_BYTES = 2**32
"""Of all arrays together; frames beyond that go into a recording, or an ``.npy`` file, which are not read at once."""

_PACKED = 200
_SLACK_BYTES = 2**20


def read_arrays(path: Path, names: Sequence[str]) -> dict[str, Any]:
    """The named arrays that are there.

    Raises
    ------
    ArchiveError
        If the file does not exist, cannot be read, or unpacks into more than the bounds; the message ends with what was wrong.
    """
    with _refused(path, saved_by="numpy.savez"):
        with zipfile.ZipFile(path) as archive:
            there = [name for name in names if f"{name}.npy" in archive.namelist()]
            _require_bounded(path, archive, there)
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return {name: arrays[name] for name in there}


@contextmanager
def _refused(path: Path, *, saved_by: str) -> Iterator[None]:
    try:
        yield
    except FileNotFoundError as error:
        raise ArchiveError(f"{path}: does not exist; check the name") from error
    except ArchiveError:
        raise
    except Exception as error:  # of many kinds: numpy, zipfile and zlib each raise their own
        raise ArchiveError(f"{path}: cannot be read as arrays ({error}); save them again with {saved_by}") from error


def _require_bounded(path: Path, archive: zipfile.ZipFile, names: Sequence[str]) -> None:
    total = 0
    for name in names:
        member = archive.getinfo(f"{name}.npy")
        total += member.file_size
        if member.file_size > _PACKED * member.compress_size + _SLACK_BYTES or total > MOST_BYTES:
            raise ArchiveError(
                f"{path}: '{name}' unpacks from {member.compress_size} into {member.file_size} bytes; it may be {_PACKED} "
                f"times as many, and all arrays {MOST_BYTES}: save frames as .npy"
            )
        with archive.open(member) as file:
            version = np.lib.format.read_magic(file)
            read_header = (
                np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
            )
            shape, _, kind = read_header(file)
        if math.prod(shape) * kind.itemsize > member.file_size:
            raise ArchiveError(
                f"{path}: '{name}' says that it is {kind} {shape}, but has {member.file_size} bytes; save it again"
            )
