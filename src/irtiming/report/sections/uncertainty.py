"""Where the uncertainty comes from: budget, prediction and outcome, correlation, and the wheel edges one by one."""

from typing import TYPE_CHECKING

import numpy as np

from irtiming.records.analysis import Analysis
from irtiming.report import budget as budget_of
from irtiming.report import sheet
from irtiming.report.blocks import US, Panel, Section, Table, micro
from irtiming.report.combination import combined
from irtiming.report.language import decimal, heads, t, with_unit
from irtiming.report.meanings import edge_delay_name, event, headline, label, method_name, several_speeds, words
from irtiming.report.rounding import fixed, significant, uncertainty_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_NO_SHARE = 1e-8
_LEAST_PERCENT = 1e-3  # a ratio whose uncertainty is smaller is stated in ppm
_MOST_NAMED = 8


def section(analysis: Analysis) -> Section:
    """Budget as bars and as a table, what was predicted, correlation, and delays by edge."""
    more = (compared(analysis),) if analysis.prediction is not None else ()
    return Section(
        title=t("Uncertainty"),
        blocks=(_budget_panel(analysis), budget(analysis), *more, correlation(analysis), _edge_panel(analysis)),
    )


def _budget_panel(analysis: Analysis) -> Panel:
    return Panel(
        title=t("Where the uncertainty comes from"),
        caption=t(
            "Contributions to the standard uncertainties. Blue: type A, from this measurement; red: type B, from "
            "rig.toml. The long bars are the ones worth measuring better."
        ),
        svg=sheet.svg(draw_budget(analysis), title=t("Uncertainty budget")),
    )


def budget(analysis: Analysis) -> Table:
    """Uncertainty budget of the parameters that the verdict states, the largest part of the first first."""
    names = headline(analysis, analysis.result)
    found = {name: budget_of.of(analysis.result, name) for name in names}
    rows = []
    for line in found[names[0]].lines:
        sizes = [
            (one, whole.share(line.source))
            for whole in found.values()
            for one in whole.lines
            if one.source == line.source
        ]
        cells = ["0" if share < _NO_SHARE else f"{micro(one.standard_uncertainty)} ({budget_of.share_text(share)})"
                 for one, share in sizes]  # fmt: skip
        rows.append(
            (t(line.source), line.kind, budget_of.freedom_text(line.degrees_of_freedom), *cells, *_sensitivity(line))
        )
    sums = [micro(whole.standard_uncertainty) for whole in found.values()]
    rows.append((t("all together (root of the sum of squares)"), "", "", *sums))
    rows.append(
        (t("ν, all together"), "", "", *(budget_of.freedom_text(one.degrees_of_freedom) for one in found.values()))
    )
    return Table(
        title=t("Uncertainty budget"),
        columns=(
            t("source"),
            t("type"),
            "ν",
            *(f"{words(name)}: u (µs)" for name in names),
            t("u of what was measured"),
            t("{name}: sensitivity", name=words(names[0])),
        ),
        align="lcr" + "r" * len(names) + "rr",
        rows=tuple(row if len(row) > len(names) + 3 else (*row, "", "") for row in rows),
        note=t(
            "In brackets the share of u². Type A: from the scatter of this measurement; type B: from rig.toml. Angle "
            "errors become times by division through the wheel’s angular frequency; they touch delays alone, and "
            "angles common to all recordings of one wheel speed drop out of the relative delays. ν, degrees of "
            "freedom: how well u itself is known; those of the sums by Welch and Satterthwaite. Sensitivity: what a "
            "line adds over the standard uncertainty of what was measured."
        ),
    )


def _sensitivity(line: budget_of.Line) -> tuple[str, str]:
    """What was measured and how the parameter follows it, in units that people measure in; a dash without such a number."""
    if line.measured is None or line.sensitivity is None:
        return "–", "–"
    u, unit = line.measured
    ratio = (1e-6, "ppm") if u < _LEAST_PERCENT else (1e-2, "%")
    scale, shown = {"m": (1e-3, "mm"), "s": (US, "µs"), "rad": (1e-3, "mrad"), "1": ratio}.get(unit, (1.0, unit))
    return with_unit(significant(u / scale), shown), with_unit(
        significant(line.sensitivity * scale / US), f"µs/{shown}"
    )


def draw_budget(analysis: Analysis) -> "Figure":
    """Contributions to the standard uncertainties, the largest of the first parameter on top, and their sums."""
    names = headline(analysis, analysis.result)
    parts = sorted(analysis.result.budget, key=lambda part: part.standard_uncertainty.get(names[0], 0.0))
    sizes = np.array([[part.standard_uncertainty.get(name, 0.0) for name in names] for part in parts]).reshape(
        -1, len(names)
    )
    sizes = np.concatenate([sizes, np.sqrt(np.sum(sizes**2, axis=0))[None]])
    hues = [sheet.RED if part.kind == "B" else sheet.BLUE for part in parts] + [sheet.INK]
    labels = [f"{t(part.source)} ({part.kind})" for part in parts] + [t("all together")]
    with sheet.style():
        drawn = sheet.figure(height_in=0.9 + 0.3 * len(sizes))
        for k, axes in enumerate(drawn.subplots(1, len(names), sharey=True, squeeze=False)[0]):
            axes.barh(range(len(sizes)), sizes[:, k] / US, color=hues, alpha=0.75, height=0.62)
            for row, size in enumerate(sizes[:, k]):
                text = uncertainty_text(float(size)) if size > 1e-4 * sizes[-1, k] else "0"
                axes.annotate(text, (size / US, row), xytext=(4, 0), textcoords="offset points", va="center")
            axes.set_yticks(range(len(sizes)), labels)
            axes.set_xlim(0, (1.05 + 0.1 * len(names)) * max(float(sizes[:, k].max()) / US, 1e-12))
            axes.set_title(words(names[k]))
            axes.set_xlabel(t("standard uncertainty (µs)"))
            axes.grid(visible=False, axis="y")
    return drawn


def correlation(analysis: Analysis) -> Table:
    """Correlation of the parameters with all parts of their uncertainty."""
    estimate = analysis.result.estimate
    return Table(
        title=t("Correlation of the parameters"),
        columns=("", *(words(name) for name in estimate.names)),
        align="l" + "r" * len(estimate.names),
        rows=tuple(
            (label(name), *(fixed(float(value), 3) for value in row))
            for name, row in zip(estimate.names, estimate.correlation, strict=True)
        ),
        note=t(
            "With all parts of the budget. Angles of the rig move delays alone: where they are the largest part, "
            "little is left of what noise ties together."
        ),
    )


def compared(analysis: Analysis) -> Table:
    """Prediction and outcome side by side: whether the estimation tells as much as the recordings hold."""
    found, estimate = analysis.prediction, analysis.best.estimate
    rows = []
    if found is not None:
        stated = {(round(row.nominal_s, 9), row.rotation_speed_hz): row.standard_uncertainty_s
                  for row in combined(analysis, analysis.best)}  # fmt: skip
        several = len({speed for _, speed in stated}) > 1
        for each in found.uncertainties:
            u = estimate.u(each.name) if each.name in estimate else None
            rows.append(_outcome(label(each.name), each.standard_uncertainty_s, u, limit=t(each.largest_part.source)))
        for delay in found.relative_delays:
            at = t(" at {speed:g} Hz", speed=delay.rotation_speed_hz) if several else ""
            u = stated.get((round(delay.nominal_s, 9), delay.rotation_speed_hz))
            rows.append(
                _outcome(
                    t("relative delay of {nominal:g} ms{at}", nominal=1e3 * delay.nominal_s, at=at),
                    delay.standard_uncertainty_s,
                    u,
                )
            )
    return Table(
        title=t("Prediction and outcome"),
        columns=heads("parameter", "u predicted", "u stated", "stated / predicted", "largest part of the prediction"),
        align="lrrrl",
        rows=tuple(rows),
        note=t(
            "Predicted: from the Fisher information of the model, with the noise of the frames as found, taken as "
            "white, and the rig's angle errors; no estimate takes part in it. A ratio of 1: all that the recordings "
            "hold was used. Above 1: residuals are correlated, runs scatter more than their noise, or the recordings "
            "show something that noise and rig do not explain. Below 1: the estimate knows something that the prediction "
            "takes as unknown, or its uncertainty is too small."
        ),
    )


def _outcome(name: str, predicted_s: float, stated_s: float | None, *, limit: str = "") -> tuple[str, ...]:
    ratio = "–" if stated_s is None or predicted_s <= 0 else decimal(f"{stated_s / predicted_s:.2f}")
    return name, uncertainty_text(predicted_s), "–" if stated_s is None else uncertainty_text(stated_s), ratio, limit


def _edge_panel(analysis: Analysis) -> Panel:
    spread = uncertainty_text(float(np.ptp(analysis.best.edge_delay_s)))
    alone = (
        t(
            " Single recordings take all angles from rig.toml: where wheel speeds differ in delay, an angle is "
            "wrong, and the joint fit corrects it."
        )
        if several_speeds(analysis)
        else ""
    )
    return Panel(
        title=t("Delay by wheel edge"),
        caption=t(
            "Four edges of a perfect wheel would give one delay. Over all recordings these spread by {spread}: noise "
            "and the error of the cutout edges’ angles. Error bars: standard uncertainty from the noise of the "
            "frames alone, most of it common to the four where pixels lag.{alone}",
            spread=spread,
            alone=alone,
        ),
        svg=sheet.svg(by_edge(analysis), title=t("Delay by wheel edge")),
    )


def by_edge(analysis: Analysis) -> "Figure":
    """Delay by each wheel edge, by both methods where both tell edges apart; and recording by recording about the mean."""
    results = [(analysis.best, sheet.BLUE, "o", method_name(analysis.best.method))]
    if analysis.published is not None:
        results.append((analysis.published.result, sheet.ORANGE, "s", t("as published")))
    results = [one for one in results if np.isfinite(one[0].edge_delay_s).all()]
    with sheet.style():
        drawn = sheet.figure(height_in=3.3)
        *left, right = drawn.subplots(1, 2 if len(results) > 1 else 1, squeeze=False)[0]
        for axes in left:
            for k, (result, hue, marker, label) in enumerate(results):
                axes.errorbar(
                    np.arange(4) + 0.2 * k - 0.1, result.edge_delay_s / US, yerr=result.u_edge_delay_s / US, fmt=marker,
                    color=hue, markersize=5, capsize=3, label=label,
                )  # fmt: skip
            axes.set_title(t("Both methods"))
            axes.set_ylabel(f"{event(edge_delay_name(analysis), analysis)} (µs)")
            axes.legend(loc="best")
        _single(right, analysis)
        for axes in (*left, right):
            axes.set_xticks(
                range(4),
                [t("edge {edge}\nuncovers", edge=k) if k % 2 else t("edge {edge}\ncovers", edge=k) for k in range(4)],
            )
            axes.set_xlim(-0.5, 3.5)
            axes.set_xlabel(t("wheel edge (1)"))
            axes.grid(visible=False, axis="x")
    return drawn


def _single(axes: "Axes", analysis: Analysis) -> None:
    """Recording by recording."""
    n, mean = len(analysis.fits), float(np.mean([fit.edge_delay_s for fit in analysis.fits]))
    hues = sheet.colours([(one.trigger_delay_time_set_s, one.rotation_speed_hz) for one in analysis.recordings])
    for k, (fit, hue) in enumerate(zip(analysis.fits, hues, strict=True)):
        axes.errorbar(
            np.arange(4) + (0.5 * (k + 0.5) / n - 0.25), (fit.edge_delay_s - mean) / US,
            yerr=fit.estimate.standard_uncertainties[:4] / US, fmt=".", color=hue, markersize=6, elinewidth=0.9,
            label=fit.name if n <= _MOST_NAMED else None,
        )  # fmt: skip
    sheet.zero_line(axes)
    axes.set_title(t("Single recordings"))
    axes.set_ylabel(t("delay − {mean:.2f} µs (µs)", mean=mean / US))
    if n <= _MOST_NAMED:
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
