"""`irtiming record`: a series of recordings from one plan.toml."""

import asyncio
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from irtiming.errors import InstrumentError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.console import Console

    from irtiming.cli.person import Person
    from irtiming.records.series_plan import SeriesPlan
    from irtiming.session.live import LiveAnalysis
    from irtiming.session.series import Attending, SeriesMade, SeriesReady


def record(
    plan: Annotated[Path, typer.Argument(metavar="PLAN", help="plan.toml: devices, camera, runs, temperatures.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the recordings; it is made if it is not there.")],
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
    """Record a series: wheel at speed, blackbody stable, camera armed, triggers, frames and timestamps into one file per run.

    Ctrl-C closes the file with what it has. The same command again goes on where the series was interrupted. With --rig the
    estimate tightens on the screen, and the series ends when the uncertainty that plan.toml wishes for ([stop]) is reached.
    """
    from rich.console import Console

    from irtiming.acquire.rig import RigNotReady
    from irtiming.cli.camera_command import named
    from irtiming.session import series

    notes = Console(stderr=True, highlight=False)
    order = series.SeriesOrder(
        plan=plan, folder=out, features=named(feature or []), runs=runs, rig=rig, summary=json
    )  # fmt: skip
    try:
        if dry_run:
            _show_ready(asyncio.run(series.check(order)), notes)
            return
        _show(asyncio.run(series.record(order, attending=_at_the_terminal(notes, is_silent=yes))), out, notes)
    except RigNotReady as error:
        raise _refused(error.complaints, notes) from error


def _at_the_terminal(notes: "Console", *, is_silent: bool) -> "Attending":
    """Whoever sits there, with a bar for the triggers of each run."""
    from irtiming.cli.person import Person
    from irtiming.cli.progress import shown

    @contextmanager
    def attending(plan: "SeriesPlan", live: "LiveAnalysis | None") -> "Iterator[Person]":
        with shown("triggers", notes) as told:
            person = Person(plan, live, told=told, notes=notes, is_silent=is_silent)
            with person.listening():
                yield person

    return attending


def _refused(complaints: list[str], notes: "Console") -> InstrumentError:
    """The end with all complaints: one is the line itself, several stand above it."""
    from irtiming.cli.screen import say

    if len(complaints) == 1:
        return InstrumentError(f"{complaints[0]} (nothing was moved)")
    for text in complaints:
        say(f"not ready: {' '.join(text.split())}", notes)
    return InstrumentError(f"{len(complaints)} complaints, see above; nothing was moved")


def _show_ready(ready: "SeriesReady", notes: "Console") -> None:
    from irtiming.cli.screen import say
    from irtiming.units import readable_time

    camera = ready.camera
    say(
        f"ready: {camera.vendor} {camera.model} {camera.serial_number}; {ready.n_pending} of {ready.n_runs} runs to make, "
        f"{readable_time(ready.duration_s)} of triggers",
        notes,
    )


def _show(made: "SeriesMade", folder: Path, notes: "Console") -> None:
    """What is known, what was made, and how to go on where it is not all."""
    from irtiming.acquire.run import INTERRUPTED
    from irtiming.cli.person import so_far
    from irtiming.cli.screen import say

    outcome = made.outcome
    if made.estimate is not None:
        say(f"of the whole series: {so_far(made.estimate)}", notes)
    if outcome.made_before:
        say(f"made before: runs {', '.join(map(str, outcome.made_before))}", notes)
    for each in outcome.outcomes:
        print(each.path)  # noqa: T201 - for a program that reads it
    if not outcome.is_good:
        ending = "interrupted" if outcome.ending == INTERRUPTED else outcome.ending
        raise InstrumentError(f"{ending}; say the same command again to go on in {folder}")
