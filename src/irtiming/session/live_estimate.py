"""What is known of a camera while it is still being recorded."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

from irtiming.records.finding import Finding


@final
@dataclass(frozen=True, kw_only=True)
class LiveEstimate:
    """What is known so far, from so many frames of all recordings: values and standard uncertainties by name, s, or 1 of a share.

    ``not_in_uncertainty`` says in words what the uncertainties do not hold, as the result does; ``finding`` says why there is
    no estimate, where there is none.
    """

    frames: int
    values: Mapping[str, float]
    uncertainties: Mapping[str, float]
    not_in_uncertainty: tuple[str, ...] = ()
    finding: Finding | None = None

    @property
    def doubt(self) -> str:
        """The finding as a line of text; empty where there is none."""
        if self.finding is None:
            return ""
        return f"{self.finding.where}: {self.finding.what}" if self.finding.where else self.finding.what

    def as_json(self) -> dict[str, Any]:
        """The same as plain data."""
        return {
            "frames": self.frames,
            "values": dict(self.values),
            "uncertainties": dict(self.uncertainties),
            "not_in_uncertainty": list(self.not_in_uncertainty),
            "doubt": self.doubt,
        }

    def reaches(self, wished: Mapping[str, float]) -> bool:
        """Whether every standard uncertainty that is wished for, by name in s, is reached; no wish never is."""
        return bool(wished) and all(self.uncertainties.get(name, float("inf")) <= u for name, u in wished.items())


def nothing_known(finding: Finding) -> LiveEstimate:
    """No estimate, and why."""
    return LiveEstimate(frames=0, values={}, uncertainties={}, finding=finding)
