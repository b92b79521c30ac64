"""From lines to tick streams: edges, clocks and glitches."""

import re
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from irtiming.archive.captures.capture import Line, hertz
from irtiming.archive.captures.streams import captured_ticks, line_map, to_ticks, without_glitches
from irtiming.errors import ArchiveError

MAP = "camera_trigger=D0,control_slot=!D1,application_slot=D2,application_edges=D2"
VCD = """$timescale 10 ns $end
$var wire 1 ! D0 $end
$var wire 1 " D1 $end
$var wire 1 # D2 $end
$enddefinitions $end
#0 0! 1" 1#
#100 0"
#200 1! 1" 0#
#300 0! 0"
#400 1! 1#
#401 0#
#500 1#
"""


@pytest.fixture
def capture(tmp_path):
    path = tmp_path / "capture.vcd"
    path.write_text(VCD)
    return path


def _streams(path, text=MAP, **options):
    found = captured_ticks(path, line_map(text), **options)
    return found.clock_frequency_hz, {field.name: values.tolist() for field, values in found.streams.items()}


def test_the_right_edge_of_each_line_becomes_a_tick(capture):
    """Oracle: by hand; rising, falling, rising and both edges of the lines above, in ticks of 10 ns."""
    assert _streams(capture) == (
        100_000_000,
        {
            "camera_trigger": [200, 400],
            "control_slot": [100, 300],
            "application_slot": [400, 500],
            "application_edges": [200, 400, 401, 500],
        },
    )


def test_ticks_of_another_clock_are_rounded_to_the_nearest(capture):
    """Oracle: by hand; 4.01 µs at 48 MHz is 192.48 ticks."""
    clock, streams = _streams(capture, clock_hz=48_000_000)
    assert (clock, streams["application_edges"]) == (48_000_000, [96, 192, 192, 240])


def test_levels_shorter_than_a_glitch_are_left_out(capture):
    """Oracle: by hand; the level of 10 ns goes and takes the edge after it along, one of 990 ns stays."""
    assert _streams(capture, shortest_s=11e-9)[1]["application_edges"] == [200, 500]
    assert _streams(capture, shortest_s=10e-9)[1]["application_edges"] == [200, 400, 401, 500]


@pytest.mark.parametrize(
    ("changes", "shortest", "left"),
    [
        ([10, 12, 14, 100, 102, 200], 3, [14, 200]),
        ([10, 12, 14, 100, 102, 200], 2, [10, 12, 14, 100, 102, 200]),
        ([10, 11], 5, []),
        ([10], 5, [10]),
        ([], 5, []),
        ([10, 10, 20, 20], 0, [10, 10, 20, 20]),
        ([10, 10, 20, 20], 1, []),
    ],
)
def test_a_bouncing_edge_counts_from_its_last_change(changes, shortest, left):
    """Oracle: by hand."""
    line = Line(initial=1, changes=np.array(changes, np.int64))
    assert without_glitches(line, shortest).changes.tolist() == left


@given(
    count=st.integers(-(2**62), 2**62),
    clock=st.integers(1, 10**9),
    per_second=st.sampled_from([10**9, 10**12, 24_000_000, 10**10]),
)
def test_counts_become_the_nearest_tick_however_large(count, clock, per_second):
    """Oracle: a law in fractions; not more than half a tick away."""
    ratio = Fraction(clock, per_second)
    if abs(count * ratio) < 2**62:
        (tick,) = to_ticks(np.array([count]), ratio).tolist()
        assert abs(tick - count * ratio) <= Fraction(1, 2)


@pytest.mark.parametrize(
    ("text", "rate"),
    [
        ("24 MHz", 24_000_000),
        ("49.152MHz", 49_152_000),
        ("32.768 kHz", 32_768),
        ("1GHz", 10**9),
        ("500 Hz", 500),
        ("0 Hz", None),
        ("1.5 Hz", None),
        ("24", None),
        ("fast", None),
    ],
)
def test_frequencies_are_read_exactly(text, rate):
    """Oracle: by hand."""
    assert hertz(text) == rate


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("camera_trigger=D0", "control_slot and application_slot is missing"),
        ("camera_triger=D0", "did you mean 'camera_trigger'"),
        ("camera_trigger", "is no STREAM=LINE"),
        ("camera_trigger=!", "is no STREAM=LINE"),
        ("camera_trigger=D0,camera_trigger=D1", "is given twice"),
        (MAP.replace("edges=D2", "edges=!D2"), "takes both edges"),
    ],
)
def test_a_map_that_cannot_be_is_refused(text, says):
    """Oracle: the message for each mistake."""
    with pytest.raises(ArchiveError, match=says):
        line_map(text)


def test_a_trigger_that_is_active_at_the_beginning_is_refused_with_the_other_edge(capture):
    """Oracle: D1 of the capture begins high; its falling edge would do."""
    with pytest.raises(ArchiveError, match="'D1' of camera_trigger is active already .* camera_trigger=!D1"):
        _streams(capture, "camera_trigger=D1,control_slot=D0,application_slot=D2")
    with pytest.raises(ArchiveError, match="'D0' of camera_trigger is active already .* camera_trigger=D0"):
        _streams(capture, "camera_trigger=!D0,control_slot=D0,application_slot=D2")


def test_a_line_without_its_edge_is_told(tmp_path):
    """Oracle: a line that falls once and never rises, in a capture of 5 µs."""
    path = tmp_path / "capture.vcd"
    path.write_text(VCD.split("#200")[0] + "#500\n")
    with pytest.raises(
        ArchiveError, match="'D0' of camera_trigger has no rising edge in 5 µs; check cable and threshold"
    ):
        _streams(path)


def test_a_clock_that_makes_too_many_ticks_is_refused(tmp_path):
    """Oracle: 2^62 times 10 ns at 1 THz are more than 63 bits."""
    path = tmp_path / "capture.vcd"
    path.write_text(f'{VCD}#{2**62} 1! 1" 0#\n#{2**62 + 5} 0!\n#{2**62 + 9} 1!\n')
    with pytest.raises(ArchiveError, match="more ticks of 1000000000000 Hz than 63 bits can count"):
        _streams(path, clock_hz=10**12)


def test_the_unit_of_time_is_the_clock_where_no_rate_is_told_but_not_finer_than_1_ns(tmp_path):
    """Oracle: by hand; a picosecond's dump gives ticks of 1 ns, 10 ns stay 10 ns (above)."""
    path = tmp_path / "capture.vcd"
    path.write_text(re.sub(r"^#(\d+)", r"#\g<1>000", VCD, flags=re.MULTILINE).replace("10 ns", "1 ps"))
    assert _streams(path)[0] == 10**9
    assert _streams(path)[1]["camera_trigger"] == [200, 400]
