"""What was measured, in one sentence, and what to know beside it."""

import numpy as np

from irtiming.records.analysis import Analysis
from irtiming.records.result import Result
from irtiming.report import budget, outside
from irtiming.report.combination import combined
from irtiming.report.language import several, t, with_capital, with_unit
from irtiming.report.meanings import bound_text, event_in_english, has_lag, headline, method_name, words
from irtiming.report.page import Verdict
from irtiming.report.rounding import time_text, uncertainty_text
from irtiming.report.sections.parameters import entries


def verdict(analysis: Analysis) -> Verdict:
    """The numbers, what they are, and what limits each."""
    result = analysis.result
    found = entries(result)
    bounds = {bound.name: bound_text(bound) for bound in result.bounds}
    names = headline(analysis, result)
    numbers = [
        f"{words(name)} = {time_text(*found[name])}"
        if name in found
        else f"{words(name)}: {bounds.get(name, t('unknown'))}"
        for name in names
    ]
    return Verdict(
        number=numbers[0],
        outside=outside.behind(result.not_in_uncertainty) if names[0] in found else "",
        doubted=t("in doubt: may be wrong by more than its uncertainty says") if _is_contradicted(analysis) else "",
        further=tuple(numbers[1:]),
        sentence=_sentence(analysis, names, found=found, bounds=bounds) + _in_doubt(analysis),
        remarks=tuple(text for text in _remarks(analysis, names, found=found) if text),
    )


def _is_contradicted(analysis: Analysis) -> bool:
    """Whether more is in doubt than what is not stated, which the line of what the uncertainty does not hold says already."""
    return any(one.severity == "doubt" and not one.code.endswith(_UNSTATED) for one in analysis.findings)


_UNSTATED = ("-not-stated", "-on-trust")


def _in_doubt(analysis: Analysis) -> str:
    """How many findings doubt the numbers; empty where none does."""
    number = sum(one.severity == "doubt" for one in analysis.findings)
    return t(" {doubts}, see below.", doubts=several(number, "doubt")) if number else ""


def _sentence(
    analysis: Analysis, names: tuple[str, ...], *, found: dict[str, tuple[float, float]], bounds: dict[str, str]
) -> str:
    """What the numbers mean, where they are determined and where not."""
    result, parts = analysis.result, list[str]()
    for name in names:
        if name not in found:
            what = t(
                "the {name} is not determined ({bounds}, k = 2)",
                name=words(name),
                bounds=bounds.get(name, t("no bounds")),
            )
            parts.append(what if parts else with_capital(what))
        elif name == names[0]:
            parts.append(_first(analysis, *found[name], name=name))
        elif name == "row_delay":
            value, u = found[name]
            size = time_text(abs(value), u)
            later = t("each row below it later by {time}", time=size)
            parts.insert(1, later if value >= 0 else t("each row below it earlier by {time}", time=size))
        else:
            parts.append(
                t(
                    "a pixel needs {time} for 63 % of its response to a step of the scene",
                    time=time_text(*found[name]),
                )
            )
    lag = f"; {parts.pop()}" if "time_constant" in names else ""
    by = t(
        "by {method} from {recordings}",
        method=method_name(result.method),
        recordings=several(len(analysis.recordings), "recording"),
    )
    beside = outside.listed(result.not_in_uncertainty)
    if len(names) > 1 or names[0] not in found:
        return t(
            "{parts}{lag}, {by} (standard uncertainties, k = 1).{without}",
            parts=", ".join(parts),
            lag=lag,
            by=by,
            without=t(" Not in these uncertainties: {what}.", what=beside) if beside else "",
        )
    expanded, factor = budget.expanded_text(found[names[0]][1], budget.of(result, names[0]).degrees_of_freedom)
    known = t(
        "(standard uncertainty, k = 1; expanded uncertainty U = {expanded}, k = {factor})",
        expanded=expanded,
        factor=factor,
    )
    without = t(" Not in this uncertainty: {what}.", what=beside) if beside else ""
    return f"{', '.join(parts)} {known}, {by}.{without}"


def _first(analysis: Analysis, value: float, u: float, *, name: str) -> str:
    """When the event comes."""
    size = time_text(abs(value), u)
    after = t("{time} after the trigger edge that the camera accepts", time=size)
    side = after if value >= 0 else t("{time} before the trigger edge that the camera accepts", time=size)
    what = event_in_english(name, analysis)
    if has_lag(analysis):
        return t(f"{with_capital(what.removeprefix('reading of '))} is read {{side}}", side=side)
    return t(f"The {what} comes {{side}}", side=side)


def _remarks(analysis: Analysis, names: tuple[str, ...], *, found: dict[str, tuple[float, float]]) -> list[str]:
    relative, split = _relative(analysis), _split(analysis)
    if len(names) == 1:
        return [relative, _largest(analysis.result, names[0]), split]
    limits = [_limit(analysis.result, name, found[name][1]) for name in names if name in found]
    return [*limits, _readout(analysis), relative, split]


def _relative(analysis: Analysis) -> str:
    rows = combined(analysis, analysis.result)
    if not rows:
        return t("All recordings have the same delay set: no relative delay to check the measurement with.")
    rms = float(np.sqrt(np.mean([row.deviation_s**2 for row in rows])))
    worst = max(rows, key=lambda row: abs(row.deviation_s) / max(row.u_deviation_s, 1e-15))
    ratio = abs(worst.deviation_s) / worst.u_deviation_s if worst.u_deviation_s > 0 else float("inf")
    return t(
        "Relative delays meet what was set within {rms} rms over {rows}; the largest deviation is {ratio:.1f} of "
        "its standard uncertainty.",
        rms=uncertainty_text(rms),
        rows=several(len(rows), "nominal delay"),
        ratio=ratio,
    )


def _largest(result: Result, name: str) -> str:
    lines = budget.of(result, name).lines
    if len(lines) < 2:
        return ""
    size = uncertainty_text(lines[0].standard_uncertainty)
    return t(
        "The largest part of the uncertainty is: {source}, {size} (type {kind}).",
        source=t(lines[0].source),
        size=size,
        kind=lines[0].kind,
    )


def _limit(result: Result, name: str, u: float) -> str:
    whole = budget.of(result, name)
    expanded, factor = budget.expanded_text(u, whole.degrees_of_freedom)
    start = f"{with_capital(words(name))}: U = {expanded} (k = {factor})"
    if len(whole.lines) < 2:
        return t("{start}; a single part of uncertainty is known.", start=start)
    line = whole.lines[0]
    size = uncertainty_text(line.standard_uncertainty)
    return t(
        "{start}; the largest part of u is {source}, {size} (type {kind}).",
        start=start,
        source=t(line.source),
        size=size,
        kind=line.kind,
    )


def _split(analysis: Analysis) -> str:
    split = budget.falling_minus_rising(analysis.result)
    if split is None:
        return ""
    value, u = split.value_s, split.standard_uncertainty_s
    agrees = abs(value) <= budget.coverage_factor(split.degrees_of_freedom) * u
    said = time_text(value, u)
    if agrees:
        return t("Delays from falling and from rising slopes agree: falling − rising = {time}.", time=said)
    return t("Delays from falling and from rising slopes differ: falling − rising = {time}.", time=said)


def last_row_read(analysis: Analysis, result: Result) -> tuple[int, float, float] | None:
    """Last row, when it is read or starts to integrate, and the standard uncertainty of that, s; None where it is not known."""
    if "trigger_delay" not in result.estimate or "row_delay" not in result.estimate:
        return None
    row = analysis.recordings[0].opening.mask.shape[0] - 1
    found, weights = result.estimate.pick("trigger_delay", "row_delay"), np.array([1.0, float(row)])
    variance = float(weights @ found.covariance @ weights)
    return row, float(weights @ found.values), float(np.sqrt(max(variance, 0.0)))


def _readout(analysis: Analysis) -> str:
    """By when the last row is read, and which way the readout goes."""
    last = last_row_read(analysis, analysis.result)
    if last is None:
        return ""
    row, value, u = last
    first, reads = analysis.result.estimate.value("trigger_delay"), has_lag(analysis)
    size = time_text(abs(value - first), u)
    span = t("the whole readout takes {time}", time=with_unit(size.split(" ± ")[0], size.split()[-1]))
    when = t("{time} after the trigger edge", time=time_text(value, u))
    if value >= first and reads:
        return t("The last row (y = {row}) is read {when}; {span}.", row=row, when=when, span=span)
    if value >= first:
        return t("The last row (y = {row}) starts to integrate {when}; {span}.", row=row, when=when, span=span)
    if reads:
        return t(
            "Rows are read from the bottom up: row {row} first, {when}, row 0 last; {span}.",
            row=row,
            when=when,
            span=span,
        )
    return t(
        "Rows integrate from the bottom up: row {row} first, {when}, row 0 last; {span}.", row=row, when=when, span=span
    )
