"""Relative delays: per nominal delay beside the paper's Table 1, recording by recording, and as a figure."""

from dataclasses import replace
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np

from irtiming.records.analysis import Analysis
from irtiming.records.result import RelativeDelay, Result
from irtiming.report import sheet
from irtiming.report.blocks import MS, US, Panel, Section, Table, micro
from irtiming.report.combination import PAPER_TABLE_1, combined
from irtiming.report.language import decimal, t
from irtiming.report.meanings import RELATIVE_SIGN, has_pixel_sums, method_name, relative_event
from irtiming.report.rounding import fixed, in_unit, signed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def section(analysis: Analysis) -> Section | None:
    """Tables and figure; None where all recordings have one set delay."""
    if not combined(analysis, analysis.best):
        return None
    ours, *theirs = (combined_delays(analysis, result) for result in results(analysis))
    tables = (ours, *(replace(table, note="") for table in theirs))
    return Section(title=t("Relative delays"), blocks=(*tables, panel(analysis), by_file(analysis)))


def results(analysis: Analysis) -> tuple[Result, ...]:
    """The default method's, and the published one's where it has relative delays."""
    published = analysis.published
    return (analysis.best,) if published is None or not published.result.relative_delays else (
        analysis.best, published.result,
    )  # fmt: skip


def note(analysis: Analysis) -> str:
    """Event and sign of relative delays."""
    return t("Relative delay: {event}; {sign}.", event=relative_event(analysis), sign=t(RELATIVE_SIGN))


def combined_delays(analysis: Analysis, result: Result | None = None) -> Table:
    """Relative delays per nominal delay; beside pixel sums those that the paper printed for its camera (Table 1)."""
    chosen = result or analysis.result
    beside = has_pixel_sums(analysis)
    paper = {round(nominal, 9): entry for nominal, *entry in PAPER_TABLE_1} if beside else {}
    rows = []
    ours = combined(analysis, chosen)
    several = len({row.rotation_speed_hz for row in ours}) > 1
    for row in ours:
        printed = _paper_cells(*paper.pop(row.nominal_s, (None, None, None)))
        rows.append(
            (
                decimal(f"{row.nominal_s / MS:g}")
                + (t(" at {speed:g} Hz", speed=row.rotation_speed_hz) if several else ""),
                str(row.n_runs),
                in_unit(row.value_s, row.standard_uncertainty_s, unit_s=MS),
                micro(row.standard_uncertainty_s),
                signed(row.deviation_s, row.u_deviation_s, unit_s=US),
                "–" if row.scatter_s is None else micro(row.scatter_s),
                *(printed if beside else ()),
            )
        )
    rows += [
        (decimal(f"{nominal / MS:g}"), "–", "–", "–", "–", "–", *_paper_cells(*entry))
        for nominal, entry in paper.items()
    ]
    heads = (t("paper: measured (ms)"), t("paper: u (µs)"), t("paper: deviation (µs)")) if beside else ()
    of_paper = t("Ours: this camera. Paper: Schatz 2023, Table 1, IRcam Equus 327k L, 20 runs each. ") if beside else ""
    return Table(
        title=t("Relative trigger delays, {method}", method=method_name(chosen.method)),
        columns=(
            t("nominal (ms)"),
            t("runs"),
            t("measured (ms)"),
            t("u (µs)"),
            t("deviation (µs)"),
            t("scatter of runs (µs)"),
            *heads,
        ),
        align="rrrrrr" + "r" * len(heads),
        rows=tuple(rows),
        note=t(
            "{of_paper}u is the standard uncertainty of the mean over the runs, in SI seconds with that of the "
            "generator’s clock; noise averages over runs, what they have in common does not. Deviation: measured "
            "minus nominal in the generator’s own time, where its clock cancels. Scatter is the standard deviation "
            "of single runs. {relative}",
            of_paper=of_paper,
            relative=note(analysis),
        ),
    )


def _paper_cells(measured: float | None, u: float | None, deviation: float | None) -> tuple[str, str, str]:
    """As printed, to the last digit."""
    if measured is None or u is None or deviation is None:
        return "–", "–", "–"
    return decimal(f"{measured / MS:.3f}"), decimal(f"{u / US:.3f}"), fixed(deviation / US, 3)


def beside_the_paper(analysis: Analysis) -> Table:
    """Table 1 in short: deviation from the nominal delay, the paper's, and ours by both methods."""
    paper = {round(nominal, 9): (u, deviation) for nominal, _, u, deviation in PAPER_TABLE_1}
    both = [combined(analysis, result) for result in results(analysis)]
    rows = []
    for best, *others in zip_longest(*both):
        u_paper, deviation = paper.get(best.nominal_s, (None, None))
        cells = [
            "–" if row is None
            else f"{signed(row.deviation_s, row.u_deviation_s, unit_s=US)} ± {micro(row.u_deviation_s)}"
            for row in (*others, best)
        ]  # fmt: skip
        printed = (
            "–" if u_paper is None or deviation is None else decimal(f"{deviation / US:+.3f} ± {u_paper / US:.3f}")
        )
        rows.append((decimal(f"{best.nominal_s / MS:g}"), printed.replace("-", "−"), *cells))
    columns = (
        *((t("here, as published"),) if len(both) > 1 else ()),
        t("here, {method}", method=method_name(analysis.best.method)),
    )
    return Table(
        title=t("Relative trigger delays: deviation from nominal in µs (Table 1)"),
        columns=(t("nominal (ms)"), t("the paper's camera"), *columns),
        align="rr" + "r" * len(columns),
        rows=tuple(rows),
        note=note(analysis),
    )


def by_file(analysis: Analysis) -> Table:
    """Relative delay of every recording by both methods, µs from nominal; no rows with a single set delay."""
    names = {recording.file: recording.name for recording in analysis.recordings}
    given = [{delay.file: delay for delay in result.relative_delays} for result in results(analysis)]
    several = len({round(delay.nominal_s, 9) for delay in analysis.best.relative_delays}) > 1
    rows = [
        (
            names.get(delay.file, delay.file),
            decimal(f"{delay.nominal_s / MS:g}"),
            *(cell for found in given for cell in _deviation(found.get(delay.file))),
        )
        for delay in analysis.best.relative_delays
    ]
    methods = [method_name(analysis.best.method), t("published")][: len(given)]
    heads = [head for name in methods for head in (t("{name}: deviation (µs)", name=name), f"{name}: u (µs)")]
    return Table(
        title=t("Relative delays, recording by recording"),
        columns=(t("recording"), t("nominal (ms)"), *heads),
        align="lr" + "r" * len(heads),
        rows=tuple(rows) if several else (),
        note=t(
            "Deviation is measured minus nominal in the generator’s own time, u its standard uncertainty; the "
            "generator sets delays to a tick of its clock. What else the camera has is taken as one for all "
            "recordings. The published method averages the runs of one nominal delay, which share their value. "
            "{relative}",
            relative=note(analysis),
        ),
    )


def _deviation(delay: RelativeDelay | None) -> tuple[str, str]:
    if delay is None:
        return "–", "–"
    deviation, u = delay.deviation
    return signed(deviation, u, unit_s=US) if u > 0 else "reference", micro(u)


def panel(analysis: Analysis) -> Panel:
    """Deviations of the relative delays."""
    paper = t(" Grey: what the paper printed for another camera.") if has_pixel_sums(analysis) else ""
    return Panel(
        title=t("Relative delays: measured minus nominal"),
        caption=t(
            "The trigger generator sets delays to a tick of its clock, so each deviation is the measurement’s own "
            "error. Means over runs; error bars: standard uncertainty (k = 1).{paper} The ordinates differ.",
            paper=paper,
        ),
        svg=sheet.svg(figure(analysis), title=t("Deviations of the relative delays")),
    )


def figure(analysis: Analysis) -> "Figure":
    """Measured minus nominal, a panel per method, beside what the paper printed for its camera."""
    made = results(analysis)
    with sheet.style():
        drawn = sheet.figure(height_in=2.9)
        for axes, result, hue in zip(
            drawn.subplots(1, len(made), squeeze=False)[0], made, (sheet.BLUE, sheet.ORANGE), strict=False
        ):
            sheet.zero_line(axes)
            if has_pixel_sums(analysis):
                paper = np.array([(nominal, deviation, u) for nominal, _, u, deviation in PAPER_TABLE_1])
                _bars(axes, paper, "D", sheet.FAINT)
            rows = combined(analysis, result)
            ours = np.array([(row.nominal_s, row.deviation_s, row.u_deviation_s) for row in rows])
            _bars(axes, ours.reshape(-1, 3), "o", hue)
            axes.set_title(method_name(result.method))
            axes.set_xlabel(t("nominal relative delay (ms)"))
            axes.set_ylabel(t("measured − nominal (µs)"))
            axes.margins(x=0.15)
    return drawn


def _bars(axes: "Axes", points: np.ndarray, marker: str, hue: str) -> None:
    """Nominal delay, deviation and standard uncertainty of each point, s, shape (n, 3)."""
    axes.errorbar(
        1e3 * points[:, 0], points[:, 1] / US, yerr=points[:, 2] / US, fmt=marker, color=hue, markersize=4.5, capsize=3
    )
