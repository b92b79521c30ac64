"""The analysis beside a recording: in a process of its own, on the very file that is being written.

Whenever enough frames have come since the last look, the file is read as far as it is, reduced as any other, and estimated
together with the finished recordings of the series. A look costs what an analysis costs; that they lie a factor apart keeps all
of them together at a few times the last. What the last look says of finished files is what `measurement.analyse` says.
"""

from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType
from typing import Literal, Self, final

from irtiming.records.finding import Finding
from irtiming.records.rig import Rig
from irtiming.session.live_estimate import LiveEstimate, nothing_known

FEWEST_FRAMES = 120
"""Below so many frames of a run nothing is looked at."""

APART = 1.4
"""From look to look within a run the frames grow by this factor."""

_PATIENCE_S = 60.0

What = Literal["look", "keep"]


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
        self._latest = nothing_known(
            Finding(
                code="live-analysis-ended",
                severity="warning",
                where="",
                what="the process of the live analysis has ended; the recording goes on without",
            )
        )


def _work(line: Connection, rig: Rig) -> None:
    """What the process does; whoever records loads nothing of the analysis."""
    from irtiming.session.analyst import answer_all

    answer_all(line, rig)
