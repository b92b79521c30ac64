"""`archive.live_recording` and `archive.live_reader`: what is in the file, at any moment and at the end."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from live_run import CLOCK_HZ, COLUMNS, PERIOD, ROWS, START, TURN, append_edges, append_frames, frame, head, pixels

from irtiming.archive import reader, writer
from irtiming.archive.frame_stack import ArrayFrames
from irtiming.archive.live.recording import LiveRecording
from irtiming.archive.live.recovery import recover
from irtiming.archive.live.so_far import read_so_far
from irtiming.archive.live.unfinished import part_of
from irtiming.archive.verify import verify
from irtiming.errors import ArchiveError, InstrumentSilent
from irtiming.records.recording import NonuniformityReference
from irtiming.records.timestamps import Timestamps


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Where the recording shall be."""
    return tmp_path / "run.nxs"


def test_a_complete_run_is_read_as_it_was_recorded(path: Path) -> None:
    """Oracle: the frames, ticks and settings that were handed over."""
    with LiveRecording(path, head=head()) as live:
        append_edges(live)
        append_frames(live, range(20))
        assert live.finish() == path
    recording = reader.read(path)
    assert not live.part.exists()
    np.testing.assert_array_equal(recording.frames.pick([0, 7, 19]), [pixels(0), pixels(7), pixels(19)])
    np.testing.assert_array_equal(recording.camera_trigger_ticks, START + PERIOD * np.arange(20))
    np.testing.assert_array_equal(recording.frame_timestamp_ticks, 33_000_000 * np.arange(20) + 5)
    np.testing.assert_allclose(recording.frame_host_time_s, 100.0 + 0.033 * np.arange(20))
    assert recording.frame_id.tolist() == recording.frame_number.tolist() == list(range(20))
    assert (recording.ending, recording.findings, recording.lost_after_ticks.size) == ("complete", (), 0)
    assert recording.application_edge_ticks is None  # nothing came on that line
    assert recording.camera == head().camera
    assert recording.rotation_speed_hz == CLOCK_HZ / TURN
    assert (recording.trigger_delay_time_set_s, recording.integration_time_s) == (0.025, 250e-6)
    assert (recording.blackbody_temperature_k, recording.timestamp_frequency_hz) == (303.15, 1e9)
    assert recording.program_version.startswith("irtiming ")
    told = reader.read_acquisition(path)
    assert (told["chopper_blade"], told["run_repeats"], told["camera_pixel_format"]) == ("MC1F2", 2, "Mono14")


@pytest.mark.parametrize(("told_s", "expected_s"), [(500e-6, 500e-6), (None, 250e-6)])
def test_the_integration_time_is_what_the_camera_says(path: Path, told_s: float | None, expected_s: float) -> None:
    """Oracle: by hand; the camera's own number before that of the plan, which stands where the camera tells none."""
    given = head(setup=replace(head().setup, integration_time_s=told_s), integration_time_s=250e-6)
    with LiveRecording(path, head=given) as live:
        append_edges(live)
        append_frames(live, range(20))
        live.finish()
    assert reader.read(path).integration_time_s == expected_s


def test_the_finished_file_is_laid_out_like_any_recording(path: Path, tmp_path: Path) -> None:
    """Oracle: the other writer's file of the same recording, field by field, and HDF5's own list of filters."""
    reference = NonuniformityReference(
        low_dn=np.zeros((ROWS, COLUMNS)), high_dn=np.zeros((ROWS, COLUMNS)), low_noise_dn=np.zeros((ROWS, COLUMNS)),
        high_noise_dn=np.zeros((ROWS, COLUMNS)), n_frames=3, low_temperature_k=290.0, high_temperature_k=305.0,
        low_frames=ArrayFrames(np.stack([pixels(k) // 2 for k in range(3)])),
        high_frames=ArrayFrames(np.stack([pixels(k) for k in range(3)])),
    )  # fmt: skip
    with LiveRecording(path, head=head(nonuniformity=reference)) as live:
        append_edges(live)
        append_frames(live, range(20))
        live.finish()
    writer.write(reader.read(path), tmp_path / "copy.nxs")
    with h5py.File(path) as one, h5py.File(tmp_path / "copy.nxs") as other:
        names: list[str] = []
        other.visit(names.append)
        for name in names:
            assert dict(one[name].attrs).keys() == dict(other[name].attrs).keys(), name
            if isinstance(other[name], h5py.Dataset):
                np.testing.assert_array_equal(one[name][()], other[name][()])
        assert dict(one.attrs) == dict(other.attrs)
        properties = one["entry/instrument/camera/data"].id.get_create_plist()
        assert [properties.get_filter(i)[0] for i in range(properties.get_nfilters())] == [32008, 3]
    assert reader.read(path).nonuniformity.high_temperature_k == 305.0


def test_frames_that_are_not_whole_stay_in_the_file_and_are_left_out_when_read(path: Path) -> None:
    """Oracle: frame 3 lost a packet, of frame 5 nothing came, trigger 9 was not stamped: by hand."""
    with LiveRecording(path, head=head()) as live:
        append_edges(live)
        append_frames(live, range(3))
        live.append_ticks("camera_trigger", START + PERIOD * np.arange(3, 9))
        live.append_frame(frame(3, missing=2), frame_number=3)
        live.append_frame(frame(4), frame_number=4)
        live.append_blank(frame_number=5, frame_id=5, host_time_s=100.2)
        for index in range(6, 10):
            live.append_frame(frame(index), frame_number=index)
        live.finish()
    recording = reader.read(path)
    assert recording.frame_number.tolist() == recording.frame_id.tolist() == [0, 1, 2, 4, 6, 7, 8]
    blocks = np.concatenate([block.copy() for _, block in recording.frames.blocks()])
    np.testing.assert_array_equal(blocks, [pixels(k) for k in (0, 1, 2, 4, 6, 7, 8)])
    np.testing.assert_array_equal(recording.frames.pick([6, 3]), [pixels(8), pixels(4)])
    told = "lists among 10 frames 1 damaged, 1 blank, 1 without a timestamp of their trigger; they are left out"
    assert [told in finding.sentence() for finding in recording.findings] == [True]
    with h5py.File(path) as file:
        camera = file["entry/instrument/camera"]
        assert camera["frame_status"][()].tolist() == [0, 0, 0, 1, 0, 2, 0, 0, 0, 3]
        np.testing.assert_array_equal(camera["data"][[3, 5, 9]], [pixels(3), 0 * pixels(5), pixels(9)])
    severities = [finding.severity for finding in verify(path)]
    assert severities[0] == "ok"
    assert "error" not in severities


def test_numbers_that_turn_out_wrong_are_corrected_at_the_end(path: Path) -> None:
    """Oracle: the first trigger made no frame; each frame belongs to the next trigger."""
    with LiveRecording(path, head=head()) as live:
        append_edges(live)
        live.append_ticks("camera_trigger", START + PERIOD * np.arange(10))
        for index in range(9):
            live.append_frame(frame(index), frame_number=index)
        live.finish(frame_number=np.arange(1, 10))
    assert reader.read(path).frame_number.tolist() == list(range(1, 10))


def test_it_can_be_read_while_it_is_written(path: Path) -> None:
    """Oracle: what was handed over until then; a recording that was read stays as it is, even when the file is finished."""
    with LiveRecording(path, head=head()) as live:
        append_edges(live)
        with pytest.raises(ArchiveError, match="camera_trigger has 0 entries"):
            read_so_far(path)
        append_frames(live, range(10))
        live.append_frame(frame(10), frame_number=10)  # its trigger is not there yet
        early = read_so_far(path)
        assert (early.frame_number.tolist(), early.ending, early.findings) == (list(range(10)), "", ())
        append_frames(live, range(11, 12))
        np.testing.assert_array_equal(np.concatenate([b for _, b in early.frames.blocks()])[9], pixels(9))
        assert read_so_far(live.part).frames.shape == (11, ROWS, COLUMNS)
        live.finish()
    np.testing.assert_array_equal(early.frames.pick([9])[0], pixels(9))
    assert read_so_far(path).ending == "complete"


def test_what_is_in_an_unfinished_file_is_told(path: Path) -> None:
    """Oracle: 10 frames, 10 triggers, the last nine camera periods after the first (297 ms)."""
    with LiveRecording(path, head=head()) as live:
        append_edges(live)
        append_frames(live, range(10))
        words = "has 10 frames for 10 triggers, the last 297 ms after the first so far; a program is at work on it"
        with pytest.raises(ArchiveError, match=words):
            reader.read(live.part)
        (finding,) = verify(live.part)
        assert (finding.severity, words in finding.sentence()) == ("error", True)
        live.finish()


@pytest.mark.parametrize(
    ("error", "ending"),
    [
        (KeyboardInterrupt(), "stopped by Ctrl-C"),
        (InstrumentSilent("the camera does not answer"), "the camera does not answer"),
        (ValueError("no"), "ValueError: no"),
    ],
)
def test_whatever_ends_the_block_the_file_is_finished_and_says_so(
    path: Path, error: BaseException, ending: str
) -> None:
    """Oracle: the exception that went through."""
    with pytest.raises(type(error)) as raised, LiveRecording(path, head=head()) as live:  # noqa: PT012
        append_edges(live)
        append_frames(live, range(10))
        raise error
    assert raised.value.__notes__ == [f"what came until then is in {path}"]
    recording = reader.read(path)
    assert (recording.ending, recording.frames.shape[0]) == (ending, 10)
    assert f"/entry/ending says: {ending}" in recording.findings[0].sentence()


def test_a_run_that_ends_too_early_stays_unfinished_and_an_empty_one_leaves_nothing(path: Path) -> None:
    """Oracle: the reader needs two edges of the wheel."""
    with pytest.raises(ArchiveError, match="application_slot has 0 entries.* 2 frames are in it"):  # noqa: PT012, SIM117
        with LiveRecording(path, head=head()) as live:
            live.append_ticks("control_slot", np.array([START, START + TURN // 100]))
            append_frames(live, range(2))
            live.finish("lock lost")
    assert live.part.exists()
    with pytest.raises(ArchiveError, match="2 frames for 2 triggers.*irtiming recover"):
        reader.read(live.part)
    with pytest.raises(ArchiveError, match="exists already: a recording that was interrupted"):
        LiveRecording(path, head=head()).__enter__()
    other = path.with_name("other.nxs")
    with pytest.raises(KeyboardInterrupt) as raised, LiveRecording(other, head=head()):
        raise KeyboardInterrupt
    assert "nothing was recorded, and no file is left" in raised.value.__notes__[0]
    assert [found.name for found in path.parent.iterdir()] == ["run.nxs.part"]


def test_no_file_is_ever_overwritten(path: Path) -> None:
    """Oracle: a file of that name, before the run and made during it."""
    path.write_text("mine")
    with pytest.raises(ArchiveError, match="exists already; choose another name"):
        LiveRecording(path, head=head()).__enter__()
    path.unlink()
    with pytest.raises(ArchiveError, match="exists already"), LiveRecording(path, head=head()) as live:  # noqa: PT012
        append_edges(live)
        append_frames(live, range(3))
        path.write_text("mine")
        live.finish()
    assert path.read_text() == "mine"
    assert live.part.exists()


def test_finish_must_be_called(path: Path) -> None:
    """Oracle: a block that ends as if all were well, without the word that it is."""
    with pytest.raises(ArchiveError, match=r"finish\(\) was never called"), LiveRecording(path, head=head()) as live:
        append_frames(live, range(2))
    assert live.part.exists()


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (lambda live: live.append_frame(frame(3), frame_number=4), "got trigger 4 after 4"),
        (
            lambda live: live.append_frame(replace(frame(5), pixels=pixels(5)[:4]), frame_number=5),
            r"got a frame of uint16 \(4, 16\); give uint16 \(12, 16\)",
        ),
        (lambda live: live.append_ticks("control_slot", np.array([3])), "got ticks that go back by"),
        (lambda live: live.append_ticks("camera_trigger", np.array([START + 4 * PERIOD])), "repeat"),
        (lambda live: live.append_ticks("lamp", np.array([3])), "no stream 'lamp'"),
    ],
)
def test_what_would_spoil_the_file_is_refused_and_the_rest_is_kept(path: Path, fault, words: str) -> None:
    """Oracle: one wrong call after five right ones."""
    with LiveRecording(path, head=head()) as live:
        append_edges(live)
        append_frames(live, range(5))
        with pytest.raises(ArchiveError, match=words):
            fault(live)
        live.finish()
    assert reader.read(path).frames.shape[0] == 5


def test_the_rest_of_the_timestamps_is_taken_from_those_of_the_whole_run(path: Path) -> None:
    """Oracle: ticks of the whole run, of which some were written before; and the same with one tick moved."""
    slots = START - TURN // 2 + TURN // 100 * np.arange(301)
    none = np.empty(0, np.int64)
    whole = Timestamps(
        clock_frequency_hz=CLOCK_HZ, camera_trigger_ticks=START + PERIOD * np.arange(12),
        camera_trigger_delayed_ticks=START + PERIOD * np.arange(12) + 1_228_800, control_slot_ticks=slots,
        application_slot_ticks=slots[::50] + 5, application_edge_ticks=slots[::25] + 5, camera_input_ticks=none,
        spare_ticks=none, lost_after_ticks=none,
    )  # fmt: skip
    with LiveRecording(path, head=head()) as live:
        append_frames(live, range(10))
        live.append_ticks("control_slot", slots[:77])
        live.append_rest_of(whole)
        live.append_rest_of(whole)
        moved = replace(whole, control_slot_ticks=slots + (np.arange(301) == 3))
        with pytest.raises(ArchiveError, match="has 301 ticks, the whole run has 301, of which 1 are others"):
            live.append_rest_of(moved)
        live.finish()
    recording = reader.read(path)
    np.testing.assert_array_equal(recording.control_slot_ticks, slots)
    np.testing.assert_array_equal(recording.application_edge_ticks, slots[::25] + 5)
    np.testing.assert_array_equal(recording.camera_trigger_delayed_ticks, whole.camera_trigger_delayed_ticks)
    assert (recording.camera_trigger_ticks.size, recording.camera_input_ticks.size) == (12, 0)


def test_a_disk_that_fills_up_ends_the_run_and_loses_nothing(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Oracle: the system's word that 15 MiB are left, after ten frames."""
    with pytest.raises(ArchiveError, match="the disk is full: 15 MiB are left") as raised:  # noqa: PT012, SIM117
        with LiveRecording(path, head=head()) as live:
            append_edges(live)
            append_frames(live, range(10))
            monkeypatch.setattr(os, "statvfs", lambda _: SimpleNamespace(f_bavail=15, f_frsize=2**20))
            append_frames(live, range(10, 20))
    assert f"what came until then is in {path}" in raised.value.__notes__
    recording = reader.read(path)
    assert (recording.frames.shape[0], recording.camera_trigger_ticks.size) == (10, 11)
    assert "the disk is full" in recording.ending


_UNTIL_THE_LIMIT = """
import resource, sys
from live_run import LiveRecording, append_edges, append_frames, head
resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, resource.RLIM_INFINITY))
with LiveRecording(sys.argv[1], head=head()) as live:
    append_edges(live)
    for index in range(1000):
        append_frames(live, [index])
        print(index, flush=True)
"""


def test_a_write_that_fails_loses_nothing_that_was_written(path: Path) -> None:
    """Oracle: what another process said of itself, which may not let a file grow beyond 200 kB (RLIMIT_FSIZE)."""
    command = [sys.executable, "-c", _UNTIL_THE_LIMIT, str(path)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=Path(__file__).parent, timeout=60, check=False)
    assert done.returncode == 1, "an exception, and no crash of the HDF5 library when the program ends"
    assert "is the disk full?" in done.stderr
    assert "finish it with irtiming recover" in done.stderr
    said = done.stdout.split()
    assert len(said) > 100
    with pytest.raises(ArchiveError, match=f"it has {len(said)} frames for .* irtiming recover {part_of(path)}"):
        reader.read(part_of(path))
    recording = reader.read(recover(part_of(path)))
    np.testing.assert_array_equal(recording.frames.pick(list(range(len(said)))), [pixels(int(k)) for k in said])
    assert recording.ending.endswith("could not be written (File too large)")
