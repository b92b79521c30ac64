"""`irtiming gateware build`: the trigger generator as bits for an FPGA board."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from irtiming.archive.json_file import require_places, write_json
from irtiming.gateware.boards import BOARDS, find_board
from irtiming.gateware.build import BuildReport
from irtiming.gateware.build import build as build_for

_NAMES = ", ".join(board.name for board in BOARDS)


def build(
    board: Annotated[str, typer.Option("--board", help=f"One of {_NAMES}.", metavar="NAME")],
    into: Annotated[
        Path | None, typer.Option("--into", help="Folder for all files; build/NAME if not given.", metavar="FOLDER")
    ] = None,
    seed: Annotated[
        int | None, typer.Option("--seed", help="Where place and route begins; the board's own if not given.", min=0)
    ] = None,
    json: Annotated[Path | None, typer.Option("--json", help="Write the report there.", metavar="OUT")] = None,
) -> None:
    """Build the trigger generator for an FPGA board: bitstream, pin file, timing report.

    Needs irtiming with its extra "gateware", nothing else. Exit status 2 if the circuit would be too slow for the board.
    """
    screen = Console()
    require_places({"JSON": [json]})
    chosen = find_board(board)
    folder = Path("build") / chosen.name if into is None else into
    with screen.status(f"building for {chosen.title}"):
        report = build_for(chosen, folder, seed=seed)
    if json is not None:
        write_json(_plain(report), json)
    _show(report, screen)


def _plain(report: BuildReport) -> dict[str, object]:
    return {key: str(value) if isinstance(value, Path) else value for key, value in asdict(report).items()}


def _show(report: BuildReport, screen: Console) -> None:
    ratio = report.highest_frequency_hz / report.clock_frequency_hz
    table = Table(title=f"Trigger generator on {report.board}", title_justify="left", show_header=False)
    table.add_row("clock", f"{report.clock_frequency_hz / 1e6:g} MHz")
    table.add_row("highest clock", f"{report.highest_frequency_hz / 1e6:.1f} MHz, {ratio:.2f} times as high")
    for cell, (used, available) in report.resources.items():
        table.add_row(cell, f"{used} of {available}")
    table.add_row("seed", str(report.seed))
    table.add_row("bitstream", str(report.bitstream))
    table.add_row("SHA-256", report.bitstream_sha256)
    table.add_row("pin file", str(report.pin_file))
    table.add_row("timing report", str(report.timing_report))
    screen.print(table)
