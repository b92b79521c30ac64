"""``irtiming calibrate-wheel``: the timestamps of recordings in, the wheel's slots, edges and ripple out."""

from pathlib import Path
from typing import Annotated

import typer

from irtiming.cli.options import Edge, RigFile, filled
from irtiming.cli.screen import warn


def calibrate_wheel(
    recording: Annotated[
        list[Path], typer.Argument(help="Recordings of one wheel, of any camera, at any speeds, in any order.")
    ],
    rig: RigFile,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="OUT", help="Write the calibration there, as JSON.")],
    picture: Annotated[
        Path | None, typer.Option(metavar="OUT", help="Draw the slots and their orders there, as SVG.")
    ] = None,
    reference_edge: Edge = "automatic",
) -> None:
    """Angles of the control slots and application edges from the timestamps alone; frames are not looked at.

    With recordings at two or more speeds, the fastest at least 1.2 times as fast as the slowest, a speed ripple that repeats
    every turn is distinguished from the slots. `irtiming analyse --wheel-calibration` takes the result.
    """
    given = locals()
    from rich.console import Console

    from irtiming.cli.drawn_table import print_table
    from irtiming.report.sections import wheel as wheel_section
    from irtiming.session.wheel import CalibrationOrder, calibrate

    order = filled(CalibrationOrder, given, recordings=tuple(recording), calibration=out)
    wheel, screen = calibrate(order), Console()
    for text in wheel.warnings:
        warn(text, screen)
    for table in (wheel_section.summary(wheel), wheel_section.speeds(wheel), wheel_section.orders(wheel)):
        print_table(table, screen)
