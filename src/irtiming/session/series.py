"""A series of recordings from one plan.toml, with looks at what is known so far while frames arrive."""

import asyncio
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import AbstractContextManager, asynccontextmanager, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, final

from irtiming.acquire import rig as devices
from irtiming.acquire.attendant import Attendant
from irtiming.acquire.checklist import complaints
from irtiming.acquire.journal import NAME as JOURNAL
from irtiming.acquire.journal import Journal, digest_of
from irtiming.acquire.rig import RigNotReady
from irtiming.acquire.run_order import ENOUGH, RunOutcome
from irtiming.acquire.series import Series, SeriesOutcome, record_series
from irtiming.archive.json_file import require_places, write_json
from irtiming.archive.live.recording import COMPLETE
from irtiming.archive.rig_file import read_rig
from irtiming.archive.series_file import read_series
from irtiming.errors import InstrumentError
from irtiming.plan.schedule import run_length_ticks
from irtiming.records.camera_frame import CameraIdentity
from irtiming.records.rig import Rig
from irtiming.records.series_plan import SeriesPlan
from irtiming.records.trigger_plan import PlannedRun
from irtiming.session.live import LiveAnalysis
from irtiming.session.live_estimate import LiveEstimate
from irtiming.session.triggers import chosen_runs, triggers_of


@final
@dataclass(frozen=True, kw_only=True)
class SeriesOrder:
    """What a person wants recorded.

    ``features`` of the camera come after those of the plan; ``runs`` are text such as "1,3-5", None for all. With the ``rig``'s
    numbers there is an estimate while frames arrive. A ``summary`` is written where one is named.
    """

    plan: Path
    folder: Path
    features: tuple[tuple[str, str], ...] = ()
    runs: str | None = None
    rig: Path | None = None
    summary: Path | None = None


@final
@dataclass(frozen=True, kw_only=True)
class SeriesReady:
    """A rig that can begin: its camera, runs to make of all, and how long their triggers take."""

    camera: CameraIdentity
    n_pending: int
    n_runs: int
    duration_s: float


@final
@dataclass(frozen=True, kw_only=True)
class SeriesMade:
    """What became of a series, its journal, and what is known at the end; None where no rig was described."""

    outcome: SeriesOutcome
    journal: Journal
    estimate: LiveEstimate | None

    def as_json(self) -> dict[str, Any]:
        """The same as plain data."""
        return {
            **self.journal.as_json(),
            "ending": self.outcome.ending,
            "made_now": [each.order.number for each in self.outcome.outcomes],
            "made_before": list(self.outcome.made_before),
            "recovered": [str(each) for each in self.outcome.recovered],
            "estimate": None if self.estimate is None else self.estimate.as_json(),
        }


class LiveAttendant(Attendant):
    """Hands the live analysis what comes, and ends the series when every uncertainty that was wished for is reached.

    Parameters
    ----------
    plan
        With the wishes.
    live
        None where no rig was described.
    """

    def __init__(self, plan: SeriesPlan, live: LiveAnalysis | None) -> None:
        self._live, self._wished = live, dict(plan.stop.uncertainty_s)
        self._known: LiveEstimate | None = None
        self._growing = Path()

    def learns(self, estimate: LiveEstimate) -> None:
        """Something else is known than before; override what is of interest."""

    def begins(self, run: PlannedRun, *, number: int, path: Path) -> None:
        """A new file is looked at."""
        self._growing = path
        if self._live is not None:
            self._live.begins()

    def goes_on(self, *, made: int, total: int, frames: int, lost: int, waiting: int) -> None:
        """The file is looked at again when it has grown enough."""
        if self._live is None:
            return
        self._live.grows(self._growing, frames)
        latest = self._live.latest
        if latest is not None and latest is not self._known:
            self._known = latest
            self.learns(latest)

    def ended(self, outcome: RunOutcome) -> None:
        """A recording that is good goes into all estimates."""
        if self._live is not None and outcome.ending in (COMPLETE, ENOUGH):
            self._live.keep(outcome.path)

    def is_enough(self) -> bool:
        """When the live analysis says that every wish is reached."""
        latest = None if self._live is None else self._live.latest
        return latest is not None and latest.reaches(self._wished)


Attending = Callable[[SeriesPlan, LiveAnalysis | None], AbstractContextManager[LiveAttendant]]
"""Gives whoever is at the rig for the time of a series."""


@final
@dataclass(frozen=True, kw_only=True)
class _Prepared:
    """A rig without complaint, and what is to be made with it."""

    rig: devices.Rig
    series: Series
    journal: Journal


async def check(order: SeriesOrder) -> SeriesReady:
    """Go through the checklist; nothing moves, heats or is written.

    Raises
    ------
    RigNotReady
        With every complaint about the rig.
    IrTimingError
        If a file of the order cannot be read.
    """
    plan = _plan(order)
    _measured(order, plan)
    async with _prepared(order, plan) as found:
        series = found.series
        pending = series.to_make(found.journal)
        ticks = sum(
            run_length_ticks(one.run.scheme, repeats=one.run.repeats, trigger_delay_ticks=one.run.trigger_delay_ticks)
            for one in pending
        )
        return SeriesReady(
            camera=found.rig.camera.identity,
            n_pending=len(pending),
            n_runs=len(series.runs),
            duration_s=ticks / series.triggers.clock_frequency_hz,
        )


async def record(order: SeriesOrder, *, attending: Attending) -> SeriesMade:
    """Connect the devices, go through the checklist, and make all runs that are not complete yet.

    Returns
    -------
    What became of it; also where it ended early.

    Raises
    ------
    RigNotReady
        With every complaint about the rig; nothing has moved then.
    IrTimingError
        If a file of the order cannot be read or written.
    """
    plan = _plan(order)
    with _live(_measured(order, plan)) as live:
        async with _prepared(order, plan) as found:
            await _keep_made(found, live)
            order.folder.mkdir(exist_ok=True)
            with attending(plan, live) as attendant:
                outcome = await record_series(found.rig, found.series, attendant=attendant, journal=found.journal)
        estimate = None if live is None else await asyncio.to_thread(live.settled)
    made = SeriesMade(outcome=outcome, journal=found.journal, estimate=estimate)
    if order.summary is not None:
        write_json(made.as_json(), order.summary)
    return made


def _plan(order: SeriesOrder) -> SeriesPlan:
    plan = read_series(order.plan)
    frames = None if plan.references is None else plan.references.file
    read = [order.plan, order.rig, plan.plan_file, frames, order.folder / JOURNAL]
    require_places({"JSON": [order.summary]}, inputs=read)
    return replace(plan, camera=replace(plan.camera, features=(*plan.camera.features, *order.features)))


def _measured(order: SeriesOrder, plan: SeriesPlan) -> Rig | None:
    """The rig's numbers, which a wish for an uncertainty needs."""
    if order.rig is not None:
        return read_rig(order.rig)
    if plan.stop.uncertainty_s:
        raise InstrumentError(
            f"{plan.source}: [stop] uncertainty wishes for {plan.stop.uncertainty_s[0][0]}, which needs the rig's numbers; "
            "say --rig rig.toml, or take the wish out"
        )
    return None


@contextmanager
def _live(rig: Rig | None) -> Iterator[LiveAnalysis | None]:
    """The live analysis, where a rig is described; it is there before anything moves."""
    if rig is None:
        yield None
        return
    with LiveAnalysis(rig) as live:
        yield live


@asynccontextmanager
async def _prepared(order: SeriesOrder, plan: SeriesPlan) -> AsyncIterator[_Prepared]:
    """The devices while they are connected, without any complaint of the checklist."""
    async with devices.connected_rig(plan) as rig:
        triggers = triggers_of(plan, clock_frequency_hz=rig.generator.clock_frequency_hz)
        every = Series(plan=plan, triggers=triggers, folder=order.folder)
        numbers = None if order.runs is None else chosen_runs(order.runs, len(every.runs))
        series = replace(every, numbers=numbers)
        journal = Journal.opened(order.folder, digest=digest_of(plan, triggers), n_runs=len(series.runs))
        if found := await complaints(rig, series, journal=journal):
            raise RigNotReady(found)
        yield _Prepared(rig=rig, series=series, journal=journal)


async def _keep_made(found: _Prepared, live: LiveAnalysis | None) -> None:
    """What was recorded before is part of every estimate."""
    if live is None:
        return
    for one in found.series.runs:
        if (made := found.journal.file_of(one.number)) is not None:
            live.keep(made)
    await asyncio.to_thread(live.settled)
