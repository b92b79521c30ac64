"""One finding about a file, a recording or a result: what is, what it is about, and what to do."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Literal, Self, final

from irtiming.errors import IrTimingError, one_line

Severity = Literal["ok", "info", "warning", "doubt", "error"]
"""``doubt``: a number that is stated may be wrong by more than its uncertainty says."""


@final
@dataclass(frozen=True, kw_only=True)
class Finding:
    """What a check saw at one place.

    ``code`` names the kind of finding and never changes, so that programs can ask for it; ``recording`` is the name of the
    recording that it is about, "" where it is about none or all; ``where`` is the path inside a file, "" for the whole;
    ``cure`` is empty where nothing is to be done.
    """

    code: str
    severity: Severity
    where: str = ""
    what: str
    cure: str = ""
    recording: str = ""

    @classmethod
    def read_back(cls, words: Mapping[str, Any]) -> Self:
        """The finding that was written with these fields."""
        return cls(**words)

    def sentence(self) -> str:
        """The finding in one line."""
        place = (f"{self.recording}: " if self.recording else "") + (f"{self.where} " if self.where else "")
        return one_line(f"{place}{self.what}; {self.cure}" if self.cure else f"{place}{self.what}")


def perhaps_therefore(error: IrTimingError, findings: Sequence[Finding]) -> None:
    """Add doubts that were there before to a refusal, which names what came of them rather than the cause.

    Parameters
    ----------
    error
        The refusal.
    findings
        Made before it; those that are no doubt, or that it has already, are left out.
    """
    notes = " ".join(getattr(error, "__notes__", ()))
    doubts = [one.sentence() for one in findings if one.severity == "doubt"]
    if doubts := [one for one in dict.fromkeys(doubts) if one not in notes]:
        error.add_note(f"and perhaps therefore: {'; '.join(doubts)}")


@contextmanager
def doubted(findings: Iterable[Sequence[Finding]]) -> Iterator[None]:
    """A refusal within is raised with the doubts that were there before.

    Parameters
    ----------
    findings
        Made before, of each recording.

    Raises
    ------
    IrTimingError
        The refusal.
    """
    try:
        yield
    except IrTimingError as error:
        perhaps_therefore(error, [one for group in findings for one in group])
        raise


@contextmanager
def noted(stage: str, findings: Sequence[Finding]) -> Iterator[None]:
    """An error within says at which stage it came, such as "while reducing run1.nxs", and what was found before.

    Raises
    ------
    IrTimingError
        The error.
    """
    try:
        yield
    except IrTimingError as error:
        error.add_note("; ".join([stage, *(one.sentence() for one in findings)]))
        raise
