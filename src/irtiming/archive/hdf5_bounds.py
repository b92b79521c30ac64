"""What an HDF5 file may ask of whoever reads it: the one place where a foreign file is held against bounds, before it is read.

HDF5 does what a file says: it opens other files that it links to, makes room for as many numbers as it declares, and unpacks
what is packed a thousandfold. So every place that this program reads is looked at when the file is opened: each must be in
this very file, stored as plain or packed data, and of a size that a recording can have.
"""

import math
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, final

import h5py

from irtiming.archive import layout
from irtiming.archive.finding import refuse
from irtiming.archive.layout import Field

H5_ERRORS = (OSError, RuntimeError, KeyError, ValueError, TypeError, UnicodeDecodeError)
"""All that h5py is known to throw on a damaged or foreign file."""

MOST_ENTRIES = 2**25
"""Ticks and other numbers of all lists together: 256 MiB, or 31 hours of 100 slots at 3 Hz."""

MOST_FRAMES = 2**20
MOST_PIXELS = 2**25
"""Of one frame: 64 MiB."""

MOST_CHUNK_BYTES = 2**28
MOST_TEXT_BYTES = 2**16
MOST_ATTRIBUTE_BYTES = 2**16
MOST_NAMES = 1000
"""In a group that is read, and attributes of a place."""

DEEPEST = 32
MOST_OBJECTS = 10_000
"""What is not read: groups in groups, and objects of the whole file that are named."""

_PACKED_BEYOND = 1.125
_PACKED_EXTRA_BYTES = 2**16
_CURE = "it is no recording as irtiming writes it; see docs/reference/recording-file.md"


def require_bounded(file: h5py.File) -> None:
    """Refuse a file of which a place that is read lies elsewhere, or asks for more than a recording can.

    Places that are not there, or damaged, are left to those who read them.

    Raises
    ------
    Complaint
        About the first such place.
    """
    look = _Look()
    look.group("/", file.id)
    for path in layout.GROUPS:
        look.at(path)
    for one in layout.FIELDS:
        look.at(one.path, one)
    for path in (layout.TRUTH, layout.ACQUISITION):
        for name in look.names(path):
            look.at(f"{path}/{name}")


def require_few_objects(file: h5py.File) -> None:
    """Refuse a file whose groups go too deep, or that names too many objects, before all of it is copied.

    Raises
    ------
    Complaint
        About the first object beyond.
    """
    n_objects, beyond = 0, ""

    def see(name: bytes) -> bool | None:
        nonlocal n_objects, beyond
        n_objects += 1
        if n_objects > MOST_OBJECTS or name.count(b"/") > DEEPEST:
            beyond = f"/{name[:40].decode(errors='replace')}"
        return True if beyond else None

    with suppress(*H5_ERRORS):
        h5py.h5o.visit(file.id, see)
    if beyond:
        _refuse_much(beyond, "is one object too many", f"there may be {MOST_OBJECTS}, {DEEPEST} groups deep")


def require_bounded_stack(path: str, dataset: h5py.Dataset) -> None:
    """Refuse a stack of frames, wherever it stands in a file, that lies elsewhere or asks for more than frames can.

    Raises
    ------
    Complaint
        If it does.
    """
    _Look().dataset(path, dataset.id, layout.FRAMES)


def stack_in(file: h5py.File) -> str | None:
    """Place of the frames: that of a recording, else the largest stack of numbers of three axes; None where there is none.

    Raises
    ------
    Complaint
        If the file names too many objects to look at.
    """
    require_few_objects(file)
    found: dict[str, int] = {}

    def see(name: str, there: object) -> None:
        if isinstance(there, h5py.Dataset) and there.ndim == 3 and there.dtype.kind in "uif":
            found[f"/{name}"] = math.prod(there.shape)

    if isinstance(file.get(layout.FRAMES.path), h5py.Dataset):
        return layout.FRAMES.path
    file.visititems(see)
    return max(found, key=found.__getitem__) if found else None


@final
@dataclass
class _Look:
    """One look through a file; ``groups`` are those that were found sound, by their path."""

    groups: dict[str, Any] = field(default_factory=dict)
    n_entries: int = 0

    def at(self, path: str, one: Field | None = None) -> None:
        """Look at a place below a group that was found sound, a field of the layout or not."""
        above, _, name = path.rpartition("/")
        parent = self.groups.get(above or "/")
        if parent is None:
            return
        try:
            link = parent.links.get_info(name.encode())
            kind = h5py.h5o.get_info(parent, name.encode()).type if link.type == h5py.h5l.TYPE_HARD else None
        except H5_ERRORS:
            return
        if kind is None:
            raise refuse(
                path,
                "is a link to another place",
                code="place-is-a-link",
                cure="no checksum covers what it leads to: store the data there themselves (h5copy, h5repack)",
            )
        try:
            found = h5py.h5o.open(parent, name.encode())
        except H5_ERRORS:
            return
        if isinstance(found, h5py.h5d.DatasetID):
            self.dataset(path, found, one)
        elif isinstance(found, h5py.h5g.GroupID):
            self.group(path, found)

    def group(self, path: str, found: Any) -> None:
        """Take a group for sound whose names are few."""
        _few_attributes(path, found)
        try:
            n_names = h5py.h5g.open(found, b".").get_num_objs()
        except H5_ERRORS:
            return
        if n_names > MOST_NAMES:
            _refuse_much(path, f"has {n_names} entries", f"it may have {MOST_NAMES}")
        self.groups[path] = found

    def names(self, path: str) -> list[str]:
        """Names in a group, none where there is no sound one."""
        found = self.groups.get(path)
        try:
            return [] if found is None else [name.decode() for name in found]
        except H5_ERRORS:
            return []

    def dataset(self, path: str, found: h5py.h5d.DatasetID, one: Field | None) -> None:
        """Refuse a dataset whose data lie elsewhere or are too many."""
        _few_attributes(path, found)
        try:
            properties = found.get_create_plist()
            storage, shape = properties.get_layout(), found.shape
            is_elsewhere = storage == h5py.h5d.VIRTUAL or properties.get_external_count() > 0
            entry_bytes = found.get_type().get_size()
        except H5_ERRORS:
            return
        if is_elsewhere:
            raise refuse(
                path,
                "takes its data from another place",
                code="data-elsewhere",
                cure="no checksum covers them: store the data there themselves (h5repack)",
            )
        self._require_size(path, shape, one, entry_bytes=entry_bytes)
        if storage == h5py.h5d.CHUNKED:
            try:
                chunk_bytes = math.prod(properties.get_chunk()) * entry_bytes
                filters = [properties.get_filter(i)[0] for i in range(properties.get_nfilters())]
            except H5_ERRORS:
                return
            if chunk_bytes > MOST_CHUNK_BYTES:
                _refuse_much(path, f"has chunks of {chunk_bytes} bytes", f"they may have {MOST_CHUNK_BYTES}")
            if len(set(filters)) < len(filters):
                _refuse_much(path, "is packed more than once by one filter", "each filter may be there once")
            _refuse_lying_chunks(path, found, most=int(chunk_bytes * _PACKED_BEYOND) + _PACKED_EXTRA_BYTES)

    def _require_size(self, path: str, shape: tuple[int, ...], one: Field | None, *, entry_bytes: int) -> None:
        n_entries = math.prod(shape)
        if one is not None and one.kind == "frames":
            n_frames, n_pixels = (shape[0], math.prod(shape[1:])) if shape else (1, 1)
            if n_frames > MOST_FRAMES or n_pixels > MOST_PIXELS:
                _refuse_much(path, f"has shape {shape}", f"it may have {MOST_FRAMES} frames of {MOST_PIXELS} pixels")
            return
        if one is not None and one.kind in ("text", "number", "integer"):
            if n_entries * entry_bytes > MOST_TEXT_BYTES:
                _refuse_much(path, f"has {n_entries * entry_bytes} bytes", f"it may have {MOST_TEXT_BYTES}")
            return
        self.n_entries += max(1, entry_bytes // 8) * n_entries
        if self.n_entries > MOST_ENTRIES:
            _refuse_much(path, f"has shape {shape}", f"all lists together may have {MOST_ENTRIES} entries")


def _few_attributes(path: str, found: Any) -> None:
    try:
        n_attributes = h5py.h5a.get_num_attrs(found)
        sizes = [
            h5py.h5a.open(found, index=i).get_storage_size() for i in range(n_attributes) if n_attributes <= MOST_NAMES
        ]
    except H5_ERRORS:
        return
    if n_attributes > MOST_NAMES or max(sizes, default=0) > MOST_ATTRIBUTE_BYTES:
        what = f"has {n_attributes} attributes, the longest of {max(sizes, default=0)} bytes"
        _refuse_much(path, what, f"there may be {MOST_NAMES} of {MOST_ATTRIBUTE_BYTES} bytes")


def _refuse_lying_chunks(path: str, found: h5py.h5d.DatasetID, *, most: int) -> None:
    """Packed data are no longer than unpacked ones: a chunk that is would be unpacked into more than it declares."""
    longest = 0

    def see(chunk: Any) -> None:
        nonlocal longest
        longest = max(longest, chunk.size)

    try:
        found.chunk_iter(see)
    except H5_ERRORS:
        return
    if longest > most:
        _refuse_much(path, f"has a chunk of {longest} bytes in the file", f"by its size it may have {most}")


def _refuse_much(path: str, what: str, bound: str) -> None:
    raise refuse(path, what, code="beyond-bounds", cure=f"{bound}; {_CURE}")
