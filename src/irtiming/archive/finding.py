"""Findings on their way to a reader: raised as a complaint, reported as an error."""

from pathlib import Path
from typing import final

from irtiming.errors import ArchiveError
from irtiming.records.finding import Finding


@final
class Complaint(Exception):  # noqa: N818 - it never leaves this folder
    """Carries a finding from a check to the reader, which raises it, or to verify, which collects it."""

    def __init__(self, finding: Finding) -> None:
        super().__init__(finding.sentence())
        self.finding = finding

    def as_error(self, path: str | Path) -> ArchiveError:
        """The same complaint for a user: one line that begins with the file."""
        return archive_error(path, self.finding)


def error_at(where: str, what: str, *, code: str, cure: str) -> Finding:
    """Finding of severity "error" about a place in a file."""
    return Finding(code=code, severity="error", where=where, what=what, cure=cure)


def warning_at(where: str, what: str, *, code: str, cure: str) -> Finding:
    """Finding of severity "warning" about a place in a file."""
    return Finding(code=code, severity="warning", where=where, what=what, cure=cure)


def refuse(where: str, what: str, *, code: str, cure: str) -> Complaint:
    """Complaint of severity "error", to be raised."""
    return Complaint(error_at(where, what, code=code, cure=cure))


def archive_error(path: str | Path, finding: Finding) -> ArchiveError:
    """Error that says file, place, what is and what to do, in one line."""
    return ArchiveError(" ".join(finding.sentence().split()), where=str(path))
