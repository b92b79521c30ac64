"""`irtiming record`: a series of recordings from one plan.toml."""

import asyncio
from pathlib import Path
from typing import Annotated

import typer

from irtiming.cli.options import filled


def record(
    plan: Annotated[Path, typer.Argument(metavar="PLAN", help="plan.toml: devices, camera, runs, temperatures.")],
    out: Annotated[
        Path,
        typer.Option("--out", "-o", metavar="DIR", help="Folder for the recordings; it is made if it is not there."),
    ],
    rig: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="rig.toml: analyse while frames arrive, and show what is known so far."),
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Ask nothing: wheel and mask are as they must be.")] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only go through the checklist: nothing moves, heats or is written.")
    ] = False,
    feature: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="GenICam feature of the camera, such as TriggerSource=Line1; repeatable.",
        ),
    ] = None,
    runs: Annotated[str | None, typer.Option(metavar="N", help="Only these runs of the series, such as 1,3-5.")] = None,
    json: Annotated[Path | None, typer.Option("--json", metavar="OUT", help="Write a summary there.")] = None,
) -> None:
    r"""Record a series: wheel at speed, blackbody stable, camera armed, triggers, frames and timestamps into one file per run.

    Ctrl-C closes the file with what it has. The same command again goes on where the series was interrupted. With --rig the
    estimate tightens on the screen, and the series ends when the uncertainty that plan.toml wishes for (\[stop]) is reached.
    """
    given = locals()
    from rich.console import Console

    from irtiming.acquire.rig import RigNotReady
    from irtiming.cli import person
    from irtiming.cli.camera_command import named
    from irtiming.session import series

    notes = Console(stderr=True, highlight=False)
    order = filled(series.SeriesOrder, given, folder=out, features=named(feature or []), summary=json)
    try:
        if dry_run:
            person.show_ready(asyncio.run(series.check(order)), notes)
        else:
            attending = person.at_the_terminal(notes, is_silent=yes)
            person.show_made(asyncio.run(series.record(order, attending=attending)), notes, folder=out)
    except RigNotReady as error:
        raise person.refused(error.complaints, notes) from error
