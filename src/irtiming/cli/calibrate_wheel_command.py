"""``irtiming calibrate-wheel``: the timestamps of recordings in, the wheel's slots, edges and ripple out."""

from pathlib import Path
from typing import Annotated

import typer

from irtiming.errors import ArchiveError
from irtiming.records.choices import ReferenceEdge


def calibrate_wheel(
    recording: Annotated[
        list[Path], typer.Argument(help="Recordings of one wheel, of any camera, at any speeds, in any order.")
    ],
    rig: Annotated[Path, typer.Option(help="What was measured on the rig (rig.toml).")],
    out: Annotated[Path, typer.Option(metavar="OUT", help="Write the calibration there, as JSON.")],
    picture: Annotated[
        Path | None, typer.Option(metavar="OUT", help="Draw the slots and their orders there, as SVG.")
    ] = None,
    reference_edge: Annotated[
        ReferenceEdge,
        typer.Option(help="Which application edge is the angle zero; automatic: before the longer half turn."),
    ] = "automatic",
) -> None:
    """Angles of the control slots and application edges from the timestamps alone; frames are not looked at.

    With recordings at two or more speeds, the fastest at least 1.2 times as fast as the slowest, a speed ripple that repeats
    every turn is told from the slots. `irtiming analyse --wheel-calibration` takes the result.
    """
    from rich.console import Console
    from rich.markup import escape

    from irtiming.archive import reader, result_file, rig_file
    from irtiming.archive.wheel_calibration_file import write_wheel_calibration
    from irtiming.cli.result_table import print_table
    from irtiming.reduce import wheel_calibration
    from irtiming.report import sheet, wheel_figures, wheel_tables

    result_file.require_place(out, besides=[*recording, rig])
    if picture is not None:
        if picture.suffix.lower() != ".svg":
            raise ArchiveError(f"{picture}: the picture is an SVG drawing; give it a name that ends in .svg")
        result_file.require_place(picture, besides=[*recording, rig, out])
    owner = rig_file.read_rig(rig)
    wheel = wheel_calibration.from_recordings(
        (reader.read(path) for path in recording), owner, reference_edge=reference_edge
    )
    write_wheel_calibration(wheel, out)
    if picture is not None:
        drawing = sheet.svg(wheel_figures.calibration(wheel), title="Deviation of the control slots, and its orders")
        result_file.write_atomically(drawing, picture)
    screen = Console()
    for text in wheel.warnings:
        screen.print(f"[yellow]warning:[/yellow] {escape(text)}", highlight=False)
    for table in (wheel_tables.summary(wheel), wheel_tables.speeds(wheel), wheel_tables.orders(wheel)):
        print_table(table, screen)
