"""Recording -> writer -> file -> reader -> the same recording."""

from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from irtiming.archive import reader, writer
from irtiming.archive.frame_stack import ArrayFrames
from irtiming.archive.verify import verify
from irtiming.records.recording import FrameStack, Recording


def _frames_of(stack: FrameStack) -> np.ndarray:
    return np.concatenate([block.copy() for _, block in stack.blocks()])


def _assert_same(was: Recording, now: Recording) -> None:
    for field in fields(Recording):
        if field.name in ("source", "sha256", "frames", "nonuniformity"):
            continue
        np.testing.assert_array_equal(getattr(now, field.name), getattr(was, field.name), err_msg=field.name)
    np.testing.assert_array_equal(_frames_of(now.frames), _frames_of(was.frames))
    if was.nonuniformity is None or now.nonuniformity is None:
        assert was.nonuniformity is now.nonuniformity
        return
    for field in fields(was.nonuniformity):
        before, after = getattr(was.nonuniformity, field.name), getattr(now.nonuniformity, field.name)
        if field.name in ("low_frames", "high_frames"):
            before, after = _frames_of(before), _frames_of(after)
        np.testing.assert_array_equal(after, before, err_msg=field.name)


def test_the_hand_made_file_survives(hand_made: Callable[..., Path], tmp_path: Path) -> None:
    """Oracle: the recording read from a file that plain h5py wrote."""
    was = reader.read(hand_made())
    path = tmp_path / "again.nxs"
    truth = {"trigger_delay_s": 4e-4, "seed": 7, "camera": "photon", "slot_angles_rad": np.arange(3.0)}
    writer.write(was, path, truth=truth)
    _assert_same(replace(was, is_simulated=True), reader.read(path))  # which the truth beside it says
    given_back = reader.read_truth(path)
    np.testing.assert_array_equal(given_back.pop("slot_angles_rad"), truth.pop("slot_angles_rad"))
    assert given_back == truth
    assert [finding.code for finding in verify(path)] == ["recording-sound", "frames-few"]


def test_the_example_recordings_survive(shared_recordings: Path, tmp_path: Path) -> None:
    """Oracle: the recordings as read from the examples, with the first two hundred of their frames."""
    for path in sorted(shared_recordings.glob("*/*0ms.nxs")):
        whole = reader.read(path)
        frames = ArrayFrames(whole.frames.pick(list(range(200))), block_frames=64)
        was = replace(whole, frames=frames, frame_number=whole.frame_number[:200])
        writer.write(was, tmp_path / path.name)
        _assert_same(was, reader.read(tmp_path / path.name))


@settings(max_examples=25, deadline=None)
@given(
    frames=arrays(np.uint16, st.tuples(st.integers(1, 9), st.integers(1, 4), st.integers(1, 5))),
    start=st.integers(-(2**40), 2**40),
    delay_s=st.floats(0.0, 60.0),
    integration_time_s=st.none() | st.floats(1e-9, 10.0),
    name=st.text(st.characters(exclude_categories=("Cs", "Cc")), min_size=1, max_size=20),
)
def test_any_recording_survives(
    frames: np.ndarray, start: int, delay_s: float, integration_time_s: float | None, name: str
) -> None:
    """Oracle: the recording itself, whatever its numbers, sizes and name."""
    n_frames = len(frames)
    was = Recording(
        name=name,
        camera_type="photon",
        readout_mode="snapshot",
        frames=ArrayFrames(frames, block_frames=4),
        frame_number=2 * np.arange(n_frames),
        clock_frequency_hz=49_152_000.0,
        camera_trigger_ticks=start + 1000 * np.arange(2 * n_frames),
        control_slot_ticks=start + 7 * np.arange(30),
        application_slot_ticks=start + 350 * np.arange(4),
        rotation_speed_hz=3.0,
        integration_time_s=integration_time_s,
        trigger_delay_time_set_s=delay_s,
    )
    with TemporaryDirectory() as folder:
        path = Path(folder) / "any.nxs"
        writer.write(was, path)
        _assert_same(was, reader.read(path))
