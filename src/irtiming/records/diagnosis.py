"""What may stand behind structured residuals: every cause that the program can name, and how much of them each explains."""

from dataclasses import dataclass
from typing import final

from irtiming.records.finding import Finding
from irtiming.records.rig import Measured


@final
@dataclass(frozen=True, kw_only=True)
class Cause:
    """A cause that the fit does not have, tried by itself.

    ``gained`` is the deviance that it takes from the residuals, with ``n_numbers`` of its own; ``chance`` is the probability that
    noise alone gives as much to any of the causes that were tried. ``size`` is the rms of what it adds to the sums, opening
    fractions. ``moves`` says by how much each parameter of the result would move with it, in standard uncertainties.
    """

    name: str
    gained: float
    n_numbers: int
    chance: float
    size: float
    moves: dict[str, float]
    cure: str = ""


@final
@dataclass(frozen=True, kw_only=True)
class Fitted:
    """A number that the fit has for a defect: its value, how many standard uncertainties from none, the deviance it gained."""

    name: str
    value: Measured
    unit: str
    from_none: float
    gained: float


@final
@dataclass(frozen=True, kw_only=True)
class Diagnosis:
    """Causes in the order of what they explain, and numbers of the fit that stand for defects, the clearest first.

    ``deviance`` is that of the residuals over the noise of neighbouring frames, with ``degrees_of_freedom``.
    """

    deviance: float
    degrees_of_freedom: int
    causes: tuple[Cause, ...]
    fitted: tuple[Fitted, ...]
    findings: tuple[Finding, ...] = ()
