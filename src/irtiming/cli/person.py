"""Whoever sits at the terminal while a series is recorded."""

import asyncio
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Thread
from typing import Literal, final

from rich.console import Console

from irtiming.acquire.run_order import INTERRUPTED, RunOutcome
from irtiming.archive.held_signals import SIGNALS
from irtiming.cli.interrupt import Interrupt
from irtiming.cli.progress import Told, shown
from irtiming.cli.screen import say
from irtiming.errors import InstrumentError
from irtiming.records.series_plan import SeriesPlan
from irtiming.records.trigger_plan import PlannedRun
from irtiming.session.live import LiveAnalysis
from irtiming.session.live_estimate import LiveEstimate
from irtiming.session.series import Attending, LiveAttendant, SeriesMade, SeriesReady
from irtiming.session.series_words import WHEEL_REQUESTS, obey, of_run, so_far
from irtiming.units import counted, readable_time

_MANY, _GROWS = 8, 2
"""Frames that wait for the disk: reported when they are this many times more than at the last report, and than so many."""


@final
class Person(LiveAttendant):
    """Whoever sits at the terminal: reads, presses Enter, and leaves by Ctrl-C; the second Ctrl-C is as always."""

    def __init__(
        self, plan: SeriesPlan, live: LiveAnalysis | None = None, *, told: Told, notes: Console, is_silent: bool
    ) -> None:
        super().__init__(plan, live)
        self._told, self._notes, self._is_silent = told, notes, is_silent
        self._command = "" if plan.references is None else plan.references.command
        self._name = ""
        self._leaves = False
        self._lost, self._waiting = 0, _MANY

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Ctrl-C and SIGTERM ask for a clean end within the block."""
        loop, before = asyncio.get_running_loop(), {number: signal.getsignal(number) for number in SIGNALS}

        def leave(number: signal.Signals) -> None:
            self._leaves = True
            if isinstance(handler := before[number], Interrupt):
                handler.heard = number
            self._notes.print("closing the recording; Ctrl-C again breaks it off", markup=False)
            as_always(number)

        def as_always(number: signal.Signals) -> None:
            if loop.remove_signal_handler(number):
                signal.signal(number, before[number])

        with suppress(NotImplementedError, RuntimeError, ValueError):  # not everywhere, and in the main thread only
            for number in SIGNALS:
                loop.add_signal_handler(number, leave, number)
        try:
            yield
        finally:
            with suppress(NotImplementedError, RuntimeError, ValueError):
                for number in SIGNALS:
                    as_always(number)

    def is_leaving(self) -> bool:
        """After Ctrl-C."""
        return self._leaves

    def says(self, text: str) -> None:
        """One line."""
        say(text, self._notes)

    def begins(self, run: PlannedRun, *, number: int, path: Path) -> None:
        """The run's name stands beside its bar."""
        super().begins(run, number=number, path=path)
        self._name = f"run {number} {path.name}"
        self._lost, self._waiting = 0, _MANY

    def goes_on(self, *, made: int, total: int, frames: int, lost: int, waiting: int) -> None:
        """The bar; what is out of the ordinary stands behind the name."""
        if lost > self._lost:
            self.says(f"{self._name}: trigger {made}: {counted(lost, 'trigger')} without a frame so far")
        if waiting > _GROWS * self._waiting:
            self.says(f"{self._name}: trigger {made}: {waiting} frames wait for the disk")
        self._lost, self._waiting = max(lost, self._lost), max(waiting, self._waiting)
        self._told(self._name, made, total)
        super().goes_on(made=made, total=total, frames=frames, lost=lost, waiting=waiting)

    def ended(self, outcome: RunOutcome) -> None:
        """One line for the run, and one for each oddity."""
        for line in of_run(outcome):
            self.says(line)
        super().ended(outcome)

    def learns(self, estimate: LiveEstimate) -> None:
        """What is known so far."""
        self.says(f"so far: {so_far(estimate)}")

    async def move_wheel(self, what: Literal["remove", "insert"]) -> None:
        """By the laboratory's own command, by hand, or as it is."""
        if self._command:
            await obey(self._command, what)
        elif not self._is_silent:
            await self._asked(WHEEL_REQUESTS[what])

    async def _asked(self, text: str) -> None:
        """Wait for Enter, or for Ctrl-C."""
        answer: list[bool] = []

        def wait() -> None:
            try:
                input(f"{text}, then press Enter ")
                answer.append(True)
            except (EOFError, OSError, ValueError):
                answer.append(False)

        Thread(target=wait, daemon=True).start()
        while not answer:
            if self._leaves:
                raise InstrumentError(INTERRUPTED)
            await asyncio.sleep(0.05)
        if not answer[0]:
            raise InstrumentError(
                "wheel and mask must be taken out of the way, and there is no one to do it; say --yes if they are, or name a "
                "command in [references]"
            )


def at_the_terminal(notes: Console, *, is_silent: bool) -> Attending:
    """Whoever sits there while a series is recorded, with a bar for the triggers of each run."""

    @contextmanager
    def attending(plan: SeriesPlan, live: LiveAnalysis | None) -> Iterator[Person]:
        with shown("triggers", notes) as told:
            person = Person(plan, live, told=told, notes=notes, is_silent=is_silent)
            with person.listening():
                yield person

    return attending


def refused(complaints: Sequence[str], notes: Console) -> InstrumentError:
    """The end with all complaints: one is the line itself, several stand above it."""
    if len(complaints) == 1:
        return InstrumentError(f"{complaints[0]} (nothing was moved)")
    for text in complaints:
        say(f"not ready: {' '.join(text.split())}", notes)
    return InstrumentError(f"{len(complaints)} complaints, see above; nothing was moved")


def show_ready(ready: SeriesReady, notes: Console) -> None:
    """What would be made, in one line."""
    camera = ready.camera
    say(
        f"ready: {camera.vendor} {camera.model} {camera.serial_number}; {ready.n_pending} of {ready.n_runs} runs to make, "
        f"{readable_time(ready.duration_s)} of triggers",
        notes,
    )


def show_made(made: SeriesMade, notes: Console, *, folder: Path) -> None:
    """What is known and what was made; the names of the files go to standard output.

    Raises
    ------
    InstrumentError
        If it is not all: it says how to go on.
    """
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
