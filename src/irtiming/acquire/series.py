"""Many runs from one plan: references before and after, every temperature, speed and delay, and going on where it stopped."""

import re
from collections.abc import Collection
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import final

from irtiming.acquire import frame_rate
from irtiming.acquire.attendant import Attendant
from irtiming.acquire.journal import Journal
from irtiming.acquire.references import drift, record_references
from irtiming.acquire.rig import Rig
from irtiming.acquire.run import record_run
from irtiming.acquire.run_order import ENOUGH, INTERRUPTED, RunOrder, RunOutcome
from irtiming.acquire.set_aside import free_path, recovered_parts, set_aside
from irtiming.acquire.temperature import as_it_is, celsius, settled
from irtiming.archive import reader
from irtiming.archive.live.recording import COMPLETE
from irtiming.archive.reference_file import add_reference, read_reference, write_reference
from irtiming.errors import InstrumentError, IrTimingError
from irtiming.records.instrument_state import BlackbodyState
from irtiming.records.recording import NonuniformityReference
from irtiming.records.series_plan import SeriesPlan
from irtiming.records.trigger_plan import PlannedRun, TriggerPlan

BEFORE, AFTER = "references-before.npz", "references-after.npz"
_MICROSECONDS = 1e6


@final
@dataclass(frozen=True, kw_only=True)
class NumberedRun:
    """A run by its number in the series, from 1, with the blackbody temperature before which it is made; None: as it is."""

    number: int
    target_k: float | None
    run: PlannedRun


@final
@dataclass(frozen=True, kw_only=True)
class Series:
    """A plan whose triggers are found, and the folder for its recordings. ``numbers`` are the runs to make; None: all."""

    plan: SeriesPlan
    triggers: TriggerPlan
    folder: Path
    numbers: Collection[int] | None = None

    @property
    def runs(self) -> list[NumberedRun]:
        """Every run, in order."""
        wishes = self.plan.blackbody
        temperatures: tuple[float | None, ...] = (None,) if wishes is None else wishes.temperatures_k
        every = [(target_k, run) for target_k in temperatures for run in self.triggers]
        return [NumberedRun(number=n, target_k=target_k, run=run) for n, (target_k, run) in enumerate(every, 1)]

    def to_make(self, journal: Journal) -> list[NumberedRun]:
        """Runs that are asked for and not complete yet."""
        wanted = self.numbers
        return [
            one for one in self.runs
            if (wanted is None or one.number in wanted) and journal.file_of(one.number) is None
        ]  # fmt: skip


@final
@dataclass(frozen=True, kw_only=True)
class SeriesOutcome:
    """What became of a series: runs made now, numbers of those made before, files recovered, and how it ended."""

    outcomes: tuple[RunOutcome, ...]
    made_before: tuple[int, ...]
    recovered: tuple[Path, ...]
    ending: str

    @property
    def is_good(self) -> bool:
        """Whether all was made, or enough."""
        return self.ending in (COMPLETE, ENOUGH)


async def record_series(rig: Rig, series: Series, *, attendant: Attendant, journal: Journal) -> SeriesOutcome:
    """Make all runs that are not complete yet; the checklist must have had no complaint.

    Parameters
    ----------
    rig
        Connected.
    series
        What to make.
    attendant
        Hears what happens, takes wheel and mask out of the way for references, and may end it: the run is then closed with what
        it has.
    journal
        Of the folder.

    Returns
    -------
    What became of it; also where a run ended early, which ends the series.
    """
    made = _Made(rig, series, attendant=attendant, journal=journal)
    recovered = recovered_parts(series.folder, journal=journal, attendant=attendant)
    pending = series.to_make(journal)
    before = tuple(one.number for one in series.runs if journal.file_of(one.number) is not None)
    try:
        ending = await made.make(pending)
    except IrTimingError as error:
        notes = "".join(f" ({note})" for note in getattr(error, "__notes__", ()))
        ending = f"{error}{notes}"
    finally:
        if series.plan.stop.chopper and rig.chopper is not None:
            with suppress(InstrumentError):
                await rig.chopper.stop()
    journal.note(f"ended: {ending}")
    return SeriesOutcome(outcomes=tuple(made.outcomes), made_before=before, recovered=recovered, ending=ending)


@final
class _Made:
    """A series while it is made."""

    def __init__(self, rig: Rig, series: Series, *, attendant: Attendant, journal: Journal) -> None:
        self._rig, self._series, self._attendant, self._journal = rig, series, attendant, journal
        self._latency_s: float | None = None
        self._is_set = False
        self.outcomes: list[RunOutcome] = []

    async def make(self, pending: list[NumberedRun]) -> str:
        """References and runs; gives the ending."""
        if pending:
            self._journal.note(f"begun: runs {', '.join(str(one.number) for one in pending)}")
            await self._set_camera()
        reference = await self._references_before(pending)
        for one in pending:
            if self._attendant.is_leaving():
                return INTERRUPTED
            if self._attendant.is_enough():
                ending = ENOUGH
                break
            ending = await self._run(one, reference=reference)
            if ending == ENOUGH:
                break
            if ending != COMPLETE:
                return ending
        else:
            ending = COMPLETE
        return await self._references_after(ending)

    async def _set_camera(self) -> None:
        """As planned, once: a feature may be a command, such as a correction, that must not come between references and runs."""
        if not self._is_set:
            await set_camera(self._rig, self._series.plan)
            if (slow := await frame_rate.complaint(self._rig.camera, self._series.triggers)) is not None:
                raise InstrumentError(slow)
            self._is_set = True

    async def _run(self, one: NumberedRun, *, reference: NonuniformityReference | None) -> str:
        blackbody = await self._stable(one.target_k)
        if one.target_k is not None and blackbody is None:
            return INTERRUPTED
        correction = self._series.plan.camera.correction
        if correction and one.run.is_after_correction:
            self._attendant.says(f"the camera corrects its non-uniformity ({correction})")
            await self._rig.camera.set_feature(correction, value="execute")
        wishes = self._series.plan.blackbody
        order = RunOrder(
            number=one.number,
            path=self._path_of(one),
            run=one.run,
            camera=self._series.plan.camera,
            nonuniformity=reference,
            blackbody_before=blackbody,
            tolerance_k=0.1 if wishes is None else wishes.tolerance_k,
            usual_latency_s=self._latency_s,
        )
        outcome = await record_run(self._rig, order, attendant=self._attendant)
        if outcome.ending not in (COMPLETE, ENOUGH):
            outcome = replace(outcome, path=set_aside(outcome.path, attendant=self._attendant))
        self.outcomes.append(outcome)
        self._journal.add(outcome)
        if outcome.is_complete:
            self._latency_s = outcome.verdict.latency_s
            return COMPLETE
        return outcome.ending if outcome.ending in (ENOUGH, INTERRUPTED) else f"{outcome.path}: {outcome.ending}"

    async def _stable(self, target_k: float | None) -> BlackbodyState | None:
        """The blackbody at its temperature; as it is where none is asked for; None where there is none."""
        wishes = self._series.plan.blackbody
        if self._rig.blackbody is None:
            return None
        if target_k is None or wishes is None:
            return await as_it_is(self._rig)
        return await settled(self._rig, target_k, wishes=wishes, attendant=self._attendant)

    async def _references_before(self, pending: list[NumberedRun]) -> NonuniformityReference | None:
        """References for the runs to come: recorded earlier, or now; None where they come after the runs."""
        wishes = self._series.plan.references
        if wishes is None or not pending:
            return None
        if wishes.file:
            return read_reference(wishes.file)
        if wishes.when == "after":
            return None
        earlier = self._series.folder / BEFORE
        return read_reference(earlier) if earlier.exists() else await self._recorded_references(earlier)

    async def _references_after(self, ending: str) -> str:
        """References of runs that are over, where they are wished for and every run is made."""
        wishes, path = self._series.plan.references, self._series.folder / AFTER
        files = [self._journal.file_of(one.number) for one in self._series.runs]
        is_due = ending == ENOUGH or all(file is not None for file in files)
        if wishes is None or wishes.file or wishes.when == "before" or not is_due:
            return ending
        reference = read_reference(path) if path.exists() else await self._recorded_references(path)
        if wishes.when == "both":
            self._tell_drift(read_reference(self._series.folder / BEFORE), reference)
        if wishes.when == "after":
            for file in files:
                if file is not None and lacks_reference(file):
                    add_reference(reference, file)
        return ending

    def _tell_drift(self, before: NonuniformityReference, after: NonuniformityReference) -> None:
        mean, spread = drift(before, after)
        text = (
            f"from the references before to those after, the pixels moved by {mean:+.2%} of the contrast, and by {spread:.2%} "
            "against each other; the recordings are corrected by those before"
        )
        self._attendant.says(text)
        self._journal.note(text)

    async def _recorded_references(self, path: Path) -> NonuniformityReference:
        wishes = self._series.plan.references
        if wishes is None:
            raise InstrumentError("no references are planned; write [references]")
        await self._set_camera()
        found = await record_references(
            self._rig,
            wishes,
            run=self._series.triggers.runs[0],
            attendant=self._attendant,
            runs_free=self._series.plan.camera.runs_free,
        )
        if found is None:
            raise InstrumentError(INTERRUPTED)
        write_reference(found, path)
        self._journal.note(f"references recorded: {path.name}")
        return found

    def _path_of(self, one: NumberedRun) -> Path:
        """A name that is free; one that is taken gets a number behind it."""
        clock = self._series.triggers.clock_frequency_hz
        name = self._series.plan.file_name.format(
            utc=datetime.now(UTC).strftime("%Y%m%dT%H%M%SZ"),
            camera=re.sub(r"[^A-Za-z0-9-]+", "-", self._rig.camera.identity.model).strip("-") or "camera",
            speed=f"{clock / one.run.scheme.turn_period_ticks:.4g}Hz",
            delay=f"{one.run.trigger_delay_ticks / clock * 1e3:.6g}ms",
            run=f"{one.number:02d}",
            temperature="as-it-is" if one.target_k is None else celsius(one.target_k).replace(" °", ""),
        )
        return free_path(self._series.folder, name)


def features_of(plan: SeriesPlan) -> tuple[tuple[str, str], ...]:
    """The camera's features as planned, in the order in which they are set: integration time first."""
    window_s = plan.camera.integration_time_s
    first = () if window_s is None else (("ExposureTime", f"{window_s * _MICROSECONDS:.10g}"),)
    return (*first, *plan.camera.features)


async def set_camera(rig: Rig, plan: SeriesPlan) -> None:
    """Set the camera's features as planned, integration time first; each is read back.

    Raises
    ------
    InstrumentError
        If it does not take one.
    """
    for name, value in features_of(plan):
        await rig.camera.set_feature(name, value=value)


def lacks_reference(path: Path) -> bool:
    """Whether a recording has no references yet.

    Raises
    ------
    ArchiveError
        If it cannot be read.
    """
    return reader.read(path).nonuniformity is None
