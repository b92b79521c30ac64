"""`irtiming clock`: the trigger generator's clock against a pulse per second, and the camera's clock against it."""

from pathlib import Path
from typing import Annotated

import typer

from irtiming.cli.options import filled, in_options
from irtiming.cli.screen import say, warn


@in_options
def clock(
    recording: Annotated[
        list[Path],
        typer.Argument(
            help="Recordings, or timestamps of irtiming gateware record, with a pulse per second at the spare input."
        ),
    ],
    rig: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the lines of its section \\[clock] into this rig.toml.")
    ] = None,
    pulse_period: Annotated[str, typer.Option(metavar="TIME", help="From pulse to pulse.")] = "1 s",
    pulse_u: Annotated[
        float, typer.Option(min=0.0, max=1e-3, help="Relative standard uncertainty of the rate of the pulses.")
    ] = 0.0,
    json: Annotated[Path | None, typer.Option("--json", metavar="OUT", help="Write all numbers there.")] = None,
    picture: Annotated[
        Path | None, typer.Option(metavar="OUT", help="Draw the pulses and the Allan deviation there, as SVG.")
    ] = None,
) -> None:
    """Measure by how much the trigger generator's clock is wrong, from a pulse per second at its spare input.

    Says how the clock drifts and scatters, and which pulses are missing or extra. Where frames carry timestamps of the camera, it
    also says at what rate the camera's clock runs against the trigger generator's.
    """
    given = locals()
    from rich.console import Console

    from irtiming.cli.drawn_table import print_table
    from irtiming.report.blocks import of_tables
    from irtiming.report.sections import clock as clock_section
    from irtiming.session.clock import ClockOrder, evaluate

    found, screen = evaluate(filled(ClockOrder, given, recordings=tuple(recording))), Console()
    for finding in (one for check in found.checks for one in check.findings):
        warn(finding.sentence(), screen)
    tables = (
        clock_section.errors(found.checks),
        clock_section.stability(found.checks),
        clock_section.cameras(found.cameras),
    )
    for table in of_tables(*tables):
        print_table(table, screen)
    if found.clock is None:
        say("no pulses at the spare input: what the trigger generator's clock is worth is not known", screen)
        return
    say(f"written into {rig}:" if rig is not None else "for rig.toml:", screen)
    say(found.lines, screen)
