"""Files of frames: for each reader small valid ones, and the look that the program takes at every frame."""

import json
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from irtiming.archive.frames.opening import open_frames

sys.path.insert(0, str(Path(__file__).parents[1] / "subjects" / "archive"))

TEXTS = (".hdr", ".json")
"""What describes values in a file beside it."""

ENDINGS = (
    ".ptw", ".irb", ".fff", ".seq", ".csq", ".sfmov", ".hcc", ".fits", ".mkv", ".avi", ".tif", ".npy", ".npz", ".pgm", ".png",
    ".h5", *TEXTS,
)  # fmt: skip
_MOST_FRAMES = 50


def looked_at(path: Path) -> None:
    """Read frames block by block, and pick one."""
    source = open_frames(path)
    seen = 0
    for first, block in source.blocks():
        assert first == seen
        assert block.shape[1:] == source.shape[1:]
        seen += len(block)
        if seen > _MOST_FRAMES:
            break
    source.pick([source.shape[0] - 1])


def _written(write: Callable[[Path], object], name: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        write(path)
        return path.read_bytes()


def seeds_of(ending: str) -> list[bytes]:
    """Small valid files whose names end so."""
    return _seeds()[ending]


@cache
def _seeds() -> dict[str, list[bytes]]:
    import tifffile
    from makers_files import FRAMES, WRITERS

    found: dict[str, list[bytes]] = {}
    for name, write in WRITERS.items():
        found.setdefault(Path(name).suffix, []).append(_written(write, name))
    small = FRAMES[:5, :8, :10]
    found[".tif"] = [
        _written(lambda path: tifffile.imwrite(path, small), "a.tif"),
        _written(
            lambda path: tifffile.imwrite(path, small, bigtiff=True, compression="zlib", photometric="minisblack"),
            "a.tif",
        ),
        _written(lambda path: tifffile.imwrite(path, small, byteorder=">", imagej=True), "a.tif"),
    ]
    found[".h5"] = [_written(lambda path: _hdf5(path, small), "a.h5")]
    found[".npy"] = [_written(lambda path: np.save(path, small), "a.npy")]
    found[".npz"] = [_written(lambda path: np.savez_compressed(path, frames=small), "a.npz")]
    found[".pgm"] = [b"P5\n# by hand\n10 8\n16383\n" + small[0].astype(">u2").tobytes()]
    found[".png"] = [_png(small[0])]
    lines = (
        "ENVI",
        "samples = 10",
        "lines = 8",
        "bands = 3",
        "header offset = 0",
        "data type = 12",
        "interleave = bil",
    )
    found[".hdr"] = ["\n".join(lines).encode() + b"\n"]
    facts = {"rows": 8, "columns": 10, "times_s": [0.1, 0.2, 0.3], "more": {"lens": "50 mm"}, "camera": {"model": "a"}}
    found[".json"] = [json.dumps(facts).encode()]
    return found


def _hdf5(path: Path, frames: np.ndarray) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        file.create_dataset("run/counts", data=frames, chunks=(1, 8, 10), compression="gzip")
        file["run/dark"] = frames[:1].astype(np.float32)


def _png(frame: np.ndarray) -> bytes:
    import imagecodecs

    return bytes(imagecodecs.png_encode(np.ascontiguousarray(frame)))


def beside(path: Path) -> None:
    """Values that a header or a JSON file beside them describes; the input is the description."""
    data = path.with_suffix(".raw")
    data.write_bytes(bytes(480))
    looked_at(data)
