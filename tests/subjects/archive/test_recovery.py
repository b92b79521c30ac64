"""`archive.recovery` and `irtiming recover`: finished recordings of interrupted ones."""

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
import typer
from live_run import append_edges, append_frames, frame, head, pixels
from typer.testing import CliRunner

from irtiming.archive import frame_status, reader
from irtiming.archive.live.recording import LiveRecording
from irtiming.archive.live.recovery import recover
from irtiming.archive.live.so_far import read_so_far
from irtiming.archive.verify import verify
from irtiming.cli.recover_command import recover as recover_command
from irtiming.errors import ArchiveError

_ROOT = Path(__file__).resolve().parents[3]

_DIES = """
import os, signal, sys
from live_run import LiveRecording, append_edges, append_frames, frame, head
with LiveRecording(sys.argv[1], head=head()) as live:
    append_edges(live)
    append_frames(live, range(int(sys.argv[2])))
    for index in range(int(sys.argv[2]), int(sys.argv[3])):
        live.append_frame(frame(index), frame_number=index)
    os.kill(os.getpid(), signal.SIGKILL)
"""


def _interrupted(folder: Path, *, timed: int = 20, untimed: int = 0) -> Path:
    """File of a process that was killed: so many frames with their triggers, then some without."""
    command = [sys.executable, "-c", _DIES, str(folder / "run.nxs"), str(timed), str(timed + untimed)]
    done = subprocess.run(command, cwd=Path(__file__).parent, timeout=60, check=False)
    assert done.returncode == -9
    return folder / "run.nxs.part"


def test_whatever_a_killed_program_said_to_be_written_is_there(tmp_path: Path) -> None:
    """Oracle: the killed process itself, which reports each frame through a pipe when it is written; ten kills."""
    spec = importlib.util.spec_from_file_location("killed", _ROOT / "benchmarks" / "killed_recordings.py")
    assert spec is not None
    assert spec.loader is not None
    killed = importlib.util.module_from_spec(spec)
    sys.modules["killed"] = killed
    spec.loader.exec_module(killed)
    found = []
    for kill in range(10):
        folder = tmp_path / str(kill)
        folder.mkdir()
        found.append(killed.kill_once(folder, 1000 + kill))
    assert [left for left in found if not left.is_sound or left.reported - left.there > 1] == []
    assert sum(left.state == "recovered" for left in found) > 3


def test_a_kill_within_a_write_tears_no_index(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Oracle: HDF5's own log of what it writes: a kill ends a write between two pages, and no header or index spans two."""
    log, open_file = tmp_path / "writes.log", h5py.h5f.open

    def logged(name: bytes, flags: int, fapl: h5py.h5p.PropFAID) -> h5py.h5f.FileID:
        if flags & h5py.h5f.ACC_SWMR_WRITE:
            fapl.set_fapl_log(os.fsencode(log), h5py.h5fd.LOG_LOC_WRITE, 0)
        return open_file(name, flags, fapl=fapl)

    monkeypatch.setattr(h5py.h5f, "open", logged)
    with LiveRecording(tmp_path / "run.nxs", head=head()) as live:
        append_edges(live)
        append_frames(live, range(300))
        live.finish()
    lines = log.read_text().splitlines()
    written = [re.match(r" *(\d+)- *(\d+) .*\((H5FD_MEM_\w+)\) Written", line) for line in lines]
    places = [(int(found[1]), int(found[2])) for found in written if found and found[3] != "H5FD_MEM_DRAW"]
    assert len(places) > 300
    assert [place for place in places if place[0] // 4096 != place[1] // 4096] == []


def test_an_interrupted_recording_becomes_a_finished_one(tmp_path: Path) -> None:
    """Oracle: frames and numbers that were handed over; of the last two, no trigger came."""
    part = _interrupted(tmp_path, untimed=2)
    before = part.read_bytes()
    (finding,) = verify(part)
    told = "has 22 frames for 20 triggers, the last 627 ms after the first; the program that wrote it was stopped"
    assert told in finding.sentence()
    assert finding.severity == "error"
    assert read_so_far(part).frames.shape[0] == 20
    finished = recover(part, keep=True, trust=True)
    assert part.read_bytes() == before
    recording = reader.read(finished)
    assert recording.frame_number.tolist() == list(range(20))
    np.testing.assert_array_equal(recording.frames.pick(list(range(20))), [pixels(k) for k in range(20)])
    assert recording.lost_after_ticks is None  # nobody said that nothing was lost
    assert recording.ending == "interrupted: the program that recorded it was stopped before its end"
    assert reader.read_acquisition(finished)["chopper_blade"] == "MC1F2"
    with h5py.File(finished) as file:
        assert file["entry/instrument/camera/frame_status"][()].tolist() == [0] * 20 + [3] * 2
        np.testing.assert_array_equal(file["entry/instrument/camera/data"][21], pixels(21))


def test_what_a_killed_program_left_is_not_analysed_unless_somebody_trusts_it(tmp_path: Path) -> None:
    """Oracle: the rule itself: only the end of a run proves which trigger made the first frame."""
    finished = recover(_interrupted(tmp_path))
    with pytest.raises(ArchiveError, match="ending says: not trusted: interrupted.*record it again"):
        reader.read(finished)
    assert "error" in [finding.severity for finding in verify(finished)]


@pytest.mark.parametrize("share", [0.95, 0.8, 0.6])
def test_of_a_file_that_is_cut_off_what_is_there_is_made_a_recording(tmp_path: Path, share: float) -> None:
    """Oracle: frames that were handed over; beyond the cut there is neither a frame, nor all of the index that leads to it."""
    part = _interrupted(tmp_path, timed=300)
    part.write_bytes(part.read_bytes()[: int(share * part.stat().st_size)])
    with h5py.File(recover(part, trust=True)) as file:
        frames, status = file["entry/instrument/camera/data"], file["entry/instrument/camera/frame_status"][()]
        there = np.flatnonzero(status == 0)
        assert 50 < there.size < 300 == len(status)
        assert set(status.tolist()) == {0, frame_status.DAMAGED}
        for k in there:
            np.testing.assert_array_equal(frames[k], pixels(k))
        assert file["entry/data/data"] == frames
        for name in ("control_slot", "application_slot", "camera_trigger"):
            assert np.all(np.diff(file[f"entry/instrument/trigger_generator/{name}"][()]) > 0)


def test_what_was_made_without_trust_can_be_trusted_later(tmp_path: Path) -> None:
    """Oracle: the same recording with trust at once; the file that says so tells how."""
    part = _interrupted(tmp_path)
    at_once = reader.read(recover(part, tmp_path / "at-once.nxs", keep=True, trust=True))
    finished = recover(part)
    with pytest.raises(ArchiveError, match="record it again, or, where no trigger .* irtiming recover --trust"):
        reader.read(finished)
    later = reader.read(recover(finished, tmp_path / "later.nxs", trust=True))
    assert later.ending == at_once.ending
    np.testing.assert_array_equal(later.camera_trigger_ticks, at_once.camera_trigger_ticks)
    np.testing.assert_array_equal(later.frame_number, at_once.frame_number)


def test_a_frame_that_the_disk_lost_is_marked(tmp_path: Path) -> None:
    """Oracle: one bit of frame 7, changed in the interrupted file."""
    part = _interrupted(tmp_path)
    with h5py.File(part, swmr=True) as file:
        chunk = file["entry/instrument/camera/data"].id.get_chunk_info(7)
    content = bytearray(part.read_bytes())
    content[chunk.byte_offset + chunk.size // 2] ^= 4
    part.write_bytes(content)
    recording = reader.read(recover(part, trust=True))
    assert recording.frame_number.tolist() == [k for k in range(20) if k != 7]
    assert "1 damaged" in " ".join(finding.what for finding in recording.findings)
    np.testing.assert_array_equal(recording.frames.pick([6, 7]), [pixels(6), pixels(8)])


def test_the_command_says_what_is_there_and_removes_the_rest(tmp_path: Path) -> None:
    """Oracle: the folder afterwards, and the numbers of frames and triggers."""
    part = _interrupted(tmp_path)
    app = typer.Typer()
    app.command()(recover_command)
    result = CliRunner().invoke(app, [str(part), "--out", str(tmp_path / "other.nxs"), "--trust"])
    assert result.exit_code == 0, result.output
    assert "20 frames of" in result.output
    assert "for 20 triggers" in result.output
    assert "warning: /entry/ending says: interrupted" in result.output
    assert [found.name for found in tmp_path.iterdir()] == ["other.nxs"]


@pytest.mark.parametrize(
    ("prepare", "words"),
    [
        (lambda part: part.with_name("run.nxs").write_text("mine"), "exists already; choose another name"),
        (lambda part: part.write_bytes(part.read_bytes()[:3000]), "is not finished|cannot be"),
        (lambda part: part.write_text("no"), "is not an HDF5 file"),
        (lambda part: part.unlink(), "does not exist"),
    ],
)
def test_what_cannot_be_recovered_is_told_in_one_line_and_left_alone(tmp_path: Path, prepare, words: str) -> None:
    """Oracle: one reason each, made by hand."""
    part = _interrupted(tmp_path)
    prepare(part)
    before = {found.name: found.read_bytes() for found in tmp_path.iterdir()}
    with pytest.raises(ArchiveError, match=words) as raised:
        recover(part)
    assert "\n" not in str(raised.value)
    assert {found.name: found.read_bytes() for found in tmp_path.iterdir()} == before


def test_a_recording_with_too_little_in_it_stays_as_it_is(tmp_path: Path) -> None:
    """Oracle: no frame at all, and a file without the suffix."""
    part = _interrupted(tmp_path, timed=0)
    with pytest.raises(ArchiveError, match="has 0 frames for 0 triggers; delete it and record again"):
        recover(part)
    odd = part.rename(tmp_path / "odd.h5")
    with pytest.raises(ArchiveError, match="say which file to make"):
        recover(odd)
    with pytest.raises(ArchiveError, match="is not finished: it is being written, or the program"):
        reader.read(odd)
    assert [found.name for found in tmp_path.iterdir()] == ["odd.h5"]


def test_a_recording_in_progress_is_not_touched(tmp_path: Path) -> None:
    """Oracle: this process is still writing it, and finishes it afterwards."""
    with LiveRecording(tmp_path / "run.nxs", head=head()) as live:
        append_edges(live)
        append_frames(live, range(9))
        with pytest.raises(ArchiveError, match="a program is at work on it"):
            recover(live.part)
        live.append_ticks("camera_trigger", np.array([10**9]))
        live.append_frame(frame(9), frame_number=9)
        live.finish()
    assert reader.read(tmp_path / "run.nxs").frames.shape[0] == 10
    assert os.listdir(tmp_path) == ["run.nxs"]
