"""What the process of the live analysis does: read, reduce and estimate; see `live`."""

import os
import signal
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from typing import final

from irtiming import measurement
from irtiming.archive.live.so_far import read_so_far
from irtiming.errors import IrTimingError
from irtiming.records.analysis import Analysis
from irtiming.records.finding import Finding
from irtiming.records.recording import Recording
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Rig
from irtiming.report import event_words
from irtiming.session.live_estimate import LiveEstimate, nothing_known

_POLITENESS = 10


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


def answer_all(line: Connection, rig: Rig) -> None:
    """Answer one question after the other until None comes, and give way to whoever records."""
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
                answer = nothing_known(
                    Finding(code="no-live-estimate", severity="info", where=where, what=" ".join(what.split()))
                )
            line.send(answer)


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
        not_in_uncertainty=found.result.not_in_uncertainty,
    )
