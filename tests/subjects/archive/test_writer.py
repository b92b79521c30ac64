"""`archive.writer`: what it writes, read by plain h5py and by the NeXus library; and that no half file remains."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from nexusformat.nexus import nxload

from irtiming.archive import reader, writer
from irtiming.archive.frame_stack import ArrayFrames
from irtiming.archive.json_file import plain, write_json
from irtiming.archive.writer import RecordingWriter
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Pixels
from irtiming.records.camera_settings import CameraSettings
from irtiming.records.recording import Recording


@pytest.fixture
def recording(hand_made: Callable[..., Path]) -> Recording:
    """The hand-made recording, as the reader gives it."""
    return reader.read(hand_made())


def test_the_nexus_library_finds_classes_units_and_the_plot(recording: Recording, tmp_path: Path) -> None:
    """Oracle: nexusformat's nxload, which knows nothing of this package."""
    path = tmp_path / "out.nxs"
    writer.write(recording, path, truth={"trigger_delay_s": 4e-4})
    root = nxload(path)
    with root.nxfile:
        entry = root["entry"]
        classes = {
            "instrument": "NXinstrument",
            "instrument/camera": "NXdetector",
            "instrument/chopper": "NXdisk_chopper",
            "instrument/trigger_generator": "NXcollection",
            "nonuniformity_reference": "NXcollection",
            "truth": "NXcollection",
        }
        assert {name: entry[name].nxclass for name in classes} == classes
        assert root.attrs["default"] == "entry"
        assert entry["instrument/camera/count_time"].attrs["units"] == "s"
        assert entry["instrument/trigger_generator/clock_frequency"].attrs["units"] == "Hz"
        assert entry["instrument/trigger_generator/control_slot"].attrs["units"] == "ticks"
        assert entry["truth/trigger_delay_s"].attrs["units"] == "s"
        plot = entry.plottable_data
        assert plot.nxsignal.shape == (20, 4, 6)
        assert plot.nxaxes[0].nxname == "frame_number"
        frames = np.concatenate([block for _, block in recording.frames.blocks()])
        np.testing.assert_array_equal(plot.nxsignal.nxvalue, frames)


def test_frames_are_stored_one_per_chunk_bitshuffled_and_checked(recording: Recording, tmp_path: Path) -> None:
    """Oracle: the filter numbers of HDF5: 32008 bitshuffle, 3 Fletcher's checksum."""
    writer.write(recording, tmp_path / "out.nxs")
    with h5py.File(tmp_path / "out.nxs") as file:
        dataset = file["entry/instrument/camera/data"]
        properties = dataset.id.get_create_plist()
        assert dataset.chunks == (1, 4, 6)
        assert [properties.get_filter(i)[0] for i in range(properties.get_nfilters())] == [32008, 3]


def test_settings_of_the_camera_come_back(recording: Recording, tmp_path: Path) -> None:
    """Oracle: what was written, and h5py for the unit; a recording without them says none."""
    settings = CameraSettings(
        gain_setting="high",
        internal_delay_set_s=5e-5,
        sensor_temperature_k=77.0,
        region_first_row=0,
        region_first_column=64,
    )
    writer.write(replace(recording, settings=settings), tmp_path / "out.nxs")
    assert reader.read(tmp_path / "out.nxs").settings == settings
    assert recording.settings == CameraSettings()
    with h5py.File(tmp_path / "out.nxs") as file:
        assert file["entry/instrument/camera/internal_delay_set"].attrs["units"] == "s"


def test_a_flipped_bit_in_a_frame_is_noticed(recording: Recording, tmp_path: Path) -> None:
    """Oracle: one bit of frame 7, changed on the disk."""
    path = tmp_path / "out.nxs"
    writer.write(recording, path)
    with h5py.File(path) as file:
        chunk = file["entry/instrument/camera/data"].id.get_chunk_info(7)
    content = bytearray(path.read_bytes())
    content[chunk.byte_offset + chunk.size // 2] ^= 4
    path.write_bytes(content)
    with pytest.raises(ArchiveError, match="cannot be read at frame 7 of 20"):
        list(reader.read(path).frames.blocks())


def test_the_same_recording_gives_the_same_bytes(recording: Recording, tmp_path: Path) -> None:
    """Oracle: a checksum identifies a simulation; no time of writing is stored."""
    for name in ("a.nxs", "b.nxs"):
        writer.write(recording, tmp_path / name, truth={"seed": 1})
    assert (tmp_path / "a.nxs").read_bytes() == (tmp_path / "b.nxs").read_bytes()


def test_nothing_has_the_final_name_until_all_is_written(recording: Recording, tmp_path: Path) -> None:
    """Oracle: a listing of the folder at each step."""
    path = tmp_path / "out.nxs"
    with RecordingWriter(path) as half:
        half.append(recording.frames.pick([0, 1]))
        assert not path.exists()
        assert list(tmp_path.glob("out.nxs.*.part"))
        half.append(recording.frames.pick(list(range(2, 20))))
        half.describe(replace(recording, nonuniformity=None))
    assert path.exists()
    assert not list(tmp_path.glob("*.part"))
    assert reader.read(path).frames.shape == (20, 4, 6)


def test_an_interrupted_recording_leaves_nothing(recording: Recording, tmp_path: Path) -> None:
    """Oracle: a listing of the folder after an exception between two blocks."""

    class Unplugged:
        shape = (20, 4, 6)

        def blocks(self) -> Iterator[tuple[int, Pixels]]:
            yield 0, np.ones((5, 4, 6), np.uint16)
            raise KeyboardInterrupt

        def pick(self, indices: list[int]) -> Pixels:
            raise NotImplementedError

    with pytest.raises(KeyboardInterrupt):
        writer.write(replace(recording, frames=Unplugged()), tmp_path / "out.nxs")
    assert list(tmp_path.glob("out*")) == []


def test_an_existing_file_is_kept_unless_told(recording: Recording, tmp_path: Path) -> None:
    """Oracle: the bytes of the file that was there."""
    path = tmp_path / "out.nxs"
    path.write_text("precious")
    with pytest.raises(ArchiveError, match=r"out\.nxs: exists already; choose another name"):
        writer.write(recording, path)
    assert path.read_text() == "precious"
    seen = []
    writer.write(recording, path, overwrite=True, progress=lambda done, total: seen.append((done, total)))
    assert reader.read(path).frames.shape == (20, 4, 6)
    assert seen[-1] == (20, 20)


@pytest.mark.parametrize(
    ("change", "fragment"),
    [
        ({"frame_number": np.arange(19)}, "frame_number has 19 entries for 20 frames"),
        ({"rotation_speed_hz": 0.0}, "rotation_speed = 0 Hz is out of range"),
        ({"camera_trigger_ticks": np.array([3, 2, 1])}, "camera_trigger goes back at entry 1"),
        ({"frames": ArrayFrames(np.ones((20, 4, 5), np.uint16))}, "has frames of 4 x 6 pixels"),
        ({"frames": ArrayFrames(np.ones((20, 4, 6)))}, "got a block of float64 (20, 4, 6); give uint16"),
        ({"frames": ArrayFrames(np.ones((0, 4, 6), np.uint16))}, "camera/data is missing"),
    ],
)
def test_what_the_reader_would_refuse_is_not_written(
    recording: Recording, tmp_path: Path, change: dict[str, object], fragment: str
) -> None:
    """Oracle: the reader's own checks; and no file is left."""
    with pytest.raises(ArchiveError) as caught:
        writer.write(replace(recording, **change), tmp_path / "out.nxs")
    assert fragment in str(caught.value)
    assert list(tmp_path.glob("out*")) == []


def test_misuse_is_told(recording: Recording, tmp_path: Path) -> None:
    """Oracle: each way of misusing the writer, once."""

    class Mixed:
        shape = (2, 4, 6)

        def blocks(self) -> Iterator[tuple[int, Pixels]]:
            yield 0, np.ones((1, 4, 6), np.uint16)
            yield 1, np.ones((1, 4, 7), np.uint16)

        def pick(self, indices: list[int]) -> Pixels:
            raise NotImplementedError

    path = tmp_path / "out.nxs"
    with pytest.raises(ArchiveError, match="the writer is closed"):
        RecordingWriter(path).append(np.ones((1, 4, 6), np.uint16))
    with pytest.raises(ArchiveError, match="describe"), RecordingWriter(path) as unfinished:
        unfinished.append(np.ones((1, 4, 6), np.uint16))
    with pytest.raises(ArchiveError, match="all must have one size"):
        writer.write(replace(recording, frames=Mixed()), path)
    assert recording.nonuniformity is not None
    bare = replace(recording.nonuniformity, low_frames=None)
    with pytest.raises(ArchiveError, match="cannot be written from its mean alone"):
        writer.write(replace(recording, nonuniformity=bare), path)
    with pytest.raises(ArchiveError, match="truth 'what' is object"):
        writer.write(recording, path, truth={"what": object()})
    with pytest.raises(ArchiveError, match=r"there is no folder .*none; make it first"):
        writer.write(recording, tmp_path / "none" / "out.nxs")
    with pytest.raises(ArchiveError, match="is a folder; name a file to write"):
        writer.write(recording, tmp_path)
    assert list(tmp_path.glob("out*")) == []


def test_results_become_strict_json(tmp_path: Path) -> None:
    """Oracle: the text, by hand; JSON has neither NaN nor numpy."""
    result = {
        "value": np.float64(1.5), "n": np.int64(3), "matrix": np.eye(2), "file": Path("a.nxs"),
        "nan": float("nan"), "list": (np.inf, None, True, "µs"),
    }  # fmt: skip
    write_json(result, tmp_path / "r.json")
    assert "".join((tmp_path / "r.json").read_text("utf-8").split()) == (
        '{"value":1.5,"n":3,"matrix":[[1.0,0.0],[0.0,1.0]],"file":"a.nxs","nan":null,"list":[null,null,true,"µs"]}'
    )
    with pytest.raises(ArchiveError, match="a result holds set"):
        plain({"a": {1, 2}})


def test_a_result_that_cannot_be_written_says_why(tmp_path: Path) -> None:
    """Oracle: a folder that does not exist; a folder in place of the file."""
    with pytest.raises(ArchiveError, match=r"none/r\.json: cannot be written: there is no folder .*make it first"):
        write_json({}, tmp_path / "none" / "r.json")
    with pytest.raises(ArchiveError, match="is a folder; name a file to write"):
        write_json({}, tmp_path)
    assert list(tmp_path.iterdir()) == []
