"""Recordings that lie about what is in them: each changes the open file of a sound one, in plain h5py."""

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np

CAMERA = "entry/instrument/camera"
LINES = "entry/instrument/trigger_generator"
TICKS = f"{LINES}/control_slot"
HOST_TIMES = f"{CAMERA}/frame_host_time"
FRAMES = f"{CAMERA}/data"

Change = Callable[[h5py.File], object]


def _anew(file: h5py.File, path: str, **options: object) -> h5py.Dataset:
    if path in file:
        del file[path]
    return file.create_dataset(path, **options)


def _texts(file: h5py.File) -> None:
    _anew(file, f"{CAMERA}/type", shape=(10**9,), dtype=h5py.string_dtype(), chunks=(1000,))


def _long_text(file: h5py.File) -> None:
    text = _anew(file, f"{CAMERA}/vendor", shape=(1,), dtype="S2000000", chunks=(1,), compression="gzip")
    text[0] = b"x" * 2_000_000


def _bomb(path: str, kind: str) -> Change:
    def put(file: h5py.File) -> None:
        n, chunk = 300_000_000, 2**20
        dataset = _anew(file, path, shape=(n,), dtype=kind, chunks=(chunk,), compression="gzip", compression_opts=1)
        dataset[:chunk] = np.zeros(chunk, kind)
        _, stored = dataset.id.read_direct_chunk((0,))
        for first in range(chunk, n, chunk):
            dataset.id.write_direct_chunk((first,), stored)

    return put


def _chunk(file: h5py.File) -> None:
    _anew(file, TICKS, shape=(401,), maxshape=(None,), dtype="i8", chunks=(2**28,), compression="gzip")


def _twice_packed(file: h5py.File) -> None:
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_chunk((401,))
    for _ in range(2):
        properties.set_deflate(1)
    ticks = file[TICKS][()]
    del file[TICKS]
    space, kind = h5py.h5s.create_simple((401,)), h5py.h5t.NATIVE_INT64
    made = h5py.h5d.create(file[LINES].id, b"control_slot", kind, space, properties)
    made.write(h5py.h5s.ALL, h5py.h5s.ALL, ticks)


def _virtual(path: str, n: int, source: str) -> Change:
    def put(file: h5py.File) -> None:
        if path in file:
            del file[path]
        layout = h5py.VirtualLayout(shape=(n,), dtype="i8")
        layout[:] = h5py.VirtualSource(source, path, shape=(n,))
        file.create_virtual_dataset(path, layout, fillvalue=3)

    return put


def _external_storage(where: Path) -> Change:
    return lambda file: _anew(file, TICKS, shape=(401,), dtype="i8", external=[(str(where), 0, h5py.h5f.UNLIMITED)])


def _external_text(where: Path) -> Change:
    return lambda file: _anew(
        file, f"{CAMERA}/type", shape=(1,), dtype="S40", external=[(str(where), 0, h5py.h5f.UNLIMITED)]
    )


def _link(path: str, link: object) -> Change:
    def put(file: h5py.File) -> None:
        if path in file:
            del file[path]
        file[path] = link

    return put


def _nested(n: int) -> Change:
    def put(file: h5py.File) -> None:
        group = file.create_group("entry/deep")
        for _ in range(n):
            group = group.create_group("d")

    return put


def _crowded(file: h5py.File) -> None:
    group = file[LINES]
    for number in range(1100):
        group.create_group(f"control_slo{number}")


def _huge_frames(file: h5py.File) -> None:
    _anew(file, FRAMES, shape=(2, 60_000, 60_000), dtype="u2", chunks=(1, 1, 8), compression="gzip")


def _many_frames(file: h5py.File) -> None:
    _anew(file, FRAMES, shape=(2**26, 1, 1), dtype="u2", chunks=(2**26, 1, 1), compression="gzip")


def _attributes(file: h5py.File) -> None:
    for number in range(1100):
        file[TICKS].attrs[f"note {number}"] = number


def _truth(file: h5py.File) -> None:
    _anew(file, "entry/truth/x", shape=(2**40,), dtype="f8", chunks=(2**20,))


def hostile(secret: Path, pipe: Path) -> dict[str, Change]:
    """By name; ``secret`` is a file whose content must not be told, ``pipe`` one that nobody writes to."""
    return {
        "a thousand million texts": _texts,
        "a long packed text": _long_text,
        "packed ticks": _bomb(TICKS, "i8"),
        "packed host times": _bomb(HOST_TIMES, "f8"),
        "a chunk of 2 GiB": _chunk,
        "packed twice": _twice_packed,
        "virtual ticks": _virtual(TICKS, 10**10, "nowhere.h5"),
        "virtual ticks of themselves": _virtual(TICKS, 401, "."),
        "ticks stored in a pipe": _external_storage(pipe),
        "text stored in another file": _external_text(secret),
        "link to a pipe": _link(TICKS, h5py.ExternalLink(str(pipe), "/x")),
        "link to another file": _link(FRAMES, h5py.ExternalLink(str(secret), "/x")),
        "group in another file": _link("entry/nonuniformity_reference", h5py.ExternalLink(str(pipe), "/x")),
        "soft link to itself": _link(TICKS, h5py.SoftLink(f"/{TICKS}")),
        "soft link by way of a pipe": _link(TICKS, h5py.SoftLink("/out/x")),
        "2000 groups one in the other": _nested(2000),
        "a crowded group": _crowded,
        "frames of 7 GB": _huge_frames,
        "67 million frames": _many_frames,
        "many attributes": _attributes,
        "a truth of 8 TiB": _truth,
    }
