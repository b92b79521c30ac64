"""The answer in tables: the parameters, and the same by both methods."""

import numpy as np

from irtiming.records.analysis import Analysis
from irtiming.records.result import Result
from irtiming.report import budget
from irtiming.report.blocks import US, Section, Table
from irtiming.report.meanings import METHOD_NAMES, SIGN, SYMBOLS, bound_text, headline, meaning, unit_of
from irtiming.report.rounding import signed, time_text, time_unit, value_text

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
    return Section(title="Result", blocks=(parameters(analysis), *both))


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
        rows.append((name, value_text(value, u, unit=unit), *expanded, meaning(name, analysis).event))
    split = budget.falling_minus_rising(result)
    if split is not None:
        expanded = budget.expanded_text(split.standard_uncertainty_s, split.degrees_of_freedom)
        text = time_text(split.value_s, split.standard_uncertainty_s)
        apart = "" if result.falling_rising is not None else "; one wheel speed does not tell a time from an angle"
        rows.append(("falling − rising", text, *expanded, f"0 expected{apart}"))
        rows += _as_time_and_angle(result)
    rows += [(one.name, bound_text(one), "–", "–", meaning(one.name, analysis).event) for one in result.bounds]
    return Table(
        title="Timing of the camera",
        columns=("parameter", "value ± u", "U = k u", "k", "what it is"),
        align="lrrrl",
        rows=tuple(rows),
        note="Delays count from the trigger edge. The delay set in the trigger generator is taken off. u is the standard "
        f"uncertainty (k = 1); value ± U holds the true one with {budget.COVERAGE_PERCENT} % probability. "
        f"Method: {METHOD_NAMES[result.method]}. {_signs(analysis)}",
    )


def _as_time_and_angle(result: Result) -> list[tuple[str, str, str, str, str]]:
    """Falling minus rising as a time that stays and an angle that shrinks with the wheel's speed."""
    found = result.falling_rising
    if found is None:
        return []
    (time, angle), (u_time, u_angle) = found.values.tolist(), found.standard_uncertainties.tolist()
    return [
        ("  constant time", time_text(time, u_time), "–", "–", "a detector that falls otherwise than it rises"),
        ("  angle", f"{1e6 * angle:.1f} ± {1e6 * u_angle:.1f} µrad", "–", "–", "mask and cutout edges, over ω"),
    ]


def _signs(analysis: Analysis) -> str:
    """The signs, each once, with the parameters that have it."""
    result, of = analysis.result, dict[str, list[str]]()
    for name in (*result.estimate.names, *(bound.name for bound in result.bounds)):
        sign = meaning(name, analysis).sign
        if sign is not None:
            of.setdefault(sign, []).append(name)
    delays = of.pop(SIGN, [])
    signs = [f"Delays: {SIGN}."] if delays else []
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
            difference = f"{signed(other - value, float(np.hypot(u, u_other)), unit_s=US)} µs"
        rows.append((name, *texts, difference))
    splits = [budget.falling_minus_rising(result) for result in (best, published)]
    texts = [time_text(split.value_s, split.standard_uncertainty_s) for split in splits if split is not None]
    if len(texts) == len(splits):
        rows.append(("falling − rising", *texts, ""))
    name = METHOD_NAMES[best.method]
    return Table(
        title="Both methods",
        columns=("parameter", name, "as published", f"published − {name}"),
        align="lrrr",
        rows=tuple(rows),
        note=f"Delays: {SIGN}. {_NOTES[best.method]}",
    )


def beside_the_truth(analysis: Analysis, truth_s: dict[str, float]) -> Table:
    """The methods beside the true values of a simulated camera, and how many standard uncertainties they are off."""
    results = [analysis.best, *(() if analysis.published is None else (analysis.published.result,))]
    found = [entries(result) for result in results]
    rows = []
    for name in headline(analysis, analysis.best):
        factor, unit = time_unit(truth_s[name])
        cells = [f"{truth_s[name] / factor:.5g} {unit}"]
        for ours in found:
            if name not in ours:
                cells += ["not determined", "–"]
                continue
            value, u = ours[name]
            cells += [time_text(value, u), f"{(value - truth_s[name]) / u:+.1f}".replace("-", "−")]
        rows.append((SYMBOLS.get(name, name), *cells))
    methods = [METHOD_NAMES[analysis.best.method], "as published"][: len(results)]
    return Table(
        title=f"Timing of the simulated {analysis.camera_type} camera",
        columns=("", "true", *(cell for name in methods for cell in (name, "off/u"))),
        align="lr" + "rr" * len(results),
        rows=tuple(rows),
        note=f"t_delay: {meaning('trigger_delay', analysis).event.split(' (')[0]}; {SIGN}.",
    )
