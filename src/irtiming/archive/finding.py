"""One complaint about a file: what is, where, and what to do."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, final

from irtiming.errors import ArchiveError

Severity = Literal["ok", "info", "warning", "error"]


@final
@dataclass(frozen=True, kw_only=True)
class Finding:
    """What a check saw at one place of a file.

    ``where`` is a path inside the file, "" for the whole file; ``cure`` is empty where nothing is to be done.
    """

    severity: Severity
    where: str
    what: str
    cure: str = ""

    def sentence(self) -> str:
        """The finding in one line."""
        place = f"{self.where} " if self.where else ""
        return f"{place}{self.what}; {self.cure}" if self.cure else f"{place}{self.what}"


@final
class Complaint(Exception):  # noqa: N818 - it never leaves this folder
    """Carries a finding from a check to the reader, which raises it, or to verify, which collects it."""

    def __init__(self, finding: Finding) -> None:
        super().__init__(finding.sentence())
        self.finding = finding

    def as_error(self, path: str | Path) -> ArchiveError:
        """The same complaint for a user: one line that begins with the file."""
        return archive_error(path, self.finding)


def refuse(where: str, what: str, *, cure: str) -> Complaint:
    """Complaint of severity "error", to be raised."""
    return Complaint(Finding(severity="error", where=where, what=what, cure=cure))


def archive_error(path: str | Path, finding: Finding) -> ArchiveError:
    """Error that says file, place, what is and what to do, in one line."""
    return ArchiveError(" ".join(f"{path}: {finding.sentence()}".split()))
