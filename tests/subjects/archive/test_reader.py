"""`archive.reader` on files written with plain h5py, sound and spoilt."""

import json
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import h5py
import numpy as np
import pytest

from irtiming.archive import layout, reader
from irtiming.archive.checksum import sha256_of
from irtiming.archive.frame_stack import ArrayFrames, FileFrames
from irtiming.errors import ArchiveError

CAMERA = "entry/instrument/camera"
CLOCK = "entry/instrument/trigger_generator"
REFERENCE = "entry/nonuniformity_reference"
SPEED = "entry/instrument/chopper/rotation_speed"


def _put(path: str, value: object, **attributes: object) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        if path in file:
            del file[path]
        file[path] = value
        if attributes:
            file[path].attrs.update(attributes)

    return change


def _take(*paths: str) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        for path in paths:
            del file[path]

    return change


def _frames_half_written(file: h5py.File) -> None:
    del file[f"{CAMERA}/data"]
    frames = file.create_dataset(f"{CAMERA}/data", (20, 4, 6), "u2", chunks=(1, 4, 6))
    frames[:12] = 1


def _unknown_filter(file: h5py.File) -> None:
    del file[f"{CAMERA}/data"]
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_chunk((1, 4, 6))
    properties.set_filter(31999, h5py.h5z.FLAG_OPTIONAL, ())
    space = h5py.h5s.create_simple((20, 4, 6))
    name = f"{CAMERA}/data".encode()
    dataset = h5py.h5d.create(file.id, name, h5py.h5t.NATIVE_UINT16, space, properties)
    for index in range(20):
        dataset.write_direct_chunk((index, 0, 0), b"\0" * 48, 0)


def _rename(old: str, new: str) -> Callable[[h5py.File], None]:
    return lambda file: file.move(old, new)


def test_a_sound_file_gives_the_values_written_by_hand(hand_made: Callable[..., Path]) -> None:
    """Oracle: the same values, read back with plain h5py."""
    path = hand_made()
    recording = reader.read(path)
    with h5py.File(path) as file:
        frames = file[f"{CAMERA}/data"][()]
        low = file[f"{REFERENCE}/low"][()].astype(float)
        triggers = file[f"{CLOCK}/camera_trigger"][()]
    assert recording.name == "by-hand"
    assert (recording.camera_type, recording.readout_mode) == ("photon", "snapshot")
    assert recording.integration_time_s == 250e-6
    assert recording.trigger_delay_time_set_s == 0.025
    assert recording.bit_depth == 14
    assert recording.clock_frequency_hz == 49_152_000.0
    assert (recording.camera_period_ticks, recording.wheel_period_ticks) == (1_622_016, 16_384_000)
    assert recording.blackbody_temperature_k == 303.15
    assert recording.findings == ()
    assert recording.sha256 == sha256_of(path)
    np.testing.assert_array_equal(recording.camera_trigger_ticks, triggers)
    assert not recording.camera_trigger_ticks.flags.writeable
    np.testing.assert_array_equal(np.concatenate([block for _, block in recording.frames.blocks()]), frames)
    reference = recording.nonuniformity
    assert reference is not None
    np.testing.assert_allclose(reference.low_dn, low.mean(axis=0), rtol=1e-12)
    np.testing.assert_allclose(reference.low_noise_dn, low.std(axis=0, ddof=1), rtol=1e-9)
    assert (reference.low_temperature_k, reference.high_temperature_k, reference.n_frames) == (288.15, 303.15, 10)


def test_absent_optional_fields_get_the_documented_defaults(hand_made: Callable[..., Path]) -> None:
    """Oracle: the table of defaults in docs/reference/recording-file.md."""
    names = ("count_time", "trigger_delay_time_set", "bit_depth_readout", "frame_number")
    optional = [f"{CAMERA}/{name}" for name in names]
    optional += [f"{CLOCK}/{name}" for name in ("application_edges", "camera_period", "wheel_period")]
    recording = reader.read(hand_made(_take(*optional, REFERENCE, "entry/instrument/blackbody")))
    assert recording.integration_time_s is None
    assert recording.trigger_delay_time_set_s == 0.0
    assert recording.bit_depth == 16
    np.testing.assert_array_equal(recording.frame_number, np.arange(20))
    assert recording.application_edge_ticks is None
    assert recording.camera_period_ticks is None
    assert recording.wheel_period_ticks is None
    assert recording.nonuniformity is None
    assert recording.blackbody_temperature_k is None
    assert recording.start_time == ""


@pytest.mark.parametrize(
    ("change", "value_of", "expected"),
    [
        (_put(f"{CAMERA}/count_time", 250.0, units="us"), "integration_time_s", 250e-6),
        (_put(f"{CAMERA}/count_time", [0.25], units=b"ms"), "integration_time_s", 250e-6),
        (_put(f"{CLOCK}/clock_frequency", 49.152, units="MHz"), "clock_frequency_hz", 49_152_000.0),
        (_put(f"{CAMERA}/type", np.bytes_("microbolometer")), "camera_type", "microbolometer"),
        (_put(f"{CAMERA}/type", ["microbolometer"]), "camera_type", "microbolometer"),
        (_put("entry/title", "Zürich"), "name", "Zürich"),
        (_put("entry/start_time", "2026-11-20T09:00:00+00:00"), "start_time", "2026-11-20T09:00:00+00:00"),
        (_put("entry/something", 1), "findings", ()),
    ],
)
def test_units_and_kinds_of_text_are_understood(
    hand_made: Callable[..., Path], change: Callable[[h5py.File], None], value_of: str, expected: object
) -> None:
    """Oracle: prefixes of the SI; text as h5py stores it in its three ways; unknown fields are ignored."""
    value = getattr(reader.read(hand_made(change)), value_of)
    assert value == pytest.approx(expected) if isinstance(expected, float) else value == expected


BAD_FIELDS = {
    "no camera type": (_take(f"{CAMERA}/type"), ["camera/type is missing", "write it, see docs/reference"]),
    "misspelt required field": (
        _rename(f"{CLOCK}/camera_trigger", f"{CLOCK}/camera_triger"),
        ["trigger_generator/camera_trigger is missing", "the file has 'camera_triger' there, rename it"],
    ),
    "no entry": (_take("entry"), ["/entry/instrument/camera/data is missing", "write it"]),
    "no data": (_take(f"{CAMERA}/data"), ["camera/data is missing"]),
    "unknown camera": (
        _put(f"{CAMERA}/type", "Photon"),
        ["camera/type is 'Photon'", "'photon' or 'microbolometer', did you mean 'photon'?"],
    ),
    "type is a number": (_put(f"{CAMERA}/type", 3), ["camera/type is one int64", "one text"]),
    "type is not UTF-8": (_put(f"{CAMERA}/type", np.bytes_(b"\xff\xfe")), ["camera/type is", "UTF-8"]),
    "float frames": (_put(f"{CAMERA}/data", np.zeros((20, 4, 6))), ["camera/data is float64", "uint16"]),
    "signed frames": (_put(f"{CAMERA}/data", np.zeros((20, 4, 6), "i2")), ["data is int16", "uint16"]),
    "one frame": (_put(f"{CAMERA}/data", np.zeros((4, 6), "u2")), ["shape (4, 6)", "frame, row and column"]),
    "no frames": (_put(f"{CAMERA}/data", np.zeros((0, 4, 6), "u2")), ["(0, 4, 6): no frames", "record again"]),
    "frames in a group": (
        lambda file: (_take(f"{CAMERA}/data")(file), file.create_group(f"{CAMERA}/data")),
        ["camera/data is a group", "must be a dataset"],
    ),
    "frames of two sizes": (
        _put(f"{REFERENCE}/low", np.zeros((10, 4, 5), "u2")),
        ["nonuniformity_reference/low has frames of 4 x 5 pixels", "camera/data of 4 x 6", "one size"],
    ),
    "frames half written": (_frames_half_written, ["has 12 of 20 chunks", "interrupted; record again"]),
    "unknown filter": (_unknown_filter, ["camera/data is compressed with HDF5 filter 31999", "not installed"]),
    "dangling link": (
        _put(f"{CAMERA}/data", h5py.SoftLink("/nowhere")),
        ["camera/data is a link", "store the data there"],
    ),
    "one reference stack": (_take(f"{REFERENCE}/high"), ["reference/high is missing while low", "both"]),
    "swapped reference": (
        lambda file: file[f"{REFERENCE}/low"].attrs.modify("temperature", 310.0),
        ["low is at 310 K, high at 303.15 K", "swap them"],
    ),
    "reference in Celsius": (
        lambda file: file[f"{REFERENCE}/low"].attrs.modify("temperature", 15.0),
        ["low@temperature = 15 K is out of range", "from 100 to 5000 K"],
    ),
    "reference temperature unit": (
        lambda file: file[f"{REFERENCE}/low"].attrs.modify("temperature_units", "degC"),
        ["low@temperature is in 'degC'", "must be in K"],
    ),
    "float ticks": (
        _put(f"{CLOCK}/control_slot", np.arange(5.0)),
        ["control_slot is float64 of shape (5,)", "integers (int64)"],
    ),
    "ticks in a table": (_put(f"{CLOCK}/control_slot", np.zeros((5, 2), "i8")), ["one dimension"]),
    "ticks in seconds": (
        _put(f"{CLOCK}/control_slot", np.arange(5), units="s"),
        ["control_slot is in 's'", "must be in ticks"],
    ),
    "ticks beyond int64": (
        _put(f"{CLOCK}/control_slot", np.array([1, 2**63 + 5], "u8")),
        ["control_slot reaches 9223372036854775813", "int64"],
    ),
    "no edges": (_put(f"{CLOCK}/application_slot", np.arange(1)), ["has 1 entry", "at least 2", "cable"]),
    "wrapped counter": (
        _put(f"{CLOCK}/control_slot", np.array([5, 9, 2, 4])),
        ["control_slot goes back at entry 2: 2 after 9", "unwrap"],
    ),
    "wrapped at once": (_put(f"{CLOCK}/control_slot", np.array([5, 1, 2])), ["goes back at entry 1: 1 after 5"]),
    "two triggers at once": (
        lambda file: file[f"{CLOCK}/camera_trigger"].__setitem__(1, file[f"{CLOCK}/camera_trigger"][0]),
        ["camera_trigger has 1 repeated tick", "at entry 1", "record again"],
    ),
    "speed of zero": (_put(SPEED, 0.0), ["rotation_speed = 0 Hz is out of range", "from 0.001 to 10000 Hz"]),
    "speed not finite": (_put(SPEED, np.nan), ["rotation_speed is nan", "finite number in Hz"]),
    "speed in rpm": (_put(SPEED, 180.0, units="rpm"), ["rotation_speed is in 'rpm'", "must be in Hz (or mHz"]),
    "speed is text": (_put(SPEED, "3"), ["rotation_speed is one text", "must be a number"]),
    "two speeds": (_put(SPEED, [3.0, 4.0]), ["rotation_speed is float64 of shape (2,)", "must be a number"]),
    "negative exposure": (_put(f"{CAMERA}/count_time", -1e-3), ["count_time = -0.001 s is out of range"]),
    "negative delay": (_put(f"{CAMERA}/trigger_delay_time_set", -0.1), ["trigger_delay_time_set = -0.1 s"]),
    "20 bits": (_put(f"{CAMERA}/bit_depth_readout", 20), ["bit_depth_readout = 20", "from 1 to 16"]),
    "14.0 bits": (_put(f"{CAMERA}/bit_depth_readout", 14.0), ["one float64", "must be an integer"]),
    "frame numbers too few": (
        _put(f"{CAMERA}/frame_number", np.arange(19)),
        ["frame_number has 19 entries for 20 frames", "one number per frame"],
    ),
    "frame numbers not rising": (
        _put(f"{CAMERA}/frame_number", np.array([*range(10), 9, *range(11, 20)])),
        ["frame_number is 9 at frame 10 after 9", "increase"],
    ),
    "frame numbers beyond": (
        _put(f"{CAMERA}/frame_number", np.arange(1, 21)),
        ["frame_number runs from 1 to 20 for 20 triggers", "counted from 0"],
    ),
    "more frames than triggers": (
        lambda file: (
            _take(f"{CAMERA}/frame_number")(file),
            _put(f"{CLOCK}/camera_trigger", 30_000_000 + np.arange(18))(file),
        ),
        ["camera/data has 20 frames for 18 triggers", "triggered mode"],
    ),
    "later layout": (
        lambda file: file["entry"].attrs.modify("irtiming_layout", 2),
        ["/entry@irtiming_layout = 2 is later than 1", "update irtiming"],
    ),
}


@pytest.mark.parametrize("case", BAD_FIELDS)
def test_a_bad_field_is_refused_in_one_line(hand_made: Callable[..., Path], case: str) -> None:
    """Oracle: the rules of the format; the line names file, field, value and cure."""
    change, fragments = BAD_FIELDS[case]
    path = hand_made(change)
    with pytest.raises(ArchiveError) as caught:
        reader.read(path)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(f"{path}: /entry")
    for fragment in fragments:
        assert fragment in message


@pytest.mark.parametrize(
    ("change", "fragments"),
    [
        (
            lambda file: (
                _take(f"{CAMERA}/frame_number")(file),
                _put(f"{CLOCK}/camera_trigger", 30_000_000 + np.arange(23))(file),
            ),
            ["20 frames for 23 triggers and no frame_number", "frame i is taken to belong to trigger i"],
        ),
        (_rename(f"{CAMERA}/count_time", f"{CAMERA}/count_tme"), ["count_time is absent", "'count_tme'"]),
        (_put(f"{CLOCK}/control_slot", np.array([1, 5, 5, 9])), ["control_slot has 1 repeated tick"]),
        (_put(f"{REFERENCE}/low", np.ones((1, 4, 6), "u2")), ["low has a single frame", "noise is unknown"]),
    ],
)
def test_an_oddity_is_a_warning(
    hand_made: Callable[..., Path], change: Callable[[h5py.File], None], fragments: list[str]
) -> None:
    """Oracle: what can be analysed is not refused, and not silently accepted."""
    (finding,) = reader.read(hand_made(change)).findings
    for fragment in fragments:
        assert fragment in finding.sentence()


def test_a_file_that_cannot_be_opened_says_why(hand_made: Callable[..., Path], tmp_path: Path) -> None:
    """Oracle: the state of the file, made by hand."""
    whole = hand_made()
    content = whole.read_bytes()
    (tmp_path / "cut.nxs").write_bytes(content[: len(content) // 2])
    (tmp_path / "stub.nxs").write_bytes(content[:20])
    (tmp_path / "empty.nxs").write_bytes(b"")
    (tmp_path / "text.nxs").write_text("This is no recording.\n" * 100)
    expected = {
        "cut.nxs": f"is truncated: {len(content) // 2} of {len(content)} bytes are left; copy it again",
        "stub.nxs": "the file is damaged; copy or record it again",
        "empty.nxs": "is empty (0 bytes); copy or record it again",
        "text.nxs": "is not an HDF5 file; name a recording (.nxs)",
        "none.nxs": "does not exist; check the name",
        "": "is a folder, not a recording",
    }
    for name, fragment in expected.items():
        with pytest.raises(ArchiveError) as caught:
            reader.read(tmp_path / name)
        assert str(caught.value).startswith(f"{tmp_path / name}: ")
        assert fragment in str(caught.value)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("error", "fragment"),
    [
        (PermissionError(13, "Permission denied"), "may not be read; give yourself read permission"),
        (BlockingIOError(11, "unable to lock file"), "is locked; another program is writing it"),
        (OSError("Unable to open file (bad superblock)"), "cannot be opened as HDF5 (bad superblock)"),
    ],
)
def test_what_h5py_throws_on_opening_is_explained(
    hand_made: Callable[..., Path], monkeypatch: pytest.MonkeyPatch, error: OSError, fragment: str
) -> None:
    """Oracle: the exceptions of h5py; thrown by hand, since root may read everything."""
    path = hand_made()

    def refuse(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr("irtiming.archive.hdf5_file.h5py.File", refuse)
    with pytest.raises(ArchiveError, match=r"by-hand\.nxs: ") as caught:
        reader.read(path)
    assert fragment in str(caught.value)


def test_a_damaged_chunk_names_its_frame(hand_made: Callable[..., Path]) -> None:
    """Oracle: frame 13's compressed bytes, overwritten in the file."""
    path = hand_made()
    with h5py.File(path) as file:
        chunk = file[f"{CAMERA}/data"].id.get_chunk_info(13)
    with path.open("r+b") as raw:
        raw.seek(chunk.byte_offset)
        raw.write(b"\xff" * chunk.size)
    frames = reader.read(path).frames
    for stream in (lambda: list(frames.blocks()), lambda: frames.pick([2, 13])):
        with pytest.raises(ArchiveError, match=r"camera/data cannot be read at frame 13 of 20 .*copy or record"):
            stream()


def test_a_file_damaged_anywhere_is_never_a_traceback(hand_made: Callable[..., Path]) -> None:
    """Oracle: any run of 64 bytes overwritten gives a recording or an ArchiveError, nothing else."""
    path = hand_made(text=bytes)
    content = path.read_bytes()
    rng = np.random.default_rng(3)
    refused = 0
    for start in rng.integers(0, len(content) - 64, 60):
        path.write_bytes(content[:start] + rng.bytes(64) + content[start + 64 :])
        with suppress(ArchiveError):
            refused += 1
            for _ in reader.read(path).frames.blocks():
                pass
            refused -= 1
    assert refused > 5


@pytest.mark.parametrize("chunks", [None, (1, 4, 6), (3, 4, 6), (7, 2, 3), (20, 4, 6)])
@pytest.mark.parametrize("kind", ["<u2", ">u2"])
def test_blocks_and_picks_are_the_frames_however_they_are_stored(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, chunks: tuple[int, ...] | None, kind: str
) -> None:
    """Oracle: the array that was written; blocks of at most seven frames."""
    monkeypatch.setattr(layout, "BLOCK_BYTES", 7 * 4 * 6 * 2)
    values = np.random.default_rng(4).integers(0, 2**16, (20, 4, 6), dtype=np.uint16)
    with h5py.File(tmp_path / "f.h5", "w") as file:
        file.create_dataset("data", data=values.astype(kind), chunks=chunks)
    frames = FileFrames(tmp_path / "f.h5", "/data", shape=(20, 4, 6))
    blocks = [(first, block.copy()) for first, block in frames.blocks()]
    assert [first for first, _ in blocks] == list(np.cumsum([0] + [len(block) for _, block in blocks])[:-1])
    np.testing.assert_array_equal(np.concatenate([block for _, block in blocks]), values)
    assert all(len(block) <= 7 for _, block in blocks)
    for stack in (frames, ArrayFrames(values, block_frames=6)):
        np.testing.assert_array_equal(stack.pick([19, 0, 19, 5]), values[[19, 0, 19, 5]])
        with pytest.raises(ArchiveError, match="no frame 20; it must be from 0 to 19"):
            stack.pick([20])


def test_a_file_that_changed_after_reading_is_refused(hand_made: Callable[..., Path]) -> None:
    """Oracle: a file of the same name with fewer frames."""
    frames = reader.read(hand_made()).frames
    hand_made(_put(f"{CAMERA}/data", np.ones((5, 4, 6), "u2")))
    with pytest.raises(ArchiveError, match=r"has shape \(5, 4, 6\), it had \(20, 4, 6\); the file has changed"):
        next(iter(frames.blocks()))


def test_a_file_that_cannot_be_hashed_is_refused(tmp_path: Path) -> None:
    """Oracle: a name without a file."""
    with pytest.raises(ArchiveError, match="cannot be read"):
        sha256_of(tmp_path / "none")


def test_the_example_recordings_are_read(shared_recordings: Path) -> None:
    """Oracle: what stands in the example files' truth.json and names."""
    for path in sorted(shared_recordings.glob("*/*.nxs")):
        recording = reader.read(path)
        assert recording.camera_type == json.loads((path.parent / "truth.json").read_text())["camera"]
        assert recording.frames.shape[1:] == (120, 160)
        assert recording.findings == ()
        assert recording.trigger_delay_time_set_s == (0.025 if "25ms" in path.name else 0.0)
        assert f"{recording.rotation_speed_hz:.0f}Hz" in path.name
