"""Uncertainty budgets by the GUM: contributions are added and their degrees of freedom pooled by the GUM Tree Calculator."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import final

import GTC

from irtiming.errors import UnitError
from irtiming.records.result import Contribution, Result
from irtiming.report.language import decimal, t, with_unit
from irtiming.report.rounding import significant, uncertainty_text

COVERAGE_PERCENT = 95.45
"""Probability with which value ± U holds the measurand: that of two standard deviations of a normal distribution."""

_MANY = 1000  # degrees of freedom beyond which their number says nothing
_LIKE_INFINITE = 1e6  # degrees of freedom from which Student's t is a normal distribution
_HALVES = ("trigger_delay_falling", "trigger_delay_rising")


@final
@dataclass(frozen=True, kw_only=True)
class Line:
    """What one source adds to one parameter, in its unit; ``share`` in the variance, 0 to 1.

    ``measured`` are standard uncertainty and unit of the number that it follows from, where there is one.
    """

    source: str
    kind: str
    standard_uncertainty: float
    degrees_of_freedom: float = inf
    share: float = 0.0
    measured: tuple[float, str] | None = None

    @property
    def sensitivity(self) -> float | None:
        """What it adds over the standard uncertainty of what was measured; None without such a number."""
        return self.standard_uncertainty / self.measured[0] if self.measured and self.measured[0] > 0 else None


@final
@dataclass(frozen=True, kw_only=True)
class Budget:
    """Contributions, the largest first, what they make together, and its effective degrees of freedom."""

    lines: tuple[Line, ...]
    standard_uncertainty: float
    degrees_of_freedom: float

    def share(self, source: str) -> float:
        """Share of one source in the variance, 0 to 1."""
        return sum(line.share for line in self.lines if line.source == source)


def of(result: Result, name: str) -> Budget:
    """Budget of one parameter."""
    return add([_line(part, part.standard_uncertainty.get(name, 0.0)) for part in result.budget])


def add(lines: Sequence[Line]) -> Budget:
    """Sum of independent contributions.

    Parameters
    ----------
    lines
        Each with its degrees of freedom, 1 or more.

    Notes
    -----
    Effective degrees of freedom by Welch and Satterthwaite (GUM, annex G.4).
    """
    given = [
        GTC.ureal(0.0, line.standard_uncertainty, max(1.0, line.degrees_of_freedom), label=line.source)
        for line in lines
    ]
    total = sum(given, start=GTC.ureal(0.0, 0.0))
    variance = float(GTC.variance(total))
    shared = [replace(line, share=line.standard_uncertainty**2 / variance if variance > 0 else 0.0) for line in lines]
    return Budget(
        lines=tuple(sorted(shared, key=lambda line: -line.standard_uncertainty)),
        standard_uncertainty=sqrt(variance),
        degrees_of_freedom=float(GTC.dof(total)),
    )


def coverage_factor(degrees_of_freedom: float, *, probability: float = COVERAGE_PERCENT / 100) -> float:
    """Factor k of the expanded uncertainty U = k u, by Student's t.

    Raises
    ------
    UnitError
        If the probability is not between 0 and 1.
    """
    if not 0 < probability < 1:
        raise UnitError(f"the probability is {probability}, must be between 0 and 1: 0.95 of value ± U")
    return float(GTC.reporting.k_factor(degrees_of_freedom, 100 * probability))


@final
@dataclass(frozen=True, kw_only=True)
class Split:
    """Delay by falling minus delay by rising slopes, s, with its uncertainty from the covariance."""

    value_s: float
    standard_uncertainty_s: float
    degrees_of_freedom: float


def falling_minus_rising(result: Result) -> Split | None:
    """Split between falling and rising slopes; None where the method does not tell them apart.

    Notes
    -----
    The delay is the mean of the two, so its variance w, and f and r of the two, give that of their difference for each source:
    2 f + 2 r - 4 w. What all edges have in common cancels.
    """
    if not all(name in result.estimate for name in _HALVES):
        return None
    halves = result.estimate.pick(*_HALVES)
    (falling, both), (_, rising) = halves.covariance.tolist()
    return Split(
        value_s=float(halves.values[0] - halves.values[1]),
        standard_uncertainty_s=sqrt(max(0.0, falling + rising - 2 * both)),
        degrees_of_freedom=add([_line(part, _of_split(part)) for part in result.budget]).degrees_of_freedom,
    )


def _of_split(part: Contribution) -> float:
    """What a source adds to the difference, s."""
    whole, falling, rising = (part.standard_uncertainty.get(name, 0.0) ** 2 for name in ("trigger_delay", *_HALVES))
    return sqrt(max(0.0, 2 * falling + 2 * rising - 4 * whole))


def _line(part: Contribution, u: float) -> Line:
    return Line(
        source=part.source, kind=part.kind, standard_uncertainty=u, degrees_of_freedom=part.degrees_of_freedom,
        measured=part.measured,
    )  # fmt: skip


def expanded_text(u: float, degrees_of_freedom: float, *, unit: str = "s") -> tuple[str, str]:
    """Expanded uncertainty, of a time or of a share, and its k as text: ``("60 µs", "2.00")``."""
    k = coverage_factor(degrees_of_freedom)
    return uncertainty_text(k * u) if unit == "s" else with_unit(significant(100 * k * u), "%"), decimal(f"{k:.2f}")


def freedom_text(degrees_of_freedom: float) -> str:
    """Degrees of freedom as text: ``"3"``, ``"12.4"``, ``"∞"``; ``"> 1000"`` where they change k no more."""
    if _is_infinite(degrees_of_freedom):
        return "∞"
    if degrees_of_freedom > _MANY:
        return f"> {_MANY:g}"
    return f"{degrees_of_freedom:.0f}" if degrees_of_freedom >= 100 else decimal(f"{degrees_of_freedom:.3g}")


def freedom_number(degrees_of_freedom: float) -> float | None:
    """Degrees of freedom as JSON has them: None for infinite."""
    return None if _is_infinite(degrees_of_freedom) else float(degrees_of_freedom)


def _is_infinite(degrees_of_freedom: float) -> bool:
    return not degrees_of_freedom <= _LIKE_INFINITE


def expanded_numbers(u: float, degrees_of_freedom: float) -> dict[str, float | None]:
    """Expanded uncertainty, its k and the degrees of freedom that k stands on, for JSON."""
    k = coverage_factor(degrees_of_freedom)
    return {
        "expanded_uncertainty": k * u,
        "coverage_factor": k,
        "effective_degrees_of_freedom": freedom_number(degrees_of_freedom),
    }


def share_text(share: float) -> str:
    """Share of a variance as text."""
    return "0" if share <= 0 else t("{share:.0%}", share=share) if share >= 0.005 else t("< 1%")
