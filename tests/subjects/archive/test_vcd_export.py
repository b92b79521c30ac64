"""Timestamps as a value change dump and back."""

import shutil
import subprocess
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from irtiming.archive import reader
from irtiming.archive.captures.streams import captured_ticks, line_map
from irtiming.archive.vcd_export import write_vcd
from irtiming.errors import ArchiveError
from irtiming.records.recording import Recording

NAMES = ("camera_trigger", "control_slot", "application_slot", "application_edges")
MAP = ",".join(f"{name}={name}" for name in NAMES)
CLOCKS = (1_000_000, 24_000_000, 48_000_000, 49_152_000, 150_000_000, 200_000_000, 999_999_937, 10**9, 10**10, 10**12)


def _recording(streams: dict[str, list[int]], clock_hz: float) -> Recording:
    ticks = {name: np.array(values, np.int64) for name, values in streams.items()}
    return Recording(
        name="made up", camera_type="photon", readout_mode="snapshot", frames=None, frame_number=np.arange(1),  # type: ignore[arg-type]
        clock_frequency_hz=clock_hz, rotation_speed_hz=3.0, camera_trigger_ticks=ticks["camera_trigger"],
        control_slot_ticks=ticks["control_slot"], application_slot_ticks=ticks["application_slot"],
        application_edge_ticks=ticks["application_edges"],
    )  # fmt: skip


@st.composite
def _ticks(draw, earliest=1):
    """Ticks that never fall, some of them equal, early and late in a counter of 48 bits."""
    first = draw(st.integers(earliest, 2**47))
    steps = draw(st.lists(st.integers(0, 3) | st.integers(0, 2**33), max_size=6))
    return (first + np.cumsum([0, *steps])).tolist()


@settings(deadline=None)
@given(st.fixed_dictionaries({name: _ticks() for name in NAMES}), st.sampled_from(CLOCKS))
@example({name: [1, 2, 3, 4] for name in NAMES}, 999_999_937)
@example({name: [2**47, 2**47 + 1] for name in NAMES}, 49_152_000)
def test_every_tick_comes_back_exactly(streams, clock_hz):
    """Oracle: the law itself, for clocks up to 1 THz; the clock comes from the file's comment."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "ticks.vcd"
        write_vcd(_recording(streams, clock_hz), path)
        found = captured_ticks(path, line_map(MAP))
    assert found.clock_frequency_hz == clock_hz
    assert {field.name: values.tolist() for field, values in found.streams.items()} == streams


def test_the_file_is_what_a_viewer_expects(tmp_path):
    """Oracle: by hand; one tick of 49.152 MHz is 20.345 ns, a pulse falls half way to the next, edges 0 and 2 rise."""
    streams = {
        "camera_trigger": [10, 30],
        "control_slot": [5],
        "application_slot": [20, 40],
        "application_edges": [11, 20, 31, 40],
    }
    path = tmp_path / "ticks.vcd"
    write_vcd(_recording(streams, 49_152_000.0), path)
    head, _, body = path.read_text().partition("$enddefinitions $end\n")
    assert "$timescale 1 ns $end" in head
    assert "at 49152000 Hz" in head
    changes = " ".join(body.split("$end\n")[1].split())
    assert changes == (
        '#102 1" #103 0" #203 1! #224 0$ #406 0! #407 1# 1$ #610 0# 1! #631 0$ #813 0! #814 1# 1$ #1017 0#'
    )


@pytest.mark.parametrize(
    ("first", "clock_hz", "says"),
    [
        (-1, 1e6, "camera_trigger begins at tick -1; a value change dump has no time before 0"),
        (2**62, 1e6, "beyond 63 bits"),
        (5, 2e12, "is above 1 THz"),
    ],
)
def test_ticks_that_a_dump_cannot_hold_are_refused(first, clock_hz, says, tmp_path):
    """Oracle: the message for each limit."""
    with pytest.raises(ArchiveError, match=says):
        write_vcd(_recording({name: [first] for name in NAMES}, clock_hz), tmp_path / "ticks.vcd")


def test_a_recording_without_all_four_edges_has_three_lines(hand_made, tmp_path):
    """Oracle: the names in the file."""
    recording = replace(reader.read(hand_made()), application_edge_ticks=None)
    write_vcd(recording, tmp_path / "ticks.vcd")
    assert (tmp_path / "ticks.vcd").read_text().count("$var wire 1") == 3


@pytest.mark.skipif(shutil.which("sigrok-cli") is None, reason="sigrok-cli is not installed")
def test_sigrok_reads_the_dump_and_its_session_gives_the_same_ticks(tmp_path):
    """Oracle: an independent program; sigrok samples the dump at 1 MHz, the clock of these ticks."""
    streams = {
        "camera_trigger": [100, 1100, 2100],
        "control_slot": [50, 350, 650, 950, 1250],
        "application_slot": [500, 1500],
        "application_edges": [500, 900, 1500, 1900],
    }
    dump, session = tmp_path / "ticks.vcd", tmp_path / "ticks.sr"
    write_vcd(_recording(streams, 1e6), dump)
    sigrok = ["sigrok-cli", "-I", "vcd:downsample=1000", "-i", str(dump), "-O", "srzip", "-o", str(session)]
    subprocess.run(sigrok, check=True, capture_output=True, timeout=60)
    found = captured_ticks(session, line_map(MAP))
    assert found.clock_frequency_hz == 10**6
    assert {field.name: values.tolist() for field, values in found.streams.items()} == streams
