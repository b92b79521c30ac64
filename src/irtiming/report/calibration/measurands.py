"""Measurands of a result, each with its whole uncertainty budget (GUM, 7.2; EA-4/02, annex)."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, isfinite, sqrt
from typing import final

from irtiming.archive.certificate_file import CertificateFile, Limit, Rule, limit_of
from irtiming.archive.result_model import CombinedDelay, Contribution, Result, RigValue
from irtiming.errors import ArchiveError
from irtiming.records.sources import CLOCK, RIG_KEYS
from irtiming.report import budget
from irtiming.report.calibration.decision import Conformity, judged

LEADING = ("trigger_delay", "exposure_midpoint_delay", "time_constant", "row_delay")
"""What a reader wants to know first, as far as a camera has it."""

_LEAST_SHARE = 1e-7  # of u, below which a contribution is the rounding of numbers


@final
@dataclass(frozen=True, kw_only=True)
class BudgetLine:
    """One input quantity: estimate x, standard uncertainty u(x), its distribution, sensitivity |c|, contribution |c| u(x).

    ``estimate`` is 0 for a correction that is expected to be none, ``unit`` that of x; ``contribution`` is in the unit of the
    measurand.
    """

    source: str
    kind: str
    distribution: str
    estimate: float
    u: float
    unit: str
    sensitivity: float
    contribution: float
    degrees_of_freedom: float


@final
@dataclass(frozen=True, kw_only=True)
class Measurand:
    """One result: SI value, standard and expanded uncertainty, what they mean, and the budget.

    ``nominal_s`` and ``speed_hz`` are of a relative delay, ``runs`` its number of recordings. ``specification`` are lower and
    upper limit, ``conformity`` what the decision rule says; None without limits.
    """

    name: str
    leads: bool
    value: float
    u: float
    expanded: float
    coverage_factor: float
    degrees_of_freedom: float
    unit: str
    event: str
    sign: str | None
    budget: tuple[BudgetLine, ...]
    nominal_s: float | None = None
    speed_hz: float | None = None
    runs: int = 1
    limits: tuple[float | None, float | None] = (None, None)
    specification: str | None = None
    conformity: Conformity | None = None


def of(result: Result, form: CertificateFile, *, serial_number: str | None) -> Iterator[Measurand]:
    """Every time that was measured, then every relative delay.

    Parameters
    ----------
    result, form
        Result and certificate.toml.
    serial_number
        Of the camera, by the recordings or the laboratory, by which it has limits of its own; None where neither says.

    Raises
    ------
    ArchiveError
        If the result determines nothing.
    """
    rig = {one.name: one for one in result.rig.values}
    names = [
        name for name, one in result.parameters.items()
        if one.unit == "s" and one.value is not None and one.standard_uncertainty is not None
    ]  # fmt: skip
    if not names:
        raise ArchiveError("the result determines no time of the camera; there is nothing to certify")
    for name in names:
        limit = limit_of(form.limit, parameter=name, serial_number=serial_number)
        yield _parameter(result, name, limit=limit, rule=form.decision.rule, rig=rig)
    for combined in result.relative_delays_combined:
        yield _relative(result, combined)


def _parameter(result: Result, name: str, *, limit: Limit | None, rule: Rule, rig: dict[str, RigValue]) -> Measurand:
    one = result.parameters[name]
    u, freedom = one.standard_uncertainty or 0.0, _freedom(one.effective_degrees_of_freedom)
    if freedom < 1 or (one.coverage_factor or 1.0) < 1:
        raise ArchiveError(
            f"the result has {name} with u = {u:g}, k = {one.coverage_factor}, degrees of freedom {freedom:g}, which no "
            "analysis gives; write it anew with irtiming analyse --json"
        )
    k = one.coverage_factor or budget.coverage_factor(freedom)
    lines = [
        _line(part, name, rig=rig) for part in result.contributions if _counts(part.standard_uncertainty.get(name), u)
    ]
    lines.sort(key=lambda line: -line.contribution)
    if not lines:
        lines = [_own("fit of all recordings", u)]
    limits = (None, None) if limit is None else limit.bounds_s
    value = one.value or 0.0
    return Measurand(
        name=name, leads=name in LEADING, value=value, u=u, expanded=k * u, coverage_factor=k, degrees_of_freedom=freedom,
        unit=one.unit, event=one.reference_event, sign=one.sign, budget=tuple(lines), limits=limits,
        specification=None if limit is None else limit.specification,
        conformity=None if limit is None else judged(
            value, u=u, expanded=k * u, degrees_of_freedom=freedom, limits=limits, rule=rule
        ),
    )  # fmt: skip


def _line(part: Contribution, name: str, *, rig: dict[str, RigValue]) -> BudgetLine:
    """What was measured and how much of it counts; without such a number the effect on the measurand itself."""
    contribution = part.standard_uncertainty[name] or 0.0
    stated = rig.get(RIG_KEYS.get(part.source, ""))
    is_default_clock = part.source == CLOCK and stated is None
    distribution = "rectangular" if is_default_clock else "normal"
    freedom = _freedom(part.degrees_of_freedom)
    if part.type == "A" and isfinite(freedom):
        distribution = "Student t"
    if part.measured is None or not part.measured.standard_uncertainty:
        return _own(part.source, contribution, kind=part.type, distribution=distribution, freedom=freedom)
    u = part.measured.standard_uncertainty
    estimate = stated.value if stated is not None and not isinstance(stated.value, str) else 0.0
    return BudgetLine(
        source=part.source, kind=part.type, distribution=distribution, estimate=estimate, u=u, unit=part.measured.unit,
        sensitivity=contribution / u, contribution=contribution, degrees_of_freedom=freedom,
    )  # fmt: skip


def _counts(contribution: float | None, u: float) -> bool:
    """Whether it is more than what numbers are rounded to."""
    return contribution is not None and contribution > _LEAST_SHARE * u


def _own(source: str, u: float, *, kind: str = "A", distribution: str = "normal", freedom: float = inf) -> BudgetLine:
    """A correction in the unit of the measurand, a time, expected to be none."""
    return BudgetLine(
        source=source, kind=kind, distribution=distribution, estimate=0.0, u=u, unit="s", sensitivity=1.0, contribution=u,
        degrees_of_freedom=freedom,
    )  # fmt: skip


def _relative(result: Result, combined: CombinedDelay) -> Measurand:
    """Delay beyond that of the smallest set delay; the clock's part is the nominal delay times its relative uncertainty."""
    u = combined.standard_uncertainty or 0.0
    if not combined.nominal > 0:
        raise ArchiveError(
            f"the result has a relative delay of nominally {combined.nominal:g} s with u = {u:g}, which no analysis gives; write "
            "it anew with irtiming analyse --json"
        )
    single = [one for one in result.relative_delays if abs(one.nominal - combined.nominal) < 1e-9]
    clock = max((_beyond(one.standard_uncertainty, one.deviation_standard_uncertainty) for one in single), default=0.0)
    clock = min(clock, u)
    part = next((part for part in result.contributions if part.source == CLOCK), None)
    u_rate = part.measured.standard_uncertainty if part is not None and part.measured is not None else 0.0
    rest = sqrt(max(0.0, u**2 - clock**2))
    lines = [_own("fit of the runs: noise, edges and their correlation", rest)]
    if clock > 0:
        rate = next((one for one in result.rig.values if one.name == RIG_KEYS[CLOCK]), None)
        known = u_rate or clock / combined.nominal
        lines.append(
            BudgetLine(
                source=CLOCK, kind="B", distribution="normal" if rate else "rectangular",
                estimate=rate.value if rate is not None and not isinstance(rate.value, str) else 0.0,
                u=known, unit="1", sensitivity=clock / known, contribution=clock, degrees_of_freedom=inf,
            )
        )  # fmt: skip
    k = budget.coverage_factor(inf)
    return Measurand(
        name="relative_delay", leads=False, value=combined.value or 0.0, u=u, expanded=k * u, coverage_factor=k,
        degrees_of_freedom=inf, unit=combined.unit, event=combined.reference_event, sign=combined.sign,
        budget=tuple(sorted(lines, key=lambda line: -line.contribution)), nominal_s=combined.nominal,
        speed_hz=combined.rotation_speed.value, runs=combined.runs,
    )  # fmt: skip


def _beyond(whole: float | None, part: float | None) -> float:
    """What a standard uncertainty has beyond a part of it."""
    if whole is None or part is None:
        return 0.0
    return sqrt(max(0.0, whole**2 - part**2))


def _freedom(said: float | None) -> float:
    return inf if said is None else said
