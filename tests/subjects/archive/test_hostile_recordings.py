"""Recordings that lie: refused in one line, in no time, with little memory, and without a look at any other file."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import h5py
import pytest
from hostile_recordings import LINES, TICKS, hostile
from live_run import append_edges, append_frames, head

from irtiming.archive import hdf5_bounds, hdf5_probe
from irtiming.archive.live.recording import LiveRecording
from irtiming.archive.live.recovery import recover
from irtiming.archive.live.unfinished import part_of
from irtiming.archive.reader import read
from irtiming.archive.verify import verify
from irtiming.errors import ArchiveError

SECRET = "the secret of another file, photon"
CODES = {
    "a thousand million texts": "beyond-bounds",
    "a long packed text": "beyond-bounds",
    "packed ticks": "beyond-bounds",
    "packed host times": "beyond-bounds",
    "a chunk of 2 GiB": "beyond-bounds",
    "packed twice": "beyond-bounds",
    "virtual ticks": "data-elsewhere",
    "virtual ticks of themselves": "data-elsewhere",
    "ticks stored in a pipe": "data-elsewhere",
    "text stored in another file": "data-elsewhere",
    "link to a pipe": "place-is-a-link",
    "link to another file": "place-is-a-link",
    "group in another file": "place-is-a-link",
    "soft link to itself": "place-is-a-link",
    "soft link by way of a pipe": "place-is-a-link",
    "2000 groups one in the other": "recording-sound",
    "a crowded group": "beyond-bounds",
    "frames of 7 GB": "beyond-bounds",
    "67 million frames": "beyond-bounds",
    "many attributes": "beyond-bounds",
    "a truth of 8 TiB": "beyond-bounds",
}
_VERIFY = """
import json, resource, sys, time
from irtiming.archive.verify import verify
for path in sys.argv[1:]:
    begun, before = time.monotonic(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    found = verify(path)[0]
    used_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    print(json.dumps([found.code, found.sentence(), time.monotonic() - begun, used_kb]), flush=True)
"""


def test_whatever_a_recording_says_the_reader_is_safe(hand_made: Callable[..., Path], tmp_path: Path) -> None:
    """Oracle: the code of each lie, by hand; another process's time and memory, as the system counts them."""
    secret, pipe = tmp_path / "secret.txt", tmp_path / "pipe"
    secret.write_text(SECRET)
    os.mkfifo(pipe)
    lies = hostile(secret, pipe)
    assert set(lies) == set(CODES)
    paths = [hand_made(change, name=f"{name}.nxs") for name, change in lies.items()]
    command = [sys.executable, "-c", _VERIFY, *map(str, paths)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    for name, line in zip(lies, done.stdout.splitlines(), strict=True):
        code, sentence, lasted_s, used_kb = json.loads(line)
        assert (name, code) == (name, CODES[name])
        assert lasted_s < 5, name
        assert used_kb < 400_000, name
        assert "secret" not in sentence.replace(str(secret), ""), name
        assert len(sentence) < 400, name


@pytest.mark.parametrize("name", ["link to a pipe", "packed host times", "virtual ticks"])
def test_the_reader_refuses_what_verify_refuses(hand_made: Callable[..., Path], tmp_path: Path, name: str) -> None:
    """Oracle: the same lies; one line that begins with the file."""
    os.mkfifo(tmp_path / "pipe")
    path = hand_made(hostile(tmp_path / "none", tmp_path / "pipe")[name])
    with pytest.raises(ArchiveError, match=rf"^{path}: /entry/") as raised:
        read(path)
    assert "\n" not in str(raised.value)


def test_a_pipe_is_no_recording(tmp_path: Path) -> None:
    """Oracle: opening it would wait for ever."""
    os.mkfifo(tmp_path / "run.nxs")
    with pytest.raises(ArchiveError, match="is no file but a device or a pipe; name a recording"):
        read(tmp_path / "run.nxs")


def test_a_packed_chunk_that_is_longer_than_it_may_be(hand_made: Callable[..., Path]) -> None:
    """Oracle: a stored chunk of 100 kB in the place of one of 3.2 kB, by hand."""

    def change(file: h5py.File) -> None:
        ticks = file[TICKS][()]
        del file[TICKS]
        made = file.create_dataset(TICKS, data=ticks, chunks=(401,), compression="gzip")
        made.id.write_direct_chunk((0,), b"x" * 100_000)

    found = verify(hand_made(change))[0]
    assert (found.code, found.what) == ("beyond-bounds", "has a chunk of 100000 bytes in the file")


def test_bounds_are_where_they_are_said_to_be(hand_made: Callable[..., Path], monkeypatch: pytest.MonkeyPatch) -> None:
    """Oracle: the number of entries of all lists of the recording, counted in plain h5py; one fewer is too few."""
    path = hand_made()
    with h5py.File(path) as file:
        n_entries = (
            sum(item.size for item in file[LINES].values() if item.ndim)
            + file["entry/instrument/camera/frame_number"].size
        )
    monkeypatch.setattr(hdf5_bounds, "MOST_ENTRIES", n_entries)
    read(path)
    monkeypatch.setattr(hdf5_bounds, "MOST_ENTRIES", n_entries - 1)
    with pytest.raises(ArchiveError, match=f"all lists together may have {n_entries - 1} entries"):
        read(path)


def test_an_interrupted_recording_with_groups_without_end_is_not_copied(tmp_path: Path) -> None:
    """Oracle: 100 000 groups one in the other, at which HDF5's copy would run out of stack."""
    path = tmp_path / "run.nxs"
    with suppress(ArchiveError), LiveRecording(path, head=head()) as live:  # it was never finished
        append_edges(live)
        append_frames(live, range(10))
    recover(part_of(path), tmp_path / "sound.nxs", keep=True)
    with h5py.File(part_of(path), "r+", libver="latest") as file:
        group = file["entry"].id
        for _ in range(100_000):
            group = h5py.h5g.create(group, b"d")
    with pytest.raises(ArchiveError, match=r"is one object too many; there may be 10000, 32 groups deep"):
        recover(part_of(path), tmp_path / "deep.nxs")


def test_a_file_that_turns_hdf5_in_a_circle(hand_made: Callable[..., Path], monkeypatch: pytest.MonkeyPatch) -> None:
    """Oracle: an entry of number 0 and length 0 in the heap of texts, behind which HDF5 2.0 looks for the next one for ever."""
    monkeypatch.setattr(hdf5_probe, "LONGEST_CPU_S", 1)
    path = hand_made()
    content = bytearray(path.read_bytes())
    heap = content.index(b"GCOL")
    content[heap + 16 : heap + 32] = bytes(16)
    path.write_bytes(content)
    assert verify(path)[0].code == "kills-hdf5"
    with pytest.raises(ArchiveError, match="makes the HDF5 library crash, or turn in a circle; the file is damaged"):
        read(path)
