"""Frames and captured timestamps together, without touching the file of the frames."""

import h5py
import numpy as np
import pytest

from irtiming.archive import layout, reader
from irtiming.archive.captures.streams import CapturedTicks
from irtiming.archive.captures.timed_recording import CameraFacts, write_timed
from irtiming.errors import ArchiveError

CLOCK_HZ = 24_000_000
TURN, PERIOD = 8_000_000, 792_000
FACTS = CameraFacts(camera_type="photon", rotation_speed_hz=3.0, integration_time_s=250e-6, bit_depth=14)


def _ticks(n_triggers: int = 20, start: int = 100) -> CapturedTicks:
    """What the small recording made by hand would look like to an analyser at 24 MHz."""
    return CapturedTicks(
        clock_frequency_hz=CLOCK_HZ,
        streams={
            layout.CAMERA_TRIGGER: start + TURN + PERIOD * np.arange(n_triggers),
            layout.CONTROL_SLOT: start + TURN // 100 * np.arange(401),
            layout.APPLICATION_SLOT: start + 5 + TURN // 2 * np.arange(9),
        },
    )


def test_a_recording_gets_the_captured_timestamps_and_keeps_the_rest(hand_made, tmp_path):
    """Oracle: the streams that went in, everything else of the recording as it was, and its file byte for byte."""
    source, out = hand_made(), tmp_path / "timed.nxs"
    before = source.read_bytes()
    assert write_timed(source, out, ticks=_ticks()) == []
    assert source.read_bytes() == before
    old, new = reader.read(source), reader.read(out)
    assert new.clock_frequency_hz == CLOCK_HZ
    for field, ticks in _ticks().streams.items():
        with h5py.File(out) as file:
            assert np.array_equal(file[field.path][()], ticks)
            assert file[field.path].attrs["units"] == "ticks"
    assert new.application_edge_ticks is None
    assert (new.camera_period_ticks, new.wheel_period_ticks) == (PERIOD, TURN)  # 1 622 016 and 16 384 000 at 49.152 MHz
    assert np.array_equal(new.frames.pick(list(range(20))), old.frames.pick(list(range(20))))
    for name in ("camera_type", "integration_time_s", "trigger_delay_time_set_s", "bit_depth", "rotation_speed_hz"):
        assert getattr(new, name) == getattr(old, name)
    assert new.nonuniformity is not None
    assert np.array_equal(new.nonuniformity.low_dn, old.nonuniformity.low_dn)


@pytest.mark.parametrize(
    "gone", ["trigger_generator", "trigger_generator/camera_trigger", "trigger_generator/clock_frequency"]
)
def test_a_recording_may_lack_its_timestamps(gone, hand_made, tmp_path):
    """Oracle: a file without the group, or without a stream, reads like one that had them."""
    source, out = hand_made(lambda file: file["entry/instrument"].__delitem__(gone)), tmp_path / "timed.nxs"
    write_timed(source, out, ticks=_ticks())
    assert np.array_equal(reader.read(out).camera_trigger_ticks, _ticks().streams[layout.CAMERA_TRIGGER])


def test_exchanged_gates_are_refused_before_anything_is_written(hand_made, tmp_path):
    """Oracle: by hand; the two lines of the light gates in each other's place, of which no recording could be analysed."""
    streams = dict(_ticks().streams)
    slot, application = layout.CONTROL_SLOT, layout.APPLICATION_SLOT
    streams[slot], streams[application] = streams[application], streams[slot]
    ticks = CapturedTicks(clock_frequency_hz=CLOCK_HZ, streams=streams)
    with pytest.raises(ArchiveError, match="the two lines are exchanged"):
        write_timed(hand_made(), tmp_path / "timed.nxs", ticks=ticks)
    assert not (tmp_path / "timed.nxs").exists()


BESIDE = (layout.CAMERA_TRIGGER_DELAYED, layout.CAMERA_INPUT)


def test_delayed_triggers_and_what_the_camera_sent_back_are_never_of_the_old_clock(hand_made, tmp_path):
    """Oracle: streams that the frames' file has vanish unless the timestamps bring their own, as for all ticks."""
    source = hand_made(lambda file: [file.__setitem__(field.path, np.arange(20)) for field in BESIDE])
    write_timed(source, tmp_path / "without.nxs", ticks=_ticks())
    brought = {**_ticks().streams, **{field: np.arange(7) + CLOCK_HZ for field in BESIDE}}
    write_timed(source, tmp_path / "with.nxs", ticks=CapturedTicks(clock_frequency_hz=CLOCK_HZ, streams=brought))
    np.save(tmp_path / "frames.npy", np.zeros((20, 4, 5), dtype=np.uint16))
    ticks = CapturedTicks(clock_frequency_hz=CLOCK_HZ, streams=brought)
    write_timed(tmp_path / "frames.npy", tmp_path / "arrays.nxs", ticks=ticks, facts=FACTS)
    without, *both = (reader.read(tmp_path / f"{name}.nxs") for name in ("without", "with", "arrays"))
    assert (without.camera_trigger_delayed_ticks, without.camera_input_ticks) == (None, None)
    for found in both:
        assert found.camera_trigger_delayed_ticks.tolist() == brought[layout.CAMERA_TRIGGER_DELAYED].tolist()
        assert found.camera_input_ticks.tolist() == brought[layout.CAMERA_INPUT].tolist()


def _strobe() -> CapturedTicks:
    """The same capture with a strobe in the place of the trigger."""
    streams = dict(_ticks().streams)
    streams[layout.CAMERA_INPUT] = streams.pop(layout.CAMERA_TRIGGER) + 1234
    return CapturedTicks(clock_frequency_hz=CLOCK_HZ, streams=streams)


def test_a_capture_with_a_strobe_makes_the_recording_of_a_camera_that_runs_free(hand_made, tmp_path):
    """Oracle: the streams that went in; a trigger of the old clock is gone, and comes back with a capture that has one."""

    def change(file):
        file["entry/instrument/camera/trigger_delay_time_set"][()] = 0.0

    free, again = tmp_path / "free.nxs", tmp_path / "again.nxs"
    write_timed(hand_made(change), free, ticks=_strobe())
    run = reader.read(free)
    assert run.frame_event == "strobe"
    assert run.camera_trigger_ticks.size == 0
    assert np.array_equal(run.camera_input_ticks, _strobe().streams[layout.CAMERA_INPUT])
    write_timed(free, again, ticks=_ticks())
    assert reader.read(again).frame_event == "trigger"
    assert reader.read(again).camera_input_ticks is None
    frames = tmp_path / "frames.npy"
    np.save(frames, np.ones((20, 8, 9), np.uint16))
    write_timed(frames, tmp_path / "array.nxs", ticks=_strobe(), facts=FACTS)
    assert reader.read(tmp_path / "array.nxs").frame_event == "strobe"
    with pytest.raises(ArchiveError, match="no camera_trigger; leave out --delayed-trigger"):
        write_timed(frames, tmp_path / "late.nxs", ticks=_strobe(), facts=FACTS, is_delayed=True)


def test_periods_that_are_no_whole_ticks_of_the_new_clock_are_left_out(hand_made, tmp_path):
    """Oracle: by hand; 1 622 016 ticks of 49.152 MHz are 330 000.1 and so on of a clock of 10.000003 MHz."""
    ticks = _ticks()
    odd = CapturedTicks(clock_frequency_hz=24_000_007, streams=ticks.streams)
    out = tmp_path / "timed.nxs"
    write_timed(hand_made(), out, ticks=odd)
    found = reader.read(out)
    assert (found.camera_period_ticks, found.wheel_period_ticks) == (None, None)


def test_the_set_delay_is_taken_off_a_delayed_trigger(hand_made, tmp_path):
    """Oracle: 25 ms of the recording are 600 000 ticks of 24 MHz."""
    out = tmp_path / "timed.nxs"
    write_timed(hand_made(), out, ticks=_ticks(), is_delayed=True)
    nominal = _ticks().streams[layout.CAMERA_TRIGGER] - 600_000
    assert np.array_equal(reader.read(out).camera_trigger_ticks, nominal)


def _arrays(tmp_path, **more):
    rng = np.random.default_rng(1)
    frames = rng.integers(1000, 9000, (20, 4, 6), dtype=np.uint16)
    arrays = {
        "frames": frames,
        "low": rng.integers(900, 1000, (10, 4, 6), dtype=np.uint16),
        "high": rng.integers(9000, 9100, (10, 4, 6), dtype=np.uint16),
    }
    path = tmp_path / "frames.npz"
    np.savez(path, **(arrays | more))
    return path, frames


def test_arrays_become_a_recording(tmp_path):
    """Oracle: the arrays and facts that went in."""
    path, frames = _arrays(tmp_path, frame_number=np.arange(20) + 1)
    out = tmp_path / "timed.nxs"
    findings = write_timed(path, out, ticks=_ticks(22), facts=FACTS)
    assert [finding.where for finding in findings] == [layout.FRAME_NUMBER.path]  # two triggers without frame
    found = reader.read(out)
    assert np.array_equal(found.frames.pick(list(range(20))), frames)
    assert (found.name, found.readout_mode, found.rotation_speed_hz, found.bit_depth) == ("frames", "snapshot", 3.0, 14)
    assert found.frame_number.tolist() == list(range(1, 21))
    assert found.nonuniformity is not None


def test_a_single_array_is_enough_for_a_microbolometer(tmp_path):
    """Oracle: the array that went in, and the defaults."""
    frames = np.arange(20 * 24, dtype=np.uint16).reshape(20, 4, 6)
    np.save(tmp_path / "frames.npy", frames)
    out = tmp_path / "timed.nxs"
    facts = CameraFacts(camera_type="microbolometer", rotation_speed_hz=3.0)
    assert write_timed(tmp_path / "frames.npy", out, ticks=_ticks(), facts=facts) == []
    found = reader.read(out)
    assert (found.readout_mode, found.bit_depth, found.nonuniformity) == ("rolling", 16, None)
    assert np.array_equal(found.frames.pick([0, 19]), frames[[0, 19]])


@pytest.mark.parametrize(
    ("arrays", "says"),
    [
        ({"frames": np.zeros((20, 4, 6))}, "'frames' is float64 \\(20, 4, 6\\); it must be uint16"),
        ({"frames": np.zeros((20, 4), np.uint16)}, "it must be uint16 \\(frame, row, column\\)"),
        ({"low": np.zeros((20, 4, 7), np.uint16)}, "must have one size"),
        ({"frame_number": np.arange(19)}, "'frame_number' must be one integer for each of 20 frames"),
        ({"frame_number": np.arange(20) + 1}, "runs from 1 to 20 for 20 triggers"),
        ({"frames": np.zeros((21, 4, 6), np.uint16), "frame_number": np.arange(21)}, "for 20 triggers"),
    ],
)
def test_arrays_that_do_not_fit_are_refused_and_leave_nothing(arrays, says, tmp_path):
    """Oracle: the message for each misfit, and an empty place."""
    path, _ = _arrays(tmp_path, **arrays)
    out = tmp_path / "timed.nxs"
    with pytest.raises(ArchiveError, match=says):
        write_timed(path, out, ticks=_ticks(), facts=FACTS)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "cannot be read as arrays|is empty"),
        (b"PK\x03\x04 and no more", "cannot be read as arrays|is no file of frames that is known"),
        (None, "does not exist"),
    ],
)
@pytest.mark.parametrize("name", ["frames.npz", "frames.npy"])
def test_broken_arrays_are_refused(content, says, name, tmp_path):
    """Oracle: the message for each kind of damage."""
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(ArchiveError, match=says):
        write_timed(tmp_path / name, tmp_path / "timed.nxs", ticks=_ticks(), facts=FACTS)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda file: file["entry/instrument/camera"].__delitem__("type"), "camera/type is missing"),
        (
            lambda file: file["entry/instrument/chopper/rotation_speed"].write_direct(np.array(5.0)),
            "rotation_speed = 5 Hz, but",
        ),
        (
            lambda file: file["entry/instrument/camera/frame_number"].write_direct(np.arange(20) + 5),
            "runs from 5 to 24 for 20",
        ),
    ],
)
def test_a_recording_that_does_not_fit_its_capture_is_refused_and_leaves_nothing(change, says, hand_made, tmp_path):
    """Oracle: the message for each misfit, the name of the file to be, and only the source in its place."""
    source = hand_made(change)
    with pytest.raises(ArchiveError, match=says):
        write_timed(source, tmp_path / "timed.nxs", ticks=_ticks())
    assert list(tmp_path.iterdir()) == [source]


def test_what_belongs_to_arrays_is_asked_for_with_arrays_only(hand_made, tmp_path):
    """Oracle: the messages."""
    path, _ = _arrays(tmp_path)
    with pytest.raises(ArchiveError, match="these frames do not state their camera; give --camera and --wheel-hz"):
        write_timed(path, tmp_path / "timed.nxs", ticks=_ticks())
    with pytest.raises(ArchiveError, match="a recording states its camera itself"):
        write_timed(hand_made(), tmp_path / "timed.nxs", ticks=_ticks(), facts=FACTS)
    (tmp_path / "there.nxs").touch()
    with pytest.raises(ArchiveError, match="exists already; choose another name"):
        write_timed(path, tmp_path / "there.nxs", ticks=_ticks(), facts=FACTS)
