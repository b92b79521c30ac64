"""limits.toml: what a camera must keep to, and the rule by which that is judged; its keys are those of certificate.toml."""

from pathlib import Path
from typing import Annotated

from pydantic import Field

from irtiming.archive.certificate_file import Decision, Limit, Rule
from irtiming.archive.typed_file import OneOrSeveral, Part, read_toml
from irtiming.archive.typed_misfit import FileKind

_KIND = FileKind(name="limits.toml")
_RULES: dict[Rule, str] = {
    "simple acceptance": "simple acceptance: a value within the limits passes, whatever its uncertainty (JCGM 106, 8.2)",
    "guard band": "guard band w = U: a value passes if it lies at least U within the limits, fails if it lies more than U "
    "outside, and passes or fails on condition between (JCGM 106, 8.3; ISO 14253-1)",
}


class LimitsFile(Part):
    """Everything in limits.toml."""

    decision: Decision = Decision()
    limit: Annotated[list[Limit], OneOrSeveral()] = Field([])

    @property
    def rule_in_words(self) -> str:
        """What is said on the page; empty without limits."""
        return _RULES[self.decision.rule] if self.limit else ""


def read_limits(path: str | Path) -> LimitsFile:
    """Limits of parameters, and the rule.

    Raises
    ------
    ArchiveError
        If the file cannot be read, a key is unknown or missing, or a value cannot be.
    """
    found, _ = read_toml(Path(path), LimitsFile, kind=_KIND)
    return found
