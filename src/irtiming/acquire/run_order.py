"""What is to be recorded in one run, and what became of it."""

from dataclasses import dataclass
from pathlib import Path
from typing import final

from irtiming.acquire.pairing import Verdict
from irtiming.archive.live.recording import COMPLETE
from irtiming.records.camera_frame import StreamCounts
from irtiming.records.finding import Finding
from irtiming.records.instrument_state import BlackbodyState
from irtiming.records.recording import NonuniformityReference
from irtiming.records.series_plan import CameraWishes
from irtiming.records.trigger_plan import PlannedRun

INTERRUPTED = "stopped by the user"
ENOUGH = "enough: the wished uncertainty is reached"


@final
@dataclass(frozen=True, kw_only=True)
class RunOrder:
    """What is to be recorded, and where to; ``number`` counts the runs of a series from 1.

    ``blackbody_before`` is its state when stable, ``tolerance_k`` how far it may go from there, ``usual_latency_s`` what
    earlier runs have proven of the time from a trigger to the arrival of its frame.
    """

    number: int
    path: Path
    run: PlannedRun
    camera: CameraWishes
    nonuniformity: NonuniformityReference | None = None
    blackbody_before: BlackbodyState | None = None
    tolerance_k: float = 0.1
    usual_latency_s: float | None = None


@final
@dataclass(frozen=True, kw_only=True)
class RunOutcome:
    """What became of a run. ``ending`` is "complete", or why it ended early or is not trusted."""

    order: RunOrder
    path: Path
    ending: str
    verdict: Verdict
    counts: StreamCounts
    findings: tuple[Finding, ...] = ()
    overflowed: int = 0
    longest_queue: int = 0
    repeated: int = 0
    blackbody_after: BlackbodyState | None = None

    @property
    def is_complete(self) -> bool:
        """Whether all came and is trusted."""
        return self.ending == COMPLETE
