"""Uncertainty budgets by the GUM: contributions are added and their degrees of freedom pooled by the GUM Tree Calculator."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import final

import GTC

from irtiming.records.estimate import Contribution, DelayResult, Estimate
from irtiming.records.rolling_result import RollingResult
from irtiming.report.rounding import uncertainty_text

COVERAGE_PERCENT = 95.45
"""Probability with which value ± U holds the measurand: that of two standard deviations of a normal distribution."""

_LIKE_INFINITE = 1e6  # degrees of freedom from which Student's t is a normal distribution
_BY_FEW_EDGES = ("trigger_delay_falling", "trigger_delay_rising")
_FRAMES = Contribution(source="frames", kind="A", standard_uncertainty_s=0.0)


@final
@dataclass(frozen=True, kw_only=True)
class Line:
    """A contribution, and its share in the variance, 0 to 1."""

    part: Contribution
    share: float


@final
@dataclass(frozen=True, kw_only=True)
class Budget:
    """Contributions, the largest first, what they make together, s, and its effective degrees of freedom."""

    lines: tuple[Line, ...]
    standard_uncertainty_s: float
    degrees_of_freedom: float


def of_delay(result: DelayResult) -> Budget:
    """Budget of the delay that all edges tell together."""
    return add(result.budget)


def of_rolling(result: RollingResult, name: str) -> Budget:
    """Budget of one parameter of a rolling camera."""
    return add(
        [
            Contribution(
                source=part.source,
                kind=part.kind,
                standard_uncertainty_s=getattr(part, f"{name}_s"),
                degrees_of_freedom=part.degrees_of_freedom,
            )
            for part in result.budget
        ]
    )


def add(parts: Sequence[Contribution]) -> Budget:
    """Sum of independent contributions.

    Parameters
    ----------
    parts
        Each with its degrees of freedom, 1 or more.

    Notes
    -----
    Effective degrees of freedom by Welch and Satterthwaite (GUM, annex G.4).
    """
    given = [
        GTC.ureal(0.0, part.standard_uncertainty_s, max(1.0, part.degrees_of_freedom), label=part.source)
        for part in parts
    ]
    total = sum(given, start=GTC.ureal(0.0, 0.0))
    variance = float(GTC.variance(total))
    found = GTC.reporting.budget(total, influences=given, key=None, trim=0)
    lines = [
        Line(part=part, share=float(component.u) ** 2 / variance if variance > 0 else 0.0)
        for part, component in zip(parts, found, strict=True)
    ]
    return Budget(
        lines=tuple(sorted(lines, key=lambda line: -line.part.standard_uncertainty_s)),
        standard_uncertainty_s=sqrt(variance),
        degrees_of_freedom=float(GTC.dof(total)),
    )


def share(budget: Budget, source: str) -> float:
    """Share of one source in the variance, 0 to 1."""
    return sum(line.share for line in budget.lines if line.part.source == source)


def coverage_factor(degrees_of_freedom: float) -> float:
    """Factor k of the expanded uncertainty U = k u, by Student's t."""
    return float(GTC.reporting.k_factor(degrees_of_freedom, COVERAGE_PERCENT))


def degrees_of_freedom(result: DelayResult, name: str) -> float:
    """Effective degrees of freedom of one parameter.

    Notes
    -----
    The budget is that of the delay from all edges. Where half of the edges tell a delay, what they give to its variance counts
    twice; they are the contribution with the least degrees of freedom. Whatever else is in the variance comes from thousands
    of frames and counts as known; so does the length of the window.
    """
    if name == "integration_time":
        return inf
    variance = _variance(result.estimate, {name: 1.0})
    return _pooled(_by_knowledge(result), variance, times=2 if name in _BY_FEW_EDGES else 1)


@final
@dataclass(frozen=True, kw_only=True)
class Split:
    """Delay by falling minus delay by rising slopes, s, with its uncertainty from the covariance."""

    value_s: float
    standard_uncertainty_s: float
    degrees_of_freedom: float


def falling_minus_rising(result: DelayResult) -> Split | None:
    """Split between falling and rising slopes; None where they are not told apart.

    Notes
    -----
    What all edges have in common cancels; what the edges give to the variance counts four times.
    """
    names = result.estimate.names
    if not set(_BY_FEW_EDGES) <= set(names):
        return None
    weights = dict(zip(_BY_FEW_EDGES, (1.0, -1.0), strict=True))
    variance = max(0.0, _variance(result.estimate, weights))
    return Split(
        value_s=sum(weight * float(result.estimate.values[names.index(name)]) for name, weight in weights.items()),
        standard_uncertainty_s=sqrt(variance),
        degrees_of_freedom=_pooled(_by_knowledge(result)[:1], variance, times=4),
    )


def _by_knowledge(result: DelayResult) -> list[Contribution]:
    return sorted(result.budget, key=lambda part: part.degrees_of_freedom)


def _pooled(parts: Sequence[Contribution], variance_s2: float, *, times: int) -> float:
    """Degrees of freedom of a variance, its least known part first, which counts so many times; all others once."""
    made, left = [], max(0.0, variance_s2)
    for k, part in enumerate([*parts, _FRAMES]):
        most = inf if part is _FRAMES else (1 if k else times) * part.standard_uncertainty_s**2
        made.append(replace(part, standard_uncertainty_s=sqrt(min(most, left))))
        left -= min(most, left)
    return add(made).degrees_of_freedom


def _variance(estimate: Estimate, weights: dict[str, float]) -> float:
    """Variance of a weighted sum of measurands, s^2."""
    places = [estimate.names.index(name) for name in weights]
    return float(
        sum(
            one * other * estimate.covariance[row, column]
            for row, one in zip(places, weights.values(), strict=True)
            for column, other in zip(places, weights.values(), strict=True)
        )
    )


def expanded_text(u_s: float, degrees_of_freedom: float) -> tuple[str, str]:
    """Expanded uncertainty and its k as text: ``("60 µs", "2.00")``."""
    k = coverage_factor(degrees_of_freedom)
    return uncertainty_text(k * u_s), f"{k:.2f}"


def freedom_text(degrees_of_freedom: float) -> str:
    """Degrees of freedom as text: ``"3"``, ``"12.4"``, ``"∞"``."""
    if _is_infinite(degrees_of_freedom):
        return "∞"
    return f"{degrees_of_freedom:.0f}" if degrees_of_freedom >= 100 else f"{degrees_of_freedom:.3g}"


def freedom_number(degrees_of_freedom: float) -> float | None:
    """Degrees of freedom as JSON has them: None for infinite."""
    return None if _is_infinite(degrees_of_freedom) else float(degrees_of_freedom)


def _is_infinite(degrees_of_freedom: float) -> bool:
    return not degrees_of_freedom <= _LIKE_INFINITE


def expanded_numbers(u_s: float, degrees_of_freedom: float) -> dict[str, float | None]:
    """Expanded uncertainty, its k and the degrees of freedom that k stands on, for JSON."""
    k = coverage_factor(degrees_of_freedom)
    return {
        "expanded_uncertainty": k * u_s,
        "coverage_factor": k,
        "effective_degrees_of_freedom": freedom_number(degrees_of_freedom),
    }


def share_text(share: float) -> str:
    """Share of a variance as text."""
    return "0" if share <= 0 else f"{share:.0%}" if share >= 0.005 else "< 1%"
