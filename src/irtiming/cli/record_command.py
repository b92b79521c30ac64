"""`irtiming record`: a series of recordings from one plan.toml."""

import asyncio
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, final

import typer

from irtiming.errors import InstrumentError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.console import Console

    from irtiming.acquire.journal import Journal
    from irtiming.acquire.rig import Rig
    from irtiming.acquire.series import Series, SeriesOutcome
    from irtiming.live_analysis import LiveAnalysis, LiveEstimate
    from irtiming.records.series_plan import SeriesPlan


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

    from irtiming.archive.result_file import require_place
    from irtiming.archive.series_file import read_series
    from irtiming.cli.camera_command import named

    if json is not None:
        require_place(json, besides=[plan])
    series = read_series(plan)
    series = replace(series, camera=replace(series.camera, features=(*series.camera.features, *named(feature or []))))
    with _analysed_live(series, rig, is_dry=dry_run) as live:
        session = _Session(plan=series, folder=out, runs=runs, is_dry=dry_run, is_silent=yes, live=live)
        outcome = asyncio.run(session.record())
        if outcome is None:
            return
        found, journal = outcome
        told = None if live is None else live.settled()
    if told is not None:
        _show_estimate(told)
    if json is not None:
        _summarise(found, journal, told, path=json)
    _show(found, Console(stderr=True, highlight=False))
    if not found.is_good:
        from irtiming.acquire.run import INTERRUPTED

        again = f"; say the same command again to go on in {out}"
        raise InstrumentError(("interrupted" if found.ending == INTERRUPTED else found.ending) + again)


@contextmanager
def _analysed_live(plan: "SeriesPlan", rig: Path | None, *, is_dry: bool) -> "Iterator[LiveAnalysis | None]":
    """The live analysis, where a rig is described; it is there before anything moves."""
    if rig is None:
        if plan.stop.uncertainty_s:
            raise InstrumentError(
                f"{plan.source}: [stop] uncertainty wishes for {plan.stop.uncertainty_s[0][0]}, which needs the rig's numbers; "
                "say --rig rig.toml, or take the wish out"
            )
        yield None
        return
    from irtiming.archive.rig_file import read_rig
    from irtiming.live_analysis import LiveAnalysis

    measured = read_rig(rig)
    if is_dry:
        yield None
        return
    with LiveAnalysis(measured) as live:
        yield live


@final
@dataclass(frozen=True, kw_only=True)
class _Session:
    """What was asked for, from the connection to the last file."""

    plan: "SeriesPlan"
    folder: Path
    runs: str | None
    is_dry: bool
    is_silent: bool
    live: "LiveAnalysis | None"

    async def record(self) -> "tuple[SeriesOutcome, Journal] | None":
        """Connect, go through the checklist, and record."""
        from rich.console import Console

        from irtiming.acquire.checklist import complaints
        from irtiming.acquire.journal import Journal, digest_of
        from irtiming.acquire.rig import RigAbsent, connected_rig
        from irtiming.acquire.series import Series
        from irtiming.cli.series_triggers import chosen_runs, triggers_of

        notes = Console(stderr=True, highlight=False)
        try:
            async with connected_rig(self.plan) as rig:
                triggers = triggers_of(self.plan, clock_frequency_hz=rig.generator.clock_frequency_hz)
                every = Series(plan=self.plan, triggers=triggers, folder=self.folder)
                numbers = None if self.runs is None else chosen_runs(self.runs, len(every.runs))
                series = replace(every, numbers=numbers)
                digest = digest_of(self.plan, triggers)
                journal = Journal.opened(self.folder, digest=digest, n_runs=len(series.runs))
                _refuse(await complaints(rig, series, journal=journal), notes)
                if self.is_dry:
                    _tell_plan(rig, series, journal, notes)
                    return None
                self.folder.mkdir(exist_ok=True)
                return await self._recorded(rig, series, journal, notes=notes), journal
        except RigAbsent as error:
            _refuse(error.complaints, notes)
            raise

    async def _recorded(self, rig: "Rig", series: "Series", journal: "Journal", *, notes: "Console") -> "SeriesOutcome":
        from irtiming.acquire.series import record_series
        from irtiming.cli.person import Person
        from irtiming.cli.progress import shown

        if self.live is not None:
            for number, _, _ in series.runs:
                if (made := journal.file_of(number)) is not None:
                    self.live.keep(made)
            await asyncio.to_thread(self.live.settled)
        with shown("triggers", notes) as told:
            person = Person(self.plan, told=told, notes=notes, is_silent=self.is_silent, live=self.live)
            with person.listening():
                return await record_series(rig, series, attendant=person, journal=journal)


def _refuse(found: list[str], notes: "Console") -> None:
    """End with all complaints: one is the line itself, several stand above it."""
    if len(found) == 1:
        raise InstrumentError(f"{found[0]} (nothing was moved)")
    for text in found:
        notes.print(f"not ready: {' '.join(text.split())}", markup=False, soft_wrap=True)
    if found:
        raise InstrumentError(f"{len(found)} complaints, see above; nothing was moved")


def _tell_plan(rig: "Rig", series: "Series", journal: "Journal", notes: "Console") -> None:
    from irtiming.plan.schedule import run_length_ticks
    from irtiming.units import readable_time

    clock = series.triggers.clock_frequency_hz
    pending = series.to_make(journal)
    ticks = sum(
        run_length_ticks(run.scheme, repeats=run.repeats, trigger_delay_ticks=run.trigger_delay_ticks)
        for _, _, run in pending
    )
    camera = rig.camera.identity
    notes.print(
        f"ready: {camera.vendor} {camera.model} {camera.serial_number}; {len(pending)} of {len(series.runs)} runs to make, "
        f"{readable_time(ticks / clock)} of triggers",
        markup=False, soft_wrap=True,
    )  # fmt: skip


def _show_estimate(told: "LiveEstimate") -> None:
    from rich.console import Console

    from irtiming.cli.person import so_far

    Console(stderr=True, highlight=False).print(f"of the whole series: {so_far(told)}", markup=False, soft_wrap=True)


def _summarise(outcome: "SeriesOutcome", journal: "Journal", told: "LiveEstimate | None", *, path: Path) -> None:
    from irtiming.archive.result_file import write_result

    write_result(
        {
            **journal.as_json(),
            "ending": outcome.ending,
            "made_now": [each.order.number for each in outcome.outcomes],
            "made_before": list(outcome.made_before),
            "recovered": [str(each) for each in outcome.recovered],
            "estimate": None if told is None else asdict(told),
        },
        path,
    )


def _show(outcome: "SeriesOutcome", notes: "Console") -> None:
    if outcome.made_before:
        notes.print(f"made before: runs {', '.join(map(str, outcome.made_before))}", markup=False)
    for each in outcome.outcomes:
        print(each.path)  # noqa: T201 - for a program that reads it
