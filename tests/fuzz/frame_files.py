"""Files of frames: for each reader small valid ones, and the look that the program takes at every frame."""

import json
import sys
import tempfile
from collections.abc import Callable
from functools import cache, partial
from importlib.util import find_spec
from pathlib import Path

import mutations
import numpy as np
from target import OF_TEXT, Target, in_file

from irtiming.archive.frames.opening import open_frames

sys.path.insert(0, str(Path(__file__).parents[1] / "subjects" / "archive"))

TEXTS = (".hdr", ".json")
"""What describes values in a file beside it."""

ENDINGS = (
    ".ptw", ".irb", ".fff", ".seq", ".csq", ".sfmov", ".hcc", ".fits", ".mkv", ".avi", ".tif", ".npy", ".npz", ".pgm", ".png",
    ".h5", *([".bag"] if find_spec("rosbags") else []), *TEXTS,
)  # fmt: skip
_SLOW = {".h5": 16, ".bag": 16}
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
    if ".bag" in ENDINGS:
        found[".bag"] = [_written(_bag, "a.bag")]
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


def _bag(path: Path) -> None:
    """Three images as ROS 1 writes them."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    header, stamp = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    kind = "sensor_msgs/msg/Image"
    with Writer(path) as writer:
        line = writer.add_connection("/camera/image_raw", kind, typestore=store)
        for k in range(3):
            image = store.types[kind](
                header=header(seq=k, stamp=stamp(sec=1_700_000_000, nanosec=33_000_000 * k), frame_id="camera"),
                height=8, width=10, encoding="mono16", is_bigendian=0, step=20, data=np.arange(160, dtype=np.uint8),
            )  # fmt: skip
            writer.write(line, 10**9 * k, store.serialize_ros1(image, kind))


TARGETS = {
    f"frames {ending}": Target(
        seeds=partial(seeds_of, ending),
        take=in_file(f"a{ending}", beside if ending in TEXTS else looked_at),
        changes=OF_TEXT if ending in TEXTS else (mutations.of_bytes,),
        round=_SLOW.get(ending, 1),
    )
    for ending in ENDINGS
}
