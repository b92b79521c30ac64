"""What was measured, in one sentence, and what to know beside it."""

import numpy as np

from irtiming.records.analysis import Analysis
from irtiming.records.result import Result
from irtiming.report import budget
from irtiming.report.blocks import several
from irtiming.report.combination import combined
from irtiming.report.meanings import METHOD_NAMES, bound_text, event, has_lag, headline, words
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
        else f"{words(name)}: {bounds.get(name, 'unknown')}"
        for name in names
    ]
    without = f" ({trusted(result)} not in u)" if result.not_in_uncertainty and names[0] in found else ""
    return Verdict(
        number=numbers[0] + without,
        further=tuple(numbers[1:]),
        sentence=_sentence(analysis, names, found=found, bounds=bounds),
        remarks=tuple(text for text in _remarks(analysis, names, found=found) if text),
    )


def _sentence(
    analysis: Analysis, names: tuple[str, ...], *, found: dict[str, tuple[float, float]], bounds: dict[str, str]
) -> str:
    """What the numbers mean, where they are determined and where not."""
    result, parts = analysis.result, list[str]()
    for name in names:
        if name not in found:
            what = f"the {words(name)} is not determined ({bounds.get(name, 'no bounds')}, k = 2)"
            parts.append(what if parts else what.capitalize())
        elif name == names[0]:
            parts.append(_first(analysis, *found[name], name=name))
        elif name == "row_delay":
            order = "later" if found[name][0] >= 0 else "earlier"
            value, u = found[name]
            parts.insert(1, f"each row below it {order} by {time_text(abs(value), u)}")
        else:
            parts.append(f"a pixel needs {time_text(*found[name])} for 63 % of its response to a step of the scene")
    lag = f"; {parts.pop()}" if "time_constant" in names else ""
    by = f"by {METHOD_NAMES[result.method]} from {several(len(analysis.recordings), 'recording')}"
    without = "" if not result.not_in_uncertainty else f" Not in these uncertainties: {trusted(result)}."
    if len(names) > 1 or names[0] not in found:
        return f"{', '.join(parts)}{lag}, {by} (standard uncertainties, k = 1).{without}"
    expanded, factor = budget.expanded_text(found[names[0]][1], budget.of(result, names[0]).degrees_of_freedom)
    known = f"(standard uncertainty, k = 1; expanded uncertainty U = {expanded}, k = {factor})"
    return f"{', '.join(parts)} {known}, {by}.{without.replace('these uncertainties', 'this uncertainty')}"


def trusted(result: Result) -> str:
    """What the uncertainties do not hold, in words."""
    return "; ".join(result.not_in_uncertainty)


def _first(analysis: Analysis, value: float, u: float, *, name: str) -> str:
    """When the event comes."""
    side = f"{time_text(abs(value), u)} {'after' if value >= 0 else 'before'} the trigger edge that the camera accepts"
    what = event(name, analysis)
    if has_lag(analysis):
        subject = what.removeprefix("reading of ")
        return f"{subject.capitalize()} is read {side}"
    return f"The {what} comes {side}"


def _remarks(analysis: Analysis, names: tuple[str, ...], *, found: dict[str, tuple[float, float]]) -> list[str]:
    relative, split = _relative(analysis), _split(analysis)
    if len(names) == 1:
        return [relative, _largest(analysis.result, names[0]), split]
    limits = [_limit(analysis.result, name, found[name][1]) for name in names if name in found]
    return [*limits, _readout(analysis), relative, split]


def _relative(analysis: Analysis) -> str:
    rows = combined(analysis, analysis.result)
    if not rows:
        return "All recordings have the same delay set: no relative delay to check the measurement with."
    rms = float(np.sqrt(np.mean([row.deviation_s**2 for row in rows])))
    worst = max(rows, key=lambda row: abs(row.deviation_s) / max(row.u_deviation_s, 1e-15))
    ratio = abs(worst.deviation_s) / worst.u_deviation_s if worst.u_deviation_s > 0 else float("inf")
    return (
        f"Relative delays meet what was set within {uncertainty_text(rms)} rms over {several(len(rows), 'nominal delay')}; "
        f"the largest deviation is {ratio:.1f} of its standard uncertainty."
    )


def _largest(result: Result, name: str) -> str:
    lines = budget.of(result, name).lines
    if len(lines) < 2:
        return ""
    size = uncertainty_text(lines[0].standard_uncertainty)
    return f"The largest part of the uncertainty is: {lines[0].source}, {size} (type {lines[0].kind})."


def _limit(result: Result, name: str, u: float) -> str:
    whole = budget.of(result, name)
    expanded, factor = budget.expanded_text(u, whole.degrees_of_freedom)
    start = f"{words(name).capitalize()}: U = {expanded} (k = {factor})"
    if len(whole.lines) < 2:
        return f"{start}; a single part of uncertainty is known."
    line = whole.lines[0]
    size = uncertainty_text(line.standard_uncertainty)
    return f"{start}; the largest part of u is {line.source}, {size} (type {line.kind})."


def _split(analysis: Analysis) -> str:
    split = budget.falling_minus_rising(analysis.result)
    if split is None:
        return ""
    value, u = split.value_s, split.standard_uncertainty_s
    agrees = abs(value) <= budget.coverage_factor(split.degrees_of_freedom) * u
    return (
        f"Delays from falling and from rising slopes {'agree' if agrees else 'differ'}: falling − rising = "
        f"{time_text(value, u)}."
    )


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
    unit = time_text(abs(value - first)).split()[-1]
    span = f"the whole readout takes {time_text(abs(value - first), u)}".split(" ± ")[0]
    when = f"{time_text(value, u)} after the trigger edge"
    if value >= first:
        what = "is read" if reads else "starts to integrate"
        return f"The last row (y = {row}) {what} {when}; {span} {unit}."
    return f"Rows {'are read' if reads else 'integrate'} from the bottom up: row {row} first, {when}, row 0 last; {span} {unit}."
