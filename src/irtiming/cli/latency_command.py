"""`irtiming latency`: latencies of light gates and trigger from recordings, as lines of rig.toml."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from irtiming.cli.options import filled, in_options
from irtiming.cli.screen import say, warn

if TYPE_CHECKING:
    from irtiming.session.latency import LatencyFound

app = typer.Typer(
    name="latency",
    help="How much later than the event its edge is timestamped: of the light gates, and of the trigger.",
    no_args_is_help=True,
)
RigToUpdate = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Write the lines of its section \\[latency] into this rig.toml.")
]
LoopLine = Annotated[Literal["spare", "camera_input"], typer.Option(help="The input to which the trigger is led back.")]
Json = Annotated[Path | None, typer.Option("--json", metavar="OUT", help="Write all numbers there.")]


@in_options
def gates(
    recording: Annotated[
        list[Path],
        typer.Argument(help="Recordings, or timestamps of irtiming gateware record, at two wheel speeds or more."),
    ],
    exchanged: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE", help="A recording with the two gates exchanged, beside one that is not; one speed will do."
        ),
    ] = None,
    place_u_mrad: Annotated[
        float | None,
        typer.Option(
            min=0.0,
            help="By how much the beams may stand elsewhere after the exchange, as an angle about the axle; k = 1.",
        ),
    ] = None,
    photodiode: Annotated[
        str | None,
        typer.Option(
            metavar="TIME", help="A fast photodiode beside a gate is at the spare input; its latency, such as '50 ns'."
        ),
    ] = None,
    photodiode_u: Annotated[str, typer.Option(metavar="TIME", help="Its standard uncertainty.")] = "0 s",
    application_gate: Annotated[
        str | None,
        typer.Option(
            metavar="TIME", help="Latency of the application gate, as by an oscilloscope; else that in rig.toml."
        ),
    ] = None,
    application_gate_u: Annotated[str, typer.Option(metavar="TIME", help="Its standard uncertainty.")] = "0 s",
    rig: RigToUpdate = None,
    json: Json = None,
) -> None:
    """Measure latencies of the light gates: their difference from several wheel speeds, both with a fast photodiode.

    Several speeds alone tell the difference of the two gates, not what both have in common. That takes a photodiode at the spare
    input, or the application gate's latency from an oscilloscope.
    """
    given = locals()
    from irtiming.session.latency import GatesOrder, of_gates

    place = None if place_u_mrad is None else 1e-3 * place_u_mrad
    order = filled(GatesOrder, given, recordings=tuple(recording), place_u_rad=place)
    show(of_gates(order), rig)


@in_options
def loopback(
    recording: Annotated[
        list[Path], typer.Argument(help="Recordings, or timestamps, with camera_out led to an input as well.")
    ],
    line: LoopLine = "spare",
    rig: RigToUpdate = None,
    json: Json = None,
) -> None:
    """Measure how much later than the trigger its edge is stamped when it is led back to an input."""
    given = locals()
    from irtiming.session.latency import LoopOrder, of_trigger

    show(of_trigger(filled(LoopOrder, given, recordings=tuple(recording))), rig)


for command in (gates, loopback):
    app.command()(command)


def show(found: "LatencyFound", rig: Path | None) -> None:
    """Tables and lines of rig.toml, which ``rig`` has taken if it is given."""
    from rich.console import Console

    from irtiming.cli.drawn_table import print_table
    from irtiming.report.blocks import of_tables
    from irtiming.report.sections import latency

    screen = Console()
    for finding in (one for difference in found.differences for one in difference.findings):
        warn(finding.sentence(), screen)
    tables = (
        latency.registers(found.differences),
        latency.differences(found.differences),
        latency.loops(found.loops),
        *(latency.distribution(one) for one in found.loops),
    )
    for table in of_tables(*tables):
        print_table(table, screen)
    if found.latency is None:
        say(
            "no latency is known, only the difference: give --photodiode or --application-gate for lines of rig.toml",
            screen,
        )
        return
    say(f"written into {rig}:" if rig is not None else "for rig.toml:", screen)
    say(found.lines, screen)
