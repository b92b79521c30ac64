"""Whoever is at the rig while it records: a person behind a screen, or a program."""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from irtiming.records.camera_frame import CameraFrame
from irtiming.records.timestamps import Timestamps
from irtiming.records.trigger_plan import PlannedRun

if TYPE_CHECKING:
    from irtiming.acquire.run_order import RunOutcome


class Attendant:
    """Hears what happens and does nothing; override what is of interest.

    All calls come from the event loop and must return at once, but `written`, which comes from the thread that writes.
    """

    def says(self, text: str) -> None:
        """A sentence for a person: what is being waited for, or done."""

    def begins(self, run: PlannedRun, *, number: int, path: Path) -> None:
        """A run begins; frames go into that file (with suffix ``.part`` until it is finished)."""

    def goes_on(self, *, made: int, total: int, frames: int, lost: int, waiting: int) -> None:
        """Triggers made of all, frames that came, frames lost, frames that wait to be written."""

    def sees(self, timestamps: Timestamps) -> None:
        """All timestamps of the run so far, several times a second."""

    def written(self, frame: CameraFrame, *, number: int) -> None:
        """A frame, whole or damaged, of that trigger is in the file."""

    def ended(self, outcome: "RunOutcome") -> None:
        """A run has ended, and its file is closed."""

    def is_enough(self) -> bool:
        """Whether the wish of the series is reached, so that it may end now; asked during a run and after each."""
        return False

    def is_leaving(self) -> bool:
        """Whether the series must end now, as a person wants it; the recording is closed with what it has."""
        return False

    async def move_wheel(self, what: Literal["remove", "insert"]) -> None:
        """Take wheel and mask out of the way, so that the camera sees the bare blackbody, or bring them back."""
