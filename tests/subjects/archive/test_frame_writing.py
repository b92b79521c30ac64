"""Frames into files of other formats: what an independent reader finds there, and what is left after a failure."""

import errno

import h5py
import numpy as np
import pytest
import tifffile
from makers_files import FRAMES, WRITERS

from irtiming.archive.frames import writing
from irtiming.archive.frames.opening import open_frames
from irtiming.archive.frames.writing import write_frames
from irtiming.errors import ArchiveError

OUTPUTS = ("o.nxs", "o.tif", "o.npy", "o.hcc")


def _read_by_others(path):
    match path.suffix:
        case ".nxs":
            with h5py.File(path) as file:
                return file["entry/instrument/camera/data"][()]
        case ".tif":
            return tifffile.imread(path)
        case ".npy":
            return np.load(path)
        case _:
            from fasthcc import read_hcc

            return read_hcc(path)


@pytest.mark.parametrize("name", OUTPUTS)
def test_others_read_what_is_written(name, tmp_path):
    """Oracle: h5py, tifffile, NumPy and fasthcc."""
    WRITERS["a.ptw"](tmp_path / "a.ptw")
    write_frames(open_frames(tmp_path / "a.ptw"), tmp_path / name)
    assert np.array_equal(_read_by_others(tmp_path / name), FRAMES)
    assert not list(tmp_path.glob("*.part"))


@pytest.mark.parametrize("name", ["o.nxs", "o.tif", "o.npy"])
def test_what_is_known_goes_along(name, tmp_path):
    """Oracle: what the first file told."""
    WRITERS["a.ptw"](tmp_path / "a.ptw")
    first = open_frames(tmp_path / "a.ptw")
    lost = write_frames(first, tmp_path / name)
    wanted, found = first.facts, open_frames(tmp_path / name).facts
    for field in ("camera", "start_time", "integration_time_s", "frame_period_s", "time_scale", "bit_depth", "unit"):
        assert getattr(found, field) == getattr(wanted, field), field
    assert wanted.times_s is not None
    assert found.times_s is not None
    assert np.abs(found.times_s - wanted.times_s).max() < 1e-9
    assert lost == (["more"] if name == "o.nxs" else [])


def test_hcc_keeps_dates_numbers_and_integration_times(tmp_path):
    """Oracle: the header as fasthcc reads it."""
    from fasthcc import read_hcc

    WRITERS["a.hcc"](tmp_path / "a.hcc")
    lost = write_frames(open_frames(tmp_path / "a.hcc"), tmp_path / "b.hcc")
    _, headers = read_hcc(tmp_path / "b.hcc", metadata=True)
    assert [one["POSIXTime"] for one in headers] == [1_700_000_000 + i for i in range(5)]
    assert {one["SubSecondTime"] for one in headers} == {2_500_000}
    assert headers[0]["ExposureTime"] == 250.0
    assert headers[3]["FrameID"] == 13
    assert lost == ["camera"]


def test_triggers_survive_a_way_through_tiff(hand_made, tmp_path):
    """Oracle: the ticks of the recording, which are integers."""
    recording = hand_made()
    write_frames(open_frames(recording), tmp_path / "a.tif")
    write_frames(open_frames(tmp_path / "a.tif"), tmp_path / "b.nxs")
    place = "entry/instrument/trigger_generator/camera_trigger"
    with h5py.File(recording) as before, h5py.File(tmp_path / "b.nxs") as after:
        assert np.array_equal(before[place], after[place])


def test_temperatures_go_along_but_not_into_hcc(tmp_path):
    """Oracle: the values read from the first file; HCC holds counts only."""
    WRITERS["a.irb"](tmp_path / "a.irb")
    source = open_frames(tmp_path / "a.irb")
    for name in ("o.nxs", "o.tif", "o.npy"):
        write_frames(source, tmp_path / name)
        again = open_frames(tmp_path / name)
        assert again.facts.unit == "K"
        assert np.array_equal(again.pick([0, 1]), source.pick([0, 1]))
    with pytest.raises(ArchiveError, match=r"o\.hcc: HCC holds counts"):
        write_frames(source, tmp_path / "o.hcc")


class _Failing:
    """Frames of which the second block cannot be had."""

    def __init__(self, source, error):
        self.facts, self.shape, self.pick = source.facts, source.shape, source.pick
        self._error = error

    def blocks(self):
        yield 0, FRAMES[:2]
        raise self._error


@pytest.mark.parametrize("name", OUTPUTS)
@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()])
def test_nothing_is_left_after_a_failure(name, error, tmp_path):
    """Oracle: the folder."""
    WRITERS["a.ptw"](tmp_path / "a.ptw")
    source = _Failing(open_frames(tmp_path / "a.ptw"), error)
    with pytest.raises((ArchiveError, KeyboardInterrupt)):
        write_frames(source, tmp_path / name)
    assert [one.name for one in tmp_path.iterdir()] == ["a.ptw"]


def test_a_numpy_file_that_is_stopped_at_the_last_moment_leaves_no_facts_alone(tmp_path, monkeypatch):
    """Oracle: an empty folder; facts without frames would be in the way of the next try."""

    def stopped(_):
        raise KeyboardInterrupt

    WRITERS["a.ptw"](tmp_path / "a.ptw")
    monkeypatch.setattr(writing, "bring_to_disk", stopped)
    (tmp_path / "out").mkdir()
    with pytest.raises(KeyboardInterrupt):
        write_frames(open_frames(tmp_path / "a.ptw"), tmp_path / "out" / "b.npy")
    assert list((tmp_path / "out").iterdir()) == []
    monkeypatch.undo()
    write_frames(open_frames(tmp_path / "a.ptw"), tmp_path / "out" / "b.npy")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["b.npy", "b.npy.json"]


def test_nothing_is_overwritten_and_the_ending_says_the_format(tmp_path):
    """Oracle: the files that were there."""
    WRITERS["a.ptw"](tmp_path / "a.ptw")
    source = open_frames(tmp_path / "a.ptw")
    for name in ("o.npy", "p.npy.json"):
        (tmp_path / name).write_text("mine")
    for name, says in (
        ("o.npy", "exists already"),
        ("p.npy", "exists already"),
        ("o.ptw", "no format that is written"),
    ):
        with pytest.raises(ArchiveError, match=says):
            write_frames(source, tmp_path / name)
    assert (tmp_path / "o.npy").read_text() == "mine"


def test_memory_stays_flat(tmp_path):
    """Oracle: the largest block that is asked for, of a stack of 200 MB that takes no room on the disk."""
    shape = (400, 512, 512)
    stack = np.lib.format.open_memmap(tmp_path / "a.npy", mode="w+", dtype=np.uint16, shape=shape)
    del stack
    source = open_frames(tmp_path / "a.npy")
    assert max(block.nbytes for _, block in source.blocks()) <= 32 * 2**20
