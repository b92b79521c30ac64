"""What is said while a series is recorded, whoever hears it; and the command that takes the wheel out of the way."""

import asyncio
import shlex
from typing import Literal

from irtiming.acquire.run_order import RunOutcome
from irtiming.errors import InstrumentError
from irtiming.records.estimate import SHARES
from irtiming.report import outside
from irtiming.report.rounding import value_text
from irtiming.session.live_estimate import LiveEstimate
from irtiming.units import counted

_STANDARD_ERROR = 2  # standard output is for names of files

WHEEL_REQUESTS: dict[Literal["remove", "insert"], str] = {
    "remove": "Take wheel and mask out of the way: the camera must see the bare blackbody",
    "insert": "Bring wheel and mask back to where they were",
}
"""What a person is asked to do."""


def so_far(found: LiveEstimate) -> str:
    """What is known, in one line: every number with its standard uncertainty, and what that does not hold."""
    if found.finding is not None:
        return f"not sure yet ({found.finding.what})"
    numbers = [
        f"{name} {value_text(value, found.uncertainties[name], unit='1' if name in SHARES else 's')}"
        for name, value in found.values.items()
        if not name.startswith("exposure") and not name.endswith(("_falling", "_rising"))
    ]
    beside = outside.behind(found.not_in_uncertainty)
    return f"{', '.join(numbers)}, from {found.frames} frames" + (f" ({beside})" if beside else "")


def of_run(outcome: RunOutcome) -> list[str]:
    """A line for the run, and one for each oddity."""
    verdict, counts = outcome.verdict, outcome.counts
    source = "that the camera made" if outcome.order.camera.runs_free else "triggers"
    return [
        f"run {outcome.order.number}: {verdict.frames} frames for {verdict.triggers} {source}, {verdict.lost} lost, "
        f"{counted(counts.packets_missing, 'packet')} missing, {counts.packets_resent} resent, "
        f"longest queue {outcome.longest_queue}: {outcome.ending}",
        *(f"warning: {finding.sentence()}" for finding in outcome.findings),
    ]


async def obey(command: str, what: Literal["remove", "insert"]) -> None:
    """Run the laboratory's own command, with what it is to do as its last word.

    Raises
    ------
    InstrumentError
        If it cannot be run, or ends with another status than 0.
    """
    words = [*shlex.split(command), what]
    try:
        process = await asyncio.create_subprocess_exec(*words, stdout=_STANDARD_ERROR)
    except OSError as error:
        raise InstrumentError(
            f"[references] command '{words[0]}' cannot be run ({error.strerror}); correct it"
        ) from error
    if status := await process.wait():
        raise InstrumentError(
            f"[references] command '{shlex.join(words)}' ended with status {status}; see what it says"
        )
