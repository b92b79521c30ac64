"""Opening HDF5 files, and turning what the HDF5 library throws into one line that a person can act on."""

import errno
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py
import hdf5plugin  # registers the compression filters: without it reading a compressed file fails  # noqa: F401

from irtiming.archive import layout
from irtiming.archive.finding import Complaint, refuse

H5_ERRORS = (OSError, RuntimeError, KeyError, ValueError, TypeError)
"""All that h5py is known to throw on a damaged or foreign file."""

_CACHE_BYTES = 8 * 2**20


@contextmanager
def opened(path: str | Path) -> Iterator[h5py.File]:
    """HDF5 file opened for reading.

    Raises
    ------
    Complaint
        If there is no such file, or it cannot be opened as HDF5.
    """
    where = Path(path)
    if where.is_dir():
        raise refuse("", "is a folder, not a recording", cure=f"name a {layout.SUFFIX} file in it")
    try:
        file = h5py.File(where, "r", rdcc_nbytes=_CACHE_BYTES)
    except H5_ERRORS as error:
        raise _why_not_opened(where, error) from error
    with file:
        yield file


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
            where, f"cannot be read ({reason_of(error)})", cure="the file is damaged; copy or record it again"
        ) from error


def reason_of(error: BaseException) -> str:
    """The innermost reason in an h5py message: the text in its last bracket."""
    text = " ".join(str(error).split()).strip("'\"")
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
        return refuse("", "does not exist", cure="check the name")
    if isinstance(error, PermissionError) or number in (errno.EACCES, errno.EPERM):
        return refuse("", "may not be read", cure="give yourself read permission (chmod u+r)")
    if isinstance(error, BlockingIOError) or "unable to lock file" in text:
        return refuse("", "is locked", cure="another program is writing it; wait until it has finished")
    size = path.stat().st_size if path.exists() else 0
    if path.exists() and size == 0:
        return refuse("", "is empty (0 bytes)", cure="copy or record it again")
    if "truncated file" in text:
        whole = re.search(r"stored_eof = (\d+)", text)
        of = f" of {whole[1]}" if whole else ""
        return refuse("", f"is truncated: {size}{of} bytes are left", cure="copy it again, or record it again")
    if "signature not found" in text:
        return refuse(
            "", "is not an HDF5 file", cure=f"name a recording ({layout.SUFFIX}), see {layout.REFERENCE_PAGE}"
        )
    return refuse(
        "",
        f"cannot be opened as HDF5 ({reason_of(error)})",
        cure="the file is damaged; copy or record it again",
    )
