"""A series of recordings, watched by whoever looks at the page."""

import asyncio
import io
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from time import monotonic
from typing import Any, Literal, final

import numpy as np
from PIL import Image

from irtiming.acquire.rig import RigNotReady
from irtiming.acquire.run_order import INTERRUPTED, RunOutcome
from irtiming.archive.series_file import read_series
from irtiming.errors import InstrumentError
from irtiming.records.camera_frame import CameraFrame
from irtiming.records.series_plan import SeriesPlan
from irtiming.records.timestamps import Timestamps
from irtiming.records.trigger_plan import PlannedRun
from irtiming.session import edges_seen, series
from irtiming.session.live import LiveAnalysis
from irtiming.session.live_estimate import LiveEstimate
from irtiming.session.live_view import LiveView
from irtiming.session.series import LiveAttendant, SeriesOrder
from irtiming.session.series_words import WHEEL_REQUESTS, obey, of_run, so_far
from irtiming.web.orders import RecordingOrder
from irtiming.web.work import LEAVE, MOVED, Line

_PICTURE_S, _EDGES_S = 0.09, 0.4
_ORANGE = (255, 159, 28)


def record(line: Line, order: RecordingOrder) -> dict[str, Any]:
    """Record the series; gives what became of it.

    Raises
    ------
    InstrumentError
        With every complaint about the rig.
    """
    wanted = SeriesOrder(plan=order.plan, folder=order.folder, rig=order.rig)
    try:
        if order.checks_only:
            ready = asyncio.run(series.check(wanted))
            return {"ready": asdict(ready)}
        made = asyncio.run(series.record(wanted, attending=_attending(line, order)))
        if made.estimate is not None:
            line.fact("last_estimate", _estimate(made.estimate))
        return _told(made, order.folder)
    except RigNotReady as error:
        line.fact("complaints", [" ".join(text.split()) for text in error.complaints])
        raise InstrumentError("the rig is not ready, nothing was moved; see what it lacks") from error


def command_of(line: Line, plan: Path) -> str:
    """The program that a plan runs for its references; empty where it runs none."""
    references = read_series(plan).references
    return "" if references is None else references.command


def _told(made: series.SeriesMade, folder: Path) -> dict[str, Any]:
    outcome = made.outcome
    return {
        "folder": str(folder),
        "files": [str(one.path) for one in outcome.outcomes],
        "made_before": list(outcome.made_before),
        "is_good": outcome.is_good,
        "ending": "interrupted" if outcome.ending == INTERRUPTED else outcome.ending,
    }


def _estimate(estimate: LiveEstimate) -> dict[str, Any]:
    return estimate.as_json() | {"sentence": so_far(estimate)}


def _attending(line: Line, order: RecordingOrder) -> series.Attending:
    @contextmanager
    def attending(plan: SeriesPlan, live: LiveAnalysis | None) -> Iterator[LiveAttendant]:
        yield Watcher(plan, live, line=line, is_silent=order.is_silent)
        if live is not None:
            line.says("all is recorded; the estimate of it all is being made")

    return attending


@final
class Watcher(LiveAttendant):
    """Tells the server all that happens, and hears what is wanted."""

    def __init__(self, plan: SeriesPlan, live: LiveAnalysis | None, *, line: Line, is_silent: bool) -> None:
        super().__init__(plan, live)
        self._line, self._is_silent = line, is_silent
        self._command = "" if plan.references is None else plan.references.command
        self._run: PlannedRun | None = None
        self._name = ""
        self._view = LiveView()
        self._estimates: list[dict[str, Any]] = []
        self._pictured_s = self._saw_s = 0.0

    def is_leaving(self) -> bool:
        """After a click on Stop."""
        return self._line.hears(LEAVE)

    def says(self, text: str) -> None:
        """One line."""
        self._line.says(text)

    def begins(self, run: PlannedRun, *, number: int, path: Path) -> None:
        """The run's name stands beside its bar."""
        super().begins(run, number=number, path=path)
        self._run, self._name = run, f"run {number}"
        self._view.begin()
        self._line.fact("run", {"number": number, "file": path.name})

    def goes_on(self, *, made: int, total: int, frames: int, lost: int, waiting: int) -> None:
        """The bar, and what is out of the ordinary."""
        self._line.step(self._name, done=made, total=total)
        self._line.fact("frames", {"frames": frames, "lost": lost, "waiting": waiting})
        super().goes_on(made=made, total=total, frames=frames, lost=lost, waiting=waiting)

    def sees(self, timestamps: Timestamps) -> None:
        """How the lines stand."""
        if self._run is not None and monotonic() - self._saw_s > _EDGES_S:
            self._saw_s = monotonic()
            found = edges_seen.seen(timestamps, self._run.scheme)
            self._line.fact("edges", asdict(found) | {"is_well": [one.is_well for one in found.lines]})

    def written(self, frame: CameraFrame, *, number: int) -> None:
        """A picture, a few times a second; called in the thread that writes."""
        if monotonic() - self._pictured_s < _PICTURE_S:
            return
        self._pictured_s = monotonic()
        view = self._view.look(frame.pixels)
        colours = np.repeat(view.grey[:, :, np.newaxis], 3, axis=2)
        colours[view.outline] = _ORANGE
        file = io.BytesIO()
        Image.fromarray(colours).save(file, "JPEG", quality=85)
        self._line.fact("view", {"frame": number, "lowest": view.lowest, "highest": view.highest})
        self._line.picture(file.getvalue())

    def ended(self, outcome: RunOutcome) -> None:
        """One line for the run, and one for each oddity."""
        for text in of_run(outcome):
            self.says(text)
        super().ended(outcome)

    def learns(self, estimate: LiveEstimate) -> None:
        """What is known so far, after all that was known before."""
        self.says(f"so far: {so_far(estimate)}")
        self._estimates.append(_estimate(estimate))
        self._line.fact("estimates", self._estimates)

    async def move_wheel(self, what: Literal["remove", "insert"]) -> None:
        """By the laboratory's own command, by hand, or as it is.

        Raises
        ------
        InstrumentError
            If the series is stopped meanwhile, or the command fails.
        """
        if self._command:
            await obey(self._command, what)
        elif not self._is_silent:
            self._line.forget(MOVED)
            self._line.fact("question", WHEEL_REQUESTS[what])
            while not self._line.hears(MOVED):
                if self.is_leaving():
                    raise InstrumentError(INTERRUPTED)
                await asyncio.sleep(0.1)
            self._line.fact("question", None)
