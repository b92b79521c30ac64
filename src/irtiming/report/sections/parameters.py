"""The answer in tables: the parameters, and the same by both methods."""

import numpy as np

from irtiming.records.analysis import Analysis
from irtiming.records.result import DelayScatter, Result
from irtiming.report import budget
from irtiming.report.blocks import US, Section, Table
from irtiming.report.language import decimal, heads, t, with_unit
from irtiming.report.meanings import SIGN, SYMBOLS, bound_text, headline, label, meaning, method_name, unit_of
from irtiming.report.rounding import signed, time_text, time_unit, uncertainty_text, value_text

_NOTES = {
    "pixel-sum": "Pixel sums: an exact model of the sums, learned slots, one delay per wheel edge. As published: threshold "
    "counts, "
    "equal slots, straight lines; its u holds the scatter of the lines only. The paper’s camera: falling 567.74 ± 2.06 µs, "
    "rising "
    "488.91 ± 2.77 µs, “cause not apparent”; what its slopes give is the middle of integration.",
    "row-sum": "Row sums: an exact model of all rows at once, with the blurred edges of mask and light, learned slots and one "
    "delay per wheel edge. As published: binary mask, equal slots, simulated rows, a straight line over the rows and a "
    "parabola over the time constant; its u holds the scatter of these two only. The paper’s camera: τ 4.819 ms, "
    "t_delay 3.872 ms, t_row 38.76 µs.",
}


def section(analysis: Analysis) -> Section:
    """Parameters of the chosen method, and both methods where both were made."""
    theirs = analysis.published
    both = (both_methods(analysis),) if theirs is not None and theirs.result.estimate.names else ()
    return Section(title=t("Result"), blocks=(parameters(analysis), *both))


def entries(result: Result) -> dict[str, tuple[float, float]]:
    """Value and standard uncertainty of each determined parameter, in its unit, by name."""
    estimate = result.estimate
    return {name: (estimate.value(name), estimate.u(name)) for name in estimate.names}


def parameters(analysis: Analysis) -> Table:
    """The chosen method's: value, standard uncertainty u, expanded uncertainty U and event; signs in the note."""
    result, rows = analysis.result, []
    for name, (value, u) in entries(result).items():
        unit = unit_of(name, result)
        expanded = budget.expanded_text(u, budget.of(result, name).degrees_of_freedom, unit=unit)
        rows.append((label(name), value_text(value, u, unit=unit), *expanded, meaning(name, analysis).event))
    split = budget.falling_minus_rising(result)
    if split is not None:
        expanded = budget.expanded_text(split.standard_uncertainty_s, split.degrees_of_freedom)
        text = time_text(split.value_s, split.standard_uncertainty_s)
        apart = (
            ""
            if result.falling_rising is not None
            else t("; one wheel speed does not distinguish a time from an angle")
        )
        rows.append((t("falling − rising"), text, *expanded, t("0 expected{apart}", apart=apart)))
        rows += _as_time_and_angle(result)
    rows += [(label(one.name), bound_text(one), "–", "–", meaning(one.name, analysis).event) for one in result.bounds]
    if result.delay_scatter is not None:
        text = _scatter_text(result.delay_scatter)
        rows.append((t("scatter of the delay"), text, "–", "–", t("standard deviation from frame to frame")))
    return Table(
        title=t("Timing of the camera"),
        columns=heads("parameter", "value ± u", "U = k u", "k", "what it is"),
        align="lrrrl",
        rows=tuple(rows),
        note=t(
            "Delays count from the trigger edge. The delay set in the trigger generator is taken off. u is the "
            "standard uncertainty (k = 1); value ± U holds the true one with {percent} % probability. "
            "Method: {method}. {signs}",
            percent=budget.COVERAGE_PERCENT,
            method=method_name(result.method),
            signs=_signs(analysis),
        ),
    )


def _scatter_text(found: DelayScatter) -> str:
    if found.is_sure:
        return time_text(found.standard_deviation_s, found.u_s)
    return t("below {limit}", limit=uncertainty_text(found.upper_limit_s))


def _as_time_and_angle(result: Result) -> list[tuple[str, str, str, str, str]]:
    """Falling minus rising as a time that stays and an angle that shrinks with the wheel's speed."""
    found = result.falling_rising
    if found is None:
        return []
    (time, angle), (u_time, u_angle) = found.values.tolist(), found.standard_uncertainties.tolist()
    return [
        (
            "  " + t("constant time"),
            time_text(time, u_time),
            "–",
            "–",
            t("a detector that falls otherwise than it rises"),
        ),
        (
            "  " + t("angle"),
            value_text(angle, u_angle, unit="rad"),
            "–",
            "–",
            t("mask and cutout edges, over ω"),
        ),
    ]


def _signs(analysis: Analysis) -> str:
    """The signs, each once, with the parameters that have it."""
    result, of = analysis.result, dict[str, list[str]]()
    for name in (*result.estimate.names, *(bound.name for bound in result.bounds)):
        sign = meaning(name, analysis).sign
        if sign is not None:
            of.setdefault(sign, []).append(label(name))
    delays = of.pop(t(SIGN), [])
    signs = [t("Delays: {sign}.", sign=t(SIGN))] if delays else []
    return " ".join([*signs, *(f"{', '.join(names)}: {sign}." for sign, names in of.items())])


def both_methods(analysis: Analysis) -> Table:
    """The same parameters by the default method and by the published procedure, side by side."""
    best = analysis.best
    published = best if analysis.published is None else analysis.published.result
    ours, theirs = entries(best), entries(published)
    bounds = {bound.name: bound_text(bound) for result in (published, best) for bound in result.bounds}
    rows = []
    for name in dict.fromkeys([*ours, *bounds, *theirs]):
        unit = unit_of(name, best) if name in ours else "s"
        texts = [
            value_text(*found[name], unit=unit) if name in found else bounds.get(name, "–") for found in (ours, theirs)
        ]
        difference = "–"
        if name in ours and name in theirs:
            (value, u), (other, u_other) = ours[name], theirs[name]
            difference = with_unit(signed(other - value, float(np.hypot(u, u_other)), unit_s=US), "µs")
        rows.append((label(name), *texts, difference))
    splits = [budget.falling_minus_rising(result) for result in (best, published)]
    texts = [time_text(split.value_s, split.standard_uncertainty_s) for split in splits if split is not None]
    if len(texts) == len(splits):
        rows.append((t("falling − rising"), *texts, ""))
    name = method_name(best.method)
    return Table(
        title=t("Both methods"),
        columns=(t("parameter"), name, t("as published"), t("published − {name}", name=name)),
        align="lrrr",
        rows=tuple(rows),
        note=t("Delays: {sign}. {notes}", sign=t(SIGN), notes=t(_NOTES[best.method])),
    )


def beside_the_truth(analysis: Analysis, truth_s: dict[str, float]) -> Table:
    """The methods beside the true values of a simulated camera, and how many standard uncertainties they are off."""
    results = [analysis.best, *(() if analysis.published is None else (analysis.published.result,))]
    found = [entries(result) for result in results]
    rows = []
    for name in headline(analysis, analysis.best):
        factor, unit = time_unit(truth_s[name])
        cells = [with_unit(decimal(f"{truth_s[name] / factor:.5g}"), unit)]
        for ours in found:
            if name not in ours:
                cells += [t("not determined"), "–"]
                continue
            value, u = ours[name]
            cells += [time_text(value, u), decimal(f"{(value - truth_s[name]) / u:+.1f}")]
        rows.append((SYMBOLS.get(name, name), *cells))
    methods = [method_name(analysis.best.method), t("as published")][: len(results)]
    return Table(
        title=t("Timing of the simulated {camera_type} camera", camera_type=analysis.camera_type),
        columns=("", t("true"), *(cell for name in methods for cell in (name, t("off/u")))),
        align="lr" + "rr" * len(results),
        rows=tuple(rows),
        note=t("t_delay: {part}; {sign}.", part=meaning("trigger_delay", analysis).event.split(" (")[0], sign=t(SIGN)),
    )
