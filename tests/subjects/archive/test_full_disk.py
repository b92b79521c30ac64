"""A disk that takes no more, whatever is written: the project's own error, no file with a final name, no crash afterwards.

The disk is the system's word: a process that may not let a file grow beyond a limit (RLIMIT_FSIZE) is told so by each write.
Every writer runs with limits from nothing to almost enough, in a process of its own, since HDF5 used to crash at its end.
"""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
import pytest

_SWEEP = """
import resource, shutil, sys
from dataclasses import replace
from pathlib import Path
import numpy as np
from irtiming.archive import reader, reference_file, timestamps_file, writer
from irtiming.archive.captures.streams import CapturedTicks
from irtiming.archive.captures.timed_recording import write_timed
from irtiming.archive.frame_stack import ArrayFrames
from irtiming.archive.json_file import write_json
from irtiming.archive import layout
from irtiming.archive.scene_file import SceneHead, SceneWriter
from irtiming.errors import ArchiveError

source, folder, what = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3]
recording = reader.read(source)
noise = np.random.default_rng(1).integers(0, 2**14, (40, 4, 6)).astype(np.uint16)
long = replace(recording, frames=ArrayFrames(noise[:20]))
streams = {
    layout.CAMERA_TRIGGER: recording.camera_trigger_ticks,
    layout.CONTROL_SLOT: recording.control_slot_ticks,
    layout.APPLICATION_SLOT: recording.application_slot_ticks,
}
head = SceneHead(size=(4, 6), dtype="u2", unit="DN", tiles=(1, 1), tile_px=8, time_errors_s=0.0, description=("a" * 3000,))

def write_scene(path):
    with SceneWriter(path, head) as scene:
        for n, pixels in enumerate(noise):
            scene.append(pixels, number=n, time_s=float(n), gain=np.ones((1, 1)), noise_gain=np.ones((1, 1)))

ticks = CapturedTicks(clock_frequency_hz=int(recording.clock_frequency_hz), streams=streams)
out = folder / "out.nxs"
made = {
    "recording": lambda: writer.write(long, out, truth={"delays_s": np.arange(3000.0)}),
    "capture": lambda: write_timed(source, out, ticks=ticks),
    "reference": lambda: reference_file.write_reference(recording.nonuniformity, folder / "out.npz"),
    "json": lambda: write_json({"values": list(range(5000))}, folder / "out.json"),
    "scene": lambda: write_scene(folder / "out.nxs"),
}[what]
made()
size = next(folder.glob("out*")).stat().st_size
whole, refused = 0, 0
for limit in sorted({*range(0, size, 997), *range(0, min(size, 4000), 61), size - 1}):
    for path in folder.glob("out*"):
        path.unlink()
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    try:
        made()
        whole += 1
    except ArchiveError as error:
        refused += 1
        assert "\\n" not in str(error) and len(str(error)) < 400, error
        assert "File too large" in str(error), error
        assert not list(folder.glob("out*")), (limit, list(folder.iterdir()))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
print(whole, refused)
"""


@pytest.mark.parametrize("what", ["recording", "capture", "reference", "json", "scene"])
def test_every_writer_says_so_and_leaves_nothing(hand_made: Callable[..., Path], tmp_path: Path, what: str) -> None:
    """Oracle: the system's refusal at dozens of places, and the exit status of the process."""
    source = hand_made()
    folder = tmp_path / "full"
    folder.mkdir()
    command = [sys.executable, "-c", _SWEEP, str(source), str(folder), what]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    whole, refused = map(int, done.stdout.split())
    assert (whole, refused >= 20) == (0, True)


_ADD = """
import resource, sys
from pathlib import Path
from irtiming.archive import reader, reference_file
from irtiming.errors import ArchiveError

path, bare = Path(sys.argv[1]), Path(sys.argv[2])
reference = reader.read(path).nonuniformity
before = bare.read_bytes()
for limit in range(0, len(before), 997):
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    try:
        reference_file.add_reference(reference, bare)
    except ArchiveError as error:
        assert "File too large" in str(error), error
        assert bare.read_bytes() == before
        assert sorted(one.name for one in bare.parent.iterdir()) == ["bare.nxs", "by-hand.nxs"]
    else:
        raise SystemExit("was added")
"""


def test_references_are_added_whole_or_not_at_all(hand_made: Callable[..., Path]) -> None:
    """Oracle: the bytes of the recording before, wherever the disk is full, and the exit status of the process."""

    def without(file: h5py.File) -> None:
        del file["entry/nonuniformity_reference"]

    whole, bare = hand_made(), hand_made(without, name="bare.nxs")
    command = [sys.executable, "-c", _ADD, str(whole), str(bare)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stderr) == (0, "")
