"""Opening HDF5 files, and turning what the HDF5 library throws into one line that a person can act on."""

import ctypes
import errno
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py
import hdf5plugin  # registers the compression filters: without it reading a compressed file fails  # noqa: F401

from irtiming.archive import layout
from irtiming.archive.finding import Complaint, refuse
from irtiming.archive.hdf5_bounds import H5_ERRORS as H5_ERRORS
from irtiming.archive.hdf5_bounds import require_bounded
from irtiming.archive.hdf5_probe import require_survivable

_CACHE_BYTES = 8 * 2**20
_READ_ATTEMPTS = 25
"""How often HDF5 looks at metadata whose checksum is wrong, in case a writer is about to put them right: for 40 ms. It waits
twice as long before each attempt, so that its own choice of 100 means for ever if the file is damaged."""


@contextmanager
def opened(path: str | Path, *, is_growing: bool = False) -> Iterator[h5py.File]:
    """HDF5 file opened for reading; ``is_growing`` for one that is being written, or was when its writer was killed.

    Raises
    ------
    Complaint
        If there is no such file, it cannot be opened as HDF5, or a place in it is beyond the bounds of `hdf5_bounds`.
    """
    where = Path(path)
    if where.is_dir():
        raise refuse("", "is a folder, not a recording", code="is-a-folder", cure=f"name a {layout.SUFFIX} file in it")
    if where.exists() and not where.is_file():
        raise refuse("", "is no file but a device or a pipe", code="not-a-file", cure="name a recording")
    if not is_growing:
        require_survivable(where)
    try:
        file = _open_growing(where) if is_growing else h5py.File(where, "r", rdcc_nbytes=_CACHE_BYTES)
    except H5_ERRORS as error:
        raise _why_not_opened(where, error) from error
    with file:
        require_bounded(file)
        yield file


def _open_growing(path: Path) -> h5py.File:
    access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
    library = ctypes.CDLL(h5py.h5p.__file__)  # h5py has no name for this setting
    library.H5Pset_metadata_read_attempts(ctypes.c_int64(access.id), ctypes.c_uint(_READ_ATTEMPTS))
    flags = h5py.h5f.ACC_RDONLY | h5py.h5f.ACC_SWMR_READ
    return h5py.File(h5py.h5f.open(os.fsencode(path), flags, fapl=access))


@contextmanager
def damage_at(where: str) -> Iterator[None]:
    """Turn an exception of h5py inside the block into a complaint about one place of the file.

    Raises
    ------
    Complaint
        Saying that this place is damaged, with the reason that HDF5 gives.
    """
    try:
        yield
    except H5_ERRORS as error:
        raise refuse(
            where,
            f"cannot be read ({reason_of(error)})",
            code="place-damaged",
            cure="the file is damaged; copy or record it again",
        ) from error


def reason_of(error: BaseException) -> str:
    """The innermost reason in an h5py message: what the system says, else the text in its last bracket."""
    says = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    text = " ".join(says.split()).strip("'\"")
    if found := re.search(r"error message = '([^']+)'", text):
        return found[1]
    inner = re.search(r"\((.+)\)$", text)
    return inner[1] if inner else text or type(error).__name__


def missing_filters(dataset: h5py.Dataset) -> list[str]:
    """Names of the compression filters of a dataset that this installation does not have."""
    properties = dataset.id.get_create_plist()
    missing = []
    for index in range(properties.get_nfilters()):
        number, _, _, name = properties.get_filter(index)
        if not h5py.h5z.filter_avail(number):
            text = name.decode("utf-8", "replace").strip("\0 ") if isinstance(name, bytes) else str(name)
            missing.append(f"{number} ({text})" if text else f"{number}")
    return missing


def _why_not_opened(path: Path, error: BaseException) -> Complaint:
    number = getattr(error, "errno", None)
    text = str(error)
    if isinstance(error, FileNotFoundError) or number == errno.ENOENT:
        return refuse("", "does not exist", code="does-not-exist", cure="check the name")
    if isinstance(error, PermissionError) or number in (errno.EACCES, errno.EPERM):
        return refuse("", "may not be read", code="may-not-be-read", cure="give yourself read permission (chmod u+r)")
    if isinstance(error, BlockingIOError) or "unable to lock file" in text:
        return refuse(
            "", "is locked", code="is-locked", cure="another program is writing it; wait until it has finished"
        )
    if "already open for write" in text:
        return refuse(
            "",
            "is not finished: it is being written, or the program that wrote it was killed",
            code="being-written",
            cure=f"wait, or run irtiming recover on it (its name must end in {layout.SUFFIX}{layout.PART})",
        )
    size = path.stat().st_size if path.exists() else 0
    if path.exists() and size == 0:
        return refuse("", "is empty (0 bytes)", code="is-empty", cure="copy or record it again")
    if "truncated file" in text:
        whole = re.search(r"stored_eof = (\d+)", text)
        of = f" of {whole[1]}" if whole else ""
        return refuse(
            "",
            f"is truncated: {size}{of} bytes are left",
            code="is-truncated",
            cure="copy it again, or record it again",
        )
    if "signature not found" in text:
        return _not_hdf5(path)
    return refuse(
        "",
        f"cannot be opened as HDF5 ({reason_of(error)})",
        code="cannot-be-opened",
        cure="the file is damaged; copy or record it again",
    )


def _not_hdf5(path: Path) -> Complaint:
    """What a file is that is no HDF5, where it is one of frames."""
    from irtiming.archive.frames.opening import describe  # it reads HDF5 too

    if found := describe(path):
        return refuse(
            "",
            f"is {found}, not a recording",
            code="frames-alone",
            cure="make one of it and a capture of the triggers with irtiming import-capture --frames",
        )
    return refuse(
        "",
        "is not an HDF5 file",
        code="not-hdf5",
        cure=f"name a recording ({layout.SUFFIX}), see {layout.REFERENCE_PAGE}",
    )
