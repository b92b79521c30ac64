"""The analysis beside a recording: in a process of its own, on the very file that is being written.

Whenever enough frames have come since the last look, the file is read as far as it is, reduced as any other, and estimated
together with the finished recordings of the series. A look costs what an analysis costs; that they lie a factor apart keeps all
of them together at a few times the last. What the last look says of finished files is what `measurement.analyse` says.
"""

import os
import signal
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self, final

from irtiming import measurement
from irtiming.archive.live.so_far import read_so_far
from irtiming.errors import IrTimingError
from irtiming.records.analysis import Analysis
from irtiming.records.finding import Finding
from irtiming.records.recording import Recording
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Rig
from irtiming.report import event_words

FEWEST_FRAMES = 120
"""Below so many frames of a run nothing is looked at."""

APART = 1.4
"""From look to look within a run the frames grow by this factor."""

_POLITENESS = 10
_PATIENCE_S = 60.0

What = Literal["look", "keep"]


@final
@dataclass(frozen=True, kw_only=True)
class LiveEstimate:
    """What is known so far, from so many frames of all recordings: values and standard uncertainties by name, s, or 1 of a share.

    ``finding`` says why there is none, where there is none.
    """

    frames: int
    values: Mapping[str, float]
    uncertainties: Mapping[str, float]
    finding: Finding | None = None

    @property
    def doubt(self) -> str:
        """The finding as a line of text; empty where there is none."""
        if self.finding is None:
            return ""
        return f"{self.finding.where}: {self.finding.what}" if self.finding.where else self.finding.what

    def as_json(self) -> dict[str, Any]:
        """The same as plain data."""
        return {
            "frames": self.frames,
            "values": dict(self.values),
            "uncertainties": dict(self.uncertainties),
            "doubt": self.doubt,
        }

    def reaches(self, wished: Mapping[str, float]) -> bool:
        """Whether every standard uncertainty that is wished for, by name in s, is reached; no wish never is."""
        return bool(wished) and all(self.uncertainties.get(name, float("inf")) <= u for name, u in wished.items())


@final
class LiveAnalysis:
    """Tells what is known so far, while its ``with`` block runs.

    Parameters
    ----------
    rig
        As measured by its owner.
    """

    def __init__(self, rig: Rig) -> None:
        here, there = get_context("spawn").Pipe()
        self._line, self._far = here, there
        self._process = get_context("spawn").Process(target=_work, args=(there, rig), daemon=True)
        self._is_busy = False
        self._looked_at = 0
        self._waiting: list[tuple[What, Path]] = []
        self._latest: LiveEstimate | None = None

    def __enter__(self) -> Self:
        self._process.start()
        self._far.close()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with suppress(OSError):
            self._line.send(None)
        self._process.join(0 if error is not None else _PATIENCE_S)
        if self._process.is_alive():
            self._process.terminate()
            self._process.join()
        self._process.close()
        self._line.close()

    @property
    def latest(self) -> LiveEstimate | None:
        """The last answer; None before the first."""
        self._listen()
        return self._latest

    def begins(self) -> None:
        """A new file begins to grow."""
        self._looked_at = 0

    def grows(self, path: Path, frames: int) -> None:
        """A file, named as when finished, has so many frames; it is looked at when they are enough and no look is under way."""
        self._listen()
        if not self._is_busy and frames >= max(FEWEST_FRAMES, APART * self._looked_at):
            self._looked_at = frames
            self._ask("look", path)

    def keep(self, path: Path) -> None:
        """A recording is finished, and goes into all estimates from now on."""
        self._waiting.append(("keep", path))
        self._listen()

    def settled(self) -> LiveEstimate | None:
        """Wait until all that is finished is in, and give the estimate of it all."""
        while self._is_busy or self._waiting:
            if not self._process.is_alive() and not self._line.poll():
                break
            self._line.poll(1.0)
            self._listen()
        return self._latest

    def _ask(self, what: What, path: Path) -> None:
        try:
            self._line.send((what, path))
            self._is_busy = True
        except OSError:
            self._gone()

    def _listen(self) -> None:
        try:
            while self._line.poll():
                self._latest = self._line.recv()
                self._is_busy = False
        except (EOFError, OSError):
            self._gone()
        if not self._is_busy and self._waiting:
            self._ask(*self._waiting.pop(0))

    def _gone(self) -> None:
        self._is_busy, self._waiting = False, []
        self._latest = _unknown(
            Finding(
                code="live-analysis-ended",
                severity="warning",
                where="",
                what="the process of the live analysis has ended; the recording goes on without",
            )
        )


@final
class Analyst:
    """Finished recordings of one camera, reduced once, and what they say together with one that still grows.

    Parameters
    ----------
    rig
        As measured by its owner.
    """

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._kept: list[ReducedRecording] = []

    def keep(self, path: Path) -> Analysis:
        """Read a finished recording, keep it, and estimate all that is kept.

        Raises
        ------
        IrTimingError
            As `measurement.analyse`; the recording is then not kept.
        """
        reduced = self._reduced(read_so_far(path))
        found = self._estimated([*self._kept, reduced])
        self._kept.append(reduced)
        return found

    def look(self, path: Path) -> Analysis:
        """The same for one that is still written, which is not kept.

        Raises
        ------
        IrTimingError
            As `measurement.analyse`.
        """
        return self._estimated([*self._kept, self._reduced(read_so_far(path))])

    def _reduced(self, recording: Recording) -> ReducedRecording:
        return measurement.reduce(recording, self._rig, before=self._kept)

    def _estimated(self, reduced: list[ReducedRecording]) -> Analysis:
        return measurement.estimate(reduced, self._rig)


def _work(line: Connection, rig: Rig) -> None:
    """What the process does: answer one question after the other, and give way to whoever records."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the recording
    with suppress(AttributeError, OSError):
        os.nice(_POLITENESS)
    analyst = Analyst(rig)
    with suppress(EOFError, OSError):
        while (question := line.recv()) is not None:
            what, path = question
            try:
                answer = told_of(analyst.keep(path) if what == "keep" else analyst.look(path))
            except (IrTimingError, ArithmeticError, ValueError) as error:
                where, what = (error.where, error.what) if isinstance(error, IrTimingError) else ("", str(error))
                answer = _unknown(
                    Finding(code="no-live-estimate", severity="info", where=where, what=" ".join(what.split()))
                )
            line.send(answer)


def _unknown(finding: Finding) -> LiveEstimate:
    return LiveEstimate(frames=0, values={}, uncertainties={}, finding=finding)


def told_of(found: Analysis) -> LiveEstimate:
    """What an analysis says, in short."""
    estimate, event = found.result.estimate, event_words.event_of(found)
    names = [event_words.text(name, event) for name in estimate.names]
    uncertainties = dict(zip(names, map(float, estimate.standard_uncertainties), strict=True))
    apart = [each.standard_uncertainty_s for each in found.result.relative_delays if each.nominal_s > 0]
    return LiveEstimate(
        frames=sum(one.trigger_ticks.size for one in found.recordings),
        values=dict(zip(names, map(float, estimate.values), strict=True)),
        uncertainties=uncertainties | ({"relative_delay": max(apart)} if apart else {}),
    )
