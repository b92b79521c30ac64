"""limits.toml: what a camera must keep to, and the rule by which that is judged; its keys are those of certificate.toml."""

from pathlib import Path

from pydantic import Field

from irtiming.archive.certificate_file import RULES, Decision, Limits
from irtiming.archive.typed_file import Part, read_toml
from irtiming.archive.typed_misfit import FileKind

_KIND = FileKind(name="limits.toml")


class LimitsFile(Part):
    """Everything in limits.toml."""

    decision: Decision = Decision()
    limit: Limits = Field([])

    @property
    def rule_in_words(self) -> str:
        """What is said on the page; empty without limits."""
        return RULES[self.decision.rule] if self.limit else ""


def read_limits(path: str | Path) -> LimitsFile:
    """Limits of parameters, and the rule.

    Raises
    ------
    ArchiveError
        If the file cannot be read, a key is unknown or missing, or a value cannot be.
    """
    found, _ = read_toml(Path(path), LimitsFile, kind=_KIND)
    return found
