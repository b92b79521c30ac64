"""Files that are written whole or not at all: under another name until everything is in them."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from irtiming.archive.hdf5_file import H5_ERRORS, reason_of
from irtiming.archive.hdf5_output import writing
from irtiming.archive.json_file import unwritable
from irtiming.archive.layout import PART
from irtiming.errors import ArchiveError


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """Give the name to write under; when the ``with`` block ends well, that file takes the place of ``path``.

    If the block raises, nothing is left behind, and an earlier file of that name stays as it was.

    Raises
    ------
    ArchiveError
        If the file cannot be written.
    """
    target = Path(path)
    part = target.with_name(f"{target.name}{PART}")
    try:
        yield part
        part.replace(target)
    except OSError as error:
        raise unwritable(target, error) from error
    finally:
        part.unlink(missing_ok=True)


@contextmanager
def whole_hdf5(path: str | Path, *, copy_of: str | Path | None = None) -> Iterator[h5py.File]:
    """The same for an HDF5 file, which begins empty or as a copy of another; the copy may be of ``path`` itself.

    Raises
    ------
    ArchiveError
        If the file cannot be written.
    """
    with whole_file(path) as part:
        if copy_of is not None:
            shutil.copyfile(copy_of, part)
        try:
            with writing(part, "w" if copy_of is None else "r+") as (file, _):
                yield file
        except OSError:
            raise
        except H5_ERRORS as error:
            raise ArchiveError(f"{path}: cannot be written ({reason_of(error)}); is the disk full?") from error
