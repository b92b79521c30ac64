"""Recordings, finished and interrupted ones, and scenes: HDF5 in whose places something else stands."""

import io
import random
import tempfile
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import frame_files
import h5py
import mutations
import numpy as np
from target import Target, in_file

from irtiming.archive.live.recording import LiveRecording
from irtiming.archive.live.recovery import recover
from irtiming.archive.live.so_far import read_so_far
from irtiming.archive.live.unfinished import part_of
from irtiming.archive.reader import read, read_acquisition, read_truth
from irtiming.archive.scene_file import SCENE, made_from
from irtiming.archive.timestamps_file import read_timestamps
from irtiming.archive.verify import verify


def _recording() -> bytes:
    memory, rng = io.BytesIO(), np.random.default_rng(1)
    with h5py.File(memory, "w") as file:
        _fill(file, rng)
    return memory.getvalue()


def _fill(file: h5py.File, rng: np.random.Generator) -> None:
    turn, period, n_frames = 16_384_000, 1_622_016, 12
    camera = file.create_group("entry/instrument/camera")
    camera["type"], camera["readout_mode"] = np.bytes_("photon"), "snapshot"
    camera["vendor"] = "somebody"
    frames = rng.integers(1000, 9000, (n_frames, 4, 6), dtype=np.uint16)
    camera.create_dataset("data", data=frames, chunks=(1, 4, 6), compression="gzip")
    camera["count_time"], camera["bit_depth_readout"] = 250e-6, 14
    camera["count_time"].attrs["units"] = "s"
    camera["frame_number"], camera["frame_status"] = np.arange(n_frames), np.zeros(n_frames, "u1")
    camera["frame_timestamp"], camera["timestamp_frequency"] = 1000 + 33 * np.arange(n_frames), 1e3
    file["entry/instrument/chopper/rotation_speed"] = 3.0
    lines = file.create_group("entry/instrument/trigger_generator")
    lines["clock_frequency"] = 49_152_000
    lines["camera_trigger"] = 23_384_000 + period * np.arange(n_frames)
    lines.create_dataset(
        "control_slot", data=7_000_000 + turn // 100 * np.arange(301), chunks=(50,), compression="gzip"
    )
    lines["application_slot"] = 7_000_005 + turn // 2 * np.arange(7)
    lines["camera_period"], lines["wheel_period"] = period, turn
    lines["lost_after"] = np.empty(0, "i8")
    file["entry/truth/trigger_delay_s"] = 4e-4
    file["entry/acquisition/chopper_blade"] = "MC1F100"
    for name, level in (("low", 1500), ("high", 8000)):
        frames = rng.integers(level, level + 40, (3, 4, 6), "u2")
        stack = file.create_dataset(f"entry/nonuniformity_reference/{name}", data=frames)
        stack.attrs["temperature"] = 288.15 if name == "low" else 303.15


def _of_hdf5(rng: random.Random, seed: bytes, _: object) -> bytes:
    """The recording with datasets, attributes and groups in whose places others stand."""
    memory, numbers = io.BytesIO(seed), np.random.default_rng(rng.randrange(2**32))
    with h5py.File(memory, "r+") as file:
        for _ in range(rng.choice((1, 1, 2, 4))):
            with suppress(
                OSError, RuntimeError, ValueError, TypeError, LookupError
            ):  # what HDF5 itself refuses is no change
                _change(file, rng, numbers)
    return memory.getvalue()


def _change(file: h5py.File, rng: random.Random, numbers: np.random.Generator) -> None:
    paths = _paths(file)
    path, other = rng.choice(paths), rng.choice(paths)
    match rng.randrange(6):
        case 0:
            file[path].attrs[rng.choice(("units", "temperature", "irtiming_layout"))] = _value(rng, numbers)
        case 1:
            del file[path]
        case 2 if not path.startswith(other) and not other.startswith(path):
            del file[path]
            file[path] = file[other]
        case 3 if isinstance(file[path], h5py.Dataset) and file[path].ndim == 1 and file[path].dtype.kind in "iuf":
            values, attributes = file[path][()], dict(file[path].attrs)
            place = rng.randrange(len(values)) if len(values) else 0
            odd = rng.choice((0, -1, 2**62, 2**63 - 1)) % 2 ** (8 * values.itemsize - 1)
            values[place:] = odd if rng.random() < 0.5 else values[:1].sum()
            del file[path]
            file[path] = values
            file[path].attrs.update(attributes)
        case _:
            value = _value(rng, numbers)
            del file[path]
            file[path] = value


def _paths(file: h5py.File) -> list[str]:
    found: list[str] = []
    file.visit(found.append)
    return found


def _value(rng: random.Random, numbers: np.random.Generator) -> Any:
    shape = tuple(rng.choice((0, 1, 1, 2, 12, 40)) for _ in range(rng.choice((0, 0, 1, 1, 2, 3))))
    match rng.randrange(4):
        case 0:
            text = rng.choice(("", "photon", "snapshot", "ticks", "s", "\ud7ff", "x" * 3000, "\x1b[31m"))
            return text if rng.random() < 0.5 else np.full(shape, text.encode("utf-8", "replace"))
        case 1:
            value = rng.choice((0.0, -1.0, 1e308, 5e-324, np.nan, np.inf, 3.0))
            return np.full(shape, value, dtype=rng.choice(("f4", "f8")))
        case 2:
            kind = rng.choice(("i1", "u1", "i4", "u2", "i8", "u8", "bool"))
            return np.full(shape, rng.choice((0, 1, 127)), dtype=kind)
        case _:
            return (
                numbers.integers(-(2**62), 2**62, shape)
                if rng.random() < 0.5
                else np.sort(numbers.integers(0, 10**9, shape or (1,)))
            )


def _look_at(path: Path) -> None:
    found = read(path)
    for stack in (found.frames, *([found.nonuniformity.low_frames] if found.nonuniformity else [])):
        for _ in stack.blocks():
            pass


def _verified(path: Path) -> None:
    for finding in verify(path):
        assert len(finding.sentence()) < 2100
        assert finding.sentence().isprintable()


def _exported(path: Path) -> None:
    from irtiming.archive.vcd_export import write_vcd

    write_vcd(read_timestamps(path), path.with_suffix(".vcd"))


def _finished(path: Path) -> None:
    """As ``irtiming recover`` does, and what comes of it is verified."""
    for trust in (False, True):
        with suppress(FileExistsError):
            _verified(recover(path, path.with_name(f"{trust}.nxs"), keep=True, trust=trust))


def _so_far(path: Path) -> None:
    for _ in read_so_far(path).frames.blocks():
        pass


@cache
def _unfinished() -> bytes:
    """Five frames of a run whose program was killed: the file as it is before the run's end."""
    import live_run

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.nxs"
        with LiveRecording(path, head=live_run.head()) as live:
            live_run.append_edges(live)
            live_run.append_frames(live, range(12))
            found = part_of(path).read_bytes()
            live.finish("ended early")
        return found


def _scene() -> bytes:
    memory = io.BytesIO(_recording())
    with h5py.File(memory, "r+") as file:
        file[f"{SCENE}/frame_number"] = np.arange(12)
        file[f"{SCENE}/time"] = 0.03 * np.arange(12)
    return memory.getvalue()


TARGETS = {
    "recording": Target(
        seeds=lambda: [_recording()],
        take=in_file("a.nxs", _verified, _look_at, read_truth, read_acquisition, _exported, frame_files.looked_at),
        changes=(mutations.of_bytes, _of_hdf5),
        round=16,
    ),
    "interrupted recording": Target(
        seeds=lambda: [_unfinished()],
        take=in_file("a.nxs.part", _verified, _so_far, _finished),
        changes=(mutations.of_bytes, _of_hdf5),
        round=64,
    ),
    "scene": Target(
        seeds=lambda: [_scene()], take=in_file("a.nxs", made_from), changes=(mutations.of_bytes, _of_hdf5), round=32
    ),
}
