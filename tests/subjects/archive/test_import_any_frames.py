"""Frames of makers' files and captured timestamps become one recording."""

import json

import numpy as np
import pytest
from makers_files import FRAMES, WRITERS, expected

from irtiming.archive import layout, reader
from irtiming.archive.captures.camera_frames import CameraFacts, camera_frames
from irtiming.archive.captures.streams import CapturedTicks
from irtiming.archive.captures.timed_recording import write_timed
from irtiming.archive.verify import verify
from irtiming.errors import ArchiveError

PHOTON = CameraFacts(camera_type="photon", rotation_speed_hz=3.0)


def _ticks(n_triggers):
    turn, period = 8_000_000, 792_000
    return CapturedTicks(
        clock_frequency_hz=24_000_000,
        streams={
            layout.CAMERA_TRIGGER: 100 + turn + period * np.arange(n_triggers),
            layout.CONTROL_SLOT: 100 + turn // 100 * np.arange(401),
            layout.APPLICATION_SLOT: 105 + turn // 2 * np.arange(9),
        },
    )


@pytest.mark.parametrize("name", ["a.ptw", "a.hcc", "a.mkv", "a.seq"])
def test_frames_of_any_format_become_a_recording(name, tmp_path):
    """Oracle: the frames that were written, and the ticks of the capture."""
    WRITERS[name](tmp_path / name)
    n_frames = len(expected(name))
    write_timed(tmp_path / name, tmp_path / "o.nxs", ticks=_ticks(n_frames), facts=PHOTON)
    found = reader.read(tmp_path / "o.nxs")
    assert np.array_equal(found.frames.pick(list(range(n_frames))), expected(name))
    assert found.camera_trigger_ticks.tolist() == _ticks(n_frames).streams[layout.CAMERA_TRIGGER].tolist()


def test_what_the_file_tells_is_in_the_recording(tmp_path):
    """Oracle: what was written into the PTW."""
    WRITERS["a.ptw"](tmp_path / "a.ptw")
    write_timed(tmp_path / "a.ptw", tmp_path / "o.nxs", ticks=_ticks(5), facts=PHOTON)
    found = reader.read(tmp_path / "o.nxs")
    assert found.integration_time_s == pytest.approx(250e-6, rel=1e-6)
    assert found.bit_depth == 14
    assert found.camera is not None
    assert found.camera.serial_number == "012275"


def test_an_integration_time_that_contradicts_the_file_is_refused(tmp_path):
    """Oracle: 250 us are in the file."""
    WRITERS["a.ptw"](tmp_path / "a.ptw")
    wrong = CameraFacts(camera_type="photon", rotation_speed_hz=3.0, integration_time_s=300e-6)
    with pytest.raises(ArchiveError, match=r"0\.00025 s.*0\.0003 s"):
        write_timed(tmp_path / "a.ptw", tmp_path / "o.nxs", ticks=_ticks(5), facts=wrong)
    assert not (tmp_path / "o.nxs").exists()


def test_a_gap_in_the_numbers_of_the_camera_is_a_lost_frame(tmp_path):
    """Oracle: the number that is left out; the frame behind it belongs to the next trigger."""
    np.save(tmp_path / "a.npy", FRAMES)
    (tmp_path / "a.npy.json").write_text(json.dumps({"frame_id": [10, 11, 13, 14, 15]}))
    findings = write_timed(tmp_path / "a.npy", tmp_path / "o.nxs", ticks=_ticks(6), facts=PHOTON)
    assert reader.read(tmp_path / "o.nxs").frame_number.tolist() == [0, 1, 3, 4, 5]
    assert any(one.where == layout.FRAME_NUMBER.path for one in findings)


def _film(path, times_s, **told):
    """Frames that have times of day, of small pixels."""
    np.save(path, np.zeros((times_s.size, 4, 6), np.uint16))
    facts = {"times_s": (40_000.0 + times_s).tolist(), "time_scale": "time of day", "time_step_s": 1e-6}
    path.with_name(f"{path.name}.json").write_text(json.dumps(facts | told))


def test_frames_of_another_measurement_are_refused(tmp_path):
    """Oracle: 100 frames 29.998 ms apart, as in a film that a camera's program keeps, and 120 triggers 33 ms apart."""
    _film(tmp_path / "a.npy", 29.998e-3 * np.arange(100))
    with pytest.raises(
        ArchiveError, match=r"a\.npy: its frames are 29\.998 ms apart .* 2\.970 s, their triggers 33 ms and 3\.267 s"
    ):
        write_timed(tmp_path / "a.npy", tmp_path / "o.nxs", ticks=_ticks(120), facts=PHOTON)
    assert list(tmp_path.glob("o.nxs*")) == []


@pytest.mark.parametrize(("n_lost", "says"), [(1, "1 trigger later"), (2, "2 triggers later")])
def test_frames_that_their_own_times_show_to_be_lost_are_refused_until_they_are_numbered(tmp_path, n_lost, says):
    """Oracle: the place at which frames were left out by hand; times scatter by 1 ms, and their clock is 100 ppm too fast."""
    made = np.delete(np.arange(80), 40 + np.arange(n_lost))
    times_s = 33e-3 * made * (1 + 1e-4) + np.random.default_rng(1).normal(0, 1e-3, made.size)
    _film(tmp_path / "a.npy", times_s)
    with pytest.raises(ArchiveError, match=f"frame 40 comes {says} by its own time"):
        write_timed(tmp_path / "a.npy", tmp_path / "o.nxs", ticks=_ticks(80), facts=PHOTON)
    _film(tmp_path / "b.npy", times_s, frame_id=made.tolist())
    write_timed(tmp_path / "b.npy", tmp_path / "o.nxs", ticks=_ticks(80), facts=PHOTON)
    assert reader.read(tmp_path / "o.nxs").frame_number.tolist() == made.tolist()


def test_times_of_a_busy_computer_or_of_a_clock_that_was_set_prove_nothing(tmp_path):
    """Oracle: every frame is there; eight were stamped late in a burst, and the clock was put back by half an interval."""
    times_s = 33e-3 * np.arange(80) + np.random.default_rng(2).normal(0, 1e-3, 80)
    times_s[20:28] = times_s[28]
    times_s[50:] += 16e-3
    for name, scale in (("a.npy", "host clock"), ("b.npy", "local time")):
        _film(tmp_path / name, times_s, time_scale=scale)
        write_timed(tmp_path / name, (tmp_path / name).with_suffix(".nxs"), ticks=_ticks(80), facts=PHOTON)
    _film(tmp_path / "c.npy", times_s / 2, time_scale="first frame")  # what a film's nominal rate says is no clock
    write_timed(tmp_path / "c.npy", tmp_path / "c.nxs", ticks=_ticks(80), facts=PHOTON)


def test_a_gap_in_the_numbers_of_a_folder_is_a_lost_frame(tmp_path):
    """Oracle: the file that is taken away; each frame behind it belongs to the trigger it had, and the gap is told."""
    (tmp_path / "frames").mkdir()
    for n in (0, 1, 3, 4):
        np.save(tmp_path / "frames" / f"f_{n:04d}.npy", FRAMES[n][None])
    findings = write_timed(tmp_path / "frames", tmp_path / "o.nxs", ticks=_ticks(5), facts=PHOTON)
    found = reader.read(tmp_path / "o.nxs")
    assert found.frame_number.tolist() == [0, 1, 3, 4]
    assert np.array_equal(found.frames.pick([2]), FRAMES[3][None])
    assert any(one.where == layout.FRAME_NUMBER.path for one in findings)


def test_temperatures_become_counts_in_fine_steps(tmp_path):
    """Oracle: the temperatures that were written, within half a step of their range divided by 65 535."""
    WRITERS["a.irb"](tmp_path / "a.irb")
    facts = CameraFacts(camera_type="microbolometer", rotation_speed_hz=3.0)
    stack = camera_frames(tmp_path / "a.irb", facts).frames
    wanted = expected("a.irb")
    step_k = np.ptp(wanted) / 65_535
    back = wanted.min() + step_k * stack.pick([0, 1])
    assert np.abs(back - wanted).max() < 0.6 * step_k
    np.save(tmp_path / "b.npy", np.where(wanted == wanted.max(), np.nan, wanted))
    with pytest.raises(ArchiveError, match="no number in frames 0 to 1"):
        camera_frames(tmp_path / "b.npy", facts)


def test_verify_says_what_a_foreign_file_is(tmp_path):
    """Oracle: the file that was written, and the command that takes it."""
    WRITERS["a.ptw"](tmp_path / "a.ptw")
    (finding,) = verify(tmp_path / "a.ptw")
    assert "is a FLIR/Cedip PTW file with 5 frames of 24 x 32 pixels" in finding.what
    assert "import-capture" in finding.cure
