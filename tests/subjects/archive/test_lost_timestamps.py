"""A recording that lost timestamps: marked in the file, told by verify, never analysed."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.archive import reader, writer
from irtiming.archive.captures.streams import captured_ticks, line_map
from irtiming.archive.timestamps_file import read_timestamps, write_timestamps
from irtiming.archive.verify import verify
from irtiming.cli.export_vcd_command import export_vcd
from irtiming.errors import ArchiveError, ReductionError
from irtiming.measurement import analyse
from irtiming.records.rig import LightGates, MaskOpening, Measured, Rig, Wheel
from irtiming.records.timestamps import Timestamps
from irtiming.records.trigger_plan import PlannedRun, TriggerScheme
from irtiming.reduce.wheel import wheel_calibration

FIELD = "entry/instrument/trigger_generator/lost_after"
LOST = 7_000_000 + 16_384_000 + 12_345_678  # the first trigger of the hand-made file is a turn after 7 000 000
RIG = Rig(
    wheel=Wheel(),
    light_gates=LightGates(
        half_separation_m=Measured(13e-3), height_difference_m=Measured(5.5e-3), whole_slots_between=9
    ),
    mask_opening=MaskOpening(opening_angle_rad=Measured(1.3), centre_angle_rad=Measured(-1.57)),
    source="by hand",
)


def _set(values):
    return lambda file: file.__setitem__(FIELD, np.array(values, dtype=np.int64))


def _codes(path):
    return [finding.code for finding in verify(path)]


def test_a_file_without_the_field_tells_nothing_of_losses(hand_made):
    """Oracle: files written before there was the field."""
    assert reader.read(hand_made()).lost_after_ticks is None
    assert _codes(hand_made(name="b.nxs")) == ["recording-sound", "frames-few"]


def test_an_empty_field_says_that_nothing_was_lost(hand_made, tmp_path):
    """Oracle: the layout; it survives being written again."""
    was = reader.read(hand_made(_set([])))
    assert was.lost_after_ticks.size == 0
    writer.write(was, tmp_path / "again.nxs")
    assert reader.read(tmp_path / "again.nxs").lost_after_ticks.size == 0
    assert _codes(tmp_path / "again.nxs") == ["recording-sound", "frames-few"]


def test_verify_tells_when_timestamps_were_lost(hand_made):
    """Oracle: 12 345 678 ticks of 49.152 MHz after the first trigger are 0.251173 s, by hand."""
    (finding,) = (f for f in verify(hand_made(_set([LOST, LOST + 50]))) if f.severity == "error")
    assert finding.where == f"/{FIELD}"
    assert "timestamps were lost at 2 places, the first 0.251173 s after the first trigger" in finding.what


@pytest.mark.parametrize("use", ["analyse", "calibrate"])
def test_a_recording_that_lost_timestamps_is_not_used(hand_made, use):
    """Oracle: the promise; the time of the loss is told by analysis and wheel calibration alike."""
    recording = reader.read(hand_made(_set([LOST, LOST + 50])))
    work = analyse if use == "analyse" else wheel_calibration.from_recordings
    with pytest.raises(ReductionError, match=r"lost 0\.251173 s after the first trigger and 1 times more"):
        work([recording], RIG)


def test_a_marked_recording_can_be_written_and_read(hand_made, tmp_path):
    """Oracle: the recording that was written; a loss must not vanish with a copy."""
    marked = replace(reader.read(hand_made()), lost_after_ticks=np.array([LOST]))
    writer.write(marked, tmp_path / "marked.nxs")
    assert reader.read(tmp_path / "marked.nxs").lost_after_ticks.tolist() == [LOST]


def test_losses_that_go_back_are_refused(hand_made):
    """Oracle: ticks of one counter never go back."""
    with pytest.raises(ArchiveError, match="lost_after goes back"):
        reader.read(hand_made(_set([LOST, LOST - 1])))


def _timestamps(lost=()):
    k = np.arange(40, dtype=np.int64)
    return Timestamps(
        clock_frequency_hz=48_000_000,
        camera_trigger_ticks=1000 * k + 5,
        camera_trigger_delayed_ticks=1000 * k + 105,
        control_slot_ticks=100 * k,
        application_slot_ticks=500 * k,
        application_edge_ticks=250 * k,
        camera_input_ticks=k[:0],
        spare_ticks=k[:0],
        lost_after_ticks=np.array(lost, dtype=np.int64),
    )


RUN = PlannedRun(
    scheme=TriggerScheme(turn_period_ticks=16_000_000, camera_period_ticks=1_584_000), trigger_delay_ticks=120_000, repeats=1,
    is_after_correction=True,
)  # fmt: skip


@pytest.mark.parametrize("lost", [(), (7, 70)])
def test_a_file_of_timestamps_gives_them_back(tmp_path, lost):
    """Oracle: what was written; 3 turns a second and 2.5 ms, by hand; a file that was there is replaced."""
    path = tmp_path / "stamps.nxs"
    path.write_text("something else")
    write_timestamps(_timestamps(lost), path, run=RUN)
    found = read_timestamps(path)
    assert (found.clock_frequency_hz, found.rotation_speed_hz, found.trigger_delay_time_set_s) == (
        48_000_000,
        3,
        0.0025,
    )
    assert {field.name: ticks.tolist() for field, ticks in found.streams.items()} == {
        "camera_trigger": [1000 * k + 5 for k in range(40)],
        "camera_trigger_delayed": [1000 * k + 105 for k in range(40)],
        "control_slot": [100 * k for k in range(40)],
        "application_slot": [500 * k for k in range(40)],
        "application_edges": [250 * k for k in range(40)],
        "lost_after": list(lost),
    }
    assert not (tmp_path / "stamps.nxs.part").exists()


def test_the_same_timestamps_give_the_same_bytes(tmp_path):
    """Oracle: the first file."""
    for name in ("a.nxs", "b.nxs"):
        write_timestamps(_timestamps(), tmp_path / name, run=RUN)
    assert (tmp_path / "a.nxs").read_bytes() == (tmp_path / "b.nxs").read_bytes()


def test_timestamps_without_a_trigger_are_no_recording(tmp_path):
    """Oracle: the words of the reader."""
    path = tmp_path / "stamps.nxs"
    write_timestamps(replace(_timestamps(), camera_trigger_ticks=np.empty(0, dtype=np.int64)), path, run=RUN)
    with pytest.raises(ArchiveError, match="camera_trigger has 0 entries"):
        read_timestamps(path)


def test_a_place_that_cannot_be_written_is_told(tmp_path):
    """Oracle: the words."""
    with pytest.raises(ArchiveError, match="no folder|cannot be written|No such"):
        write_timestamps(_timestamps(), tmp_path / "no" / "stamps.nxs", run=RUN)


def test_timestamps_without_frames_can_be_looked_at(tmp_path):
    """Oracle: the ticks that were written; a waveform viewer needs no frames."""
    path, dump = tmp_path / "stamps.nxs", tmp_path / "stamps.vcd"
    written = replace(
        _timestamps(), control_slot_ticks=_timestamps().control_slot_ticks + 1
    )  # a dump begins before tick 1
    write_timestamps(written, path, run=RUN)
    export_vcd(path, dump)
    names = ("camera_trigger", "control_slot", "application_slot")
    found = captured_ticks(dump, line_map(",".join(f"{name}={name}" for name in names)))
    assert found.clock_frequency_hz == written.clock_frequency_hz
    given = {field.name: ticks.tolist() for field, ticks in found.streams.items()}
    assert given["camera_trigger"] == written.camera_trigger_ticks.tolist()
    assert given["control_slot"] == written.control_slot_ticks.tolist()
