"""HDF5 files being written: a disk that takes no more ends in one error, and never in the HDF5 library.

HDF5 keeps what it could not write and tries again whenever it closes something, at last when the program ends, where it
crashes. So it does not hear of a write that failed: the rest goes nowhere, and the error is raised when it is asked for.
Ctrl-C and SIGTERM wait for the same reason: an exception in the middle of a write would be one that failed.
"""

import os
import shutil
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Literal, Self, final

import h5py

from irtiming.archive import layout
from irtiming.archive.hdf5_file import H5_ERRORS, reason_of
from irtiming.archive.held_signals import HeldSignals, held_signals
from irtiming.archive.whole_file import whole_file
from irtiming.errors import ArchiveError


@final
class Output:
    """A file on the disk as HDF5 writes it; after a failure it takes everything and keeps nothing."""

    def __init__(self, path: Path, mode: Literal["w", "r+"], *, held: HeldSignals) -> None:
        self.failure: OSError | None = None
        self._held = held
        self._place = 0
        self._descriptor = os.open(
            path, os.O_RDWR | (os.O_CREAT if mode == "w" else 0) | getattr(os, "O_BINARY", 0), 0o666
        )
        try:
            _claim(self._descriptor)
            if mode == "w":
                os.ftruncate(self._descriptor, 0)
        except OSError:
            os.close(self._descriptor)
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._descriptor)

    def require_written(self) -> None:
        """Raise what the system said to the first write that failed.

        Raises
        ------
        OSError
            Such as that of a full disk.
        KeyboardInterrupt
            If Ctrl-C was pressed, or SIGTERM came, since the file was opened.
        """
        self._held.tell()
        if self.failure is not None:
            raise OSError(self.failure.errno, self.failure.strerror) from self.failure

    def write(self, data: memoryview) -> int:
        """Write at the place, or let it go after a failure."""
        done = 0
        with self._remembered():
            while done < len(data) and self.failure is None:
                done += os.pwrite(self._descriptor, data[done:], self._place + done)
        self._place += len(data)
        return len(data)

    def truncate(self, size: int) -> int:
        """Make the file so many bytes long."""
        with self._remembered():
            if self.failure is None:
                os.ftruncate(self._descriptor, size)
        return size

    def read(self, size: int) -> bytes:
        """Read from the place; by this h5py knows that it may read."""
        content = bytearray(size)
        return bytes(content[: self.readinto(memoryview(content))])

    def readinto(self, buffer: memoryview) -> int:
        """Read from the place."""
        count = os.preadv(self._descriptor, [buffer], self._place)
        self._place += count
        return count

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Go to a place."""
        self._place = offset + (os.fstat(self._descriptor).st_size if whence == os.SEEK_END else 0)
        return self._place

    def tell(self) -> int:
        """The place."""
        return self._place

    def flush(self) -> None:
        """Nothing is held back."""

    @contextmanager
    def _remembered(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self.failure = error


@contextmanager
def writing(
    path: str | Path, mode: Literal["w", "r+"] = "w", *, page_bytes: int | None = None
) -> Iterator[tuple[h5py.File, Output]]:
    """HDF5 file to be written, anew or into one that is there, and what it is written to.

    Parameters
    ----------
    path, mode
        The file, and whether it begins empty.
    page_bytes
        Keep each header and index of a new file that is not longer within one page of so many bytes (HDF5's paged
        aggregation): what the system writes in one piece is then there as a whole or not at all.

    Raises
    ------
    OSError
        If it cannot be opened, another program has it, or not all of it could be written: at the end of the block, where the
        block does not ask before.
    """
    paged = {} if page_bytes is None else {"fs_strategy": "page", "fs_page_size": page_bytes}
    with held_signals() as held, Output(Path(path), mode, held=held) as output:
        with h5py.File(output, mode, libver=layout.HDF5_FORMAT, **paged) as file:
            yield file, output
        output.require_written()


def abandon(file: h5py.File) -> None:
    """Close a file that could not be written as if its program had been killed: what is on the disk stays as it is."""
    with suppress(OSError, RuntimeError, ValueError, AttributeError), ExitStack() as held:
        sink = os.memfd_create("abandoned")  # where there is none, HDF5 tries the disk once more
        held.callback(os.close, sink)
        os.dup2(sink, file.id.get_vfd_handle())
    with suppress(OSError, RuntimeError, ValueError):
        file.close()


def _claim(descriptor: int) -> None:
    """As HDF5 does it: one writer, or readers."""
    with suppress(ImportError):
        from fcntl import LOCK_EX, LOCK_NB, flock

        flock(descriptor, LOCK_EX | LOCK_NB)


@contextmanager
def whole_hdf5(path: str | Path, *, copy_of: str | Path | None = None) -> Iterator[h5py.File]:
    """A file that is written whole or not at all; it begins empty or as a copy of another, which may be ``path`` itself.

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
