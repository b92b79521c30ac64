"""Sections of a campaign's page: what was judged, control charts, findings, repeatability, and every line."""

from collections import Counter
from collections.abc import Iterator, Mapping
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from irtiming.records.campaign import WORST_FIRST, Campaign, CampaignLine, GaugeStudy, JudgedValue
from irtiming.records.setting_point import SETTINGS, SettingName
from irtiming.report import sheet
from irtiming.report.blocks import Panel, Section, Table
from irtiming.report.language import decimal, heads, several, t, with_capital, with_numbers, with_unit
from irtiming.report.meanings import words
from irtiming.report.rounding import time_text, value_text
from irtiming.report.sections.control_chart import Chart, charts, panel, size
from irtiming.report.sections.over_settings import LEADING, setting_name, setting_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_LINES, _MOST_BARS = 400, 15


def judged(campaign: Campaign) -> Section | None:
    """Values held against limits, the worst first; None without limits."""
    rows = [
        (line, name, value) for line in campaign.lines for name, value in line.values.items() if value.probability is not None
    ]  # fmt: skip
    missing = [line for line in campaign.lines if line.judgement == "not measured"]
    if not rows and not missing:
        return None
    rows.sort(key=lambda row: (WORST_FIRST.index(row[2].judgement), row[2].probability or 0.0, row[0].camera.name))
    lines = [_judged_row(*row) for row in rows[:_MOST_LINES]]
    lines += [(line.camera.name, _setting(line), "–", "–", t("not measured"), "–") for line in missing]
    return Section(
        title=t("Against the limits"),
        blocks=(
            Table(
                title=t(
                    "The worst first{rest}",
                    rest=t(", {shown} of {lines}", shown=_MOST_LINES, lines=len(rows))
                    if len(rows) > _MOST_LINES
                    else "",
                ),
                columns=heads("camera", "setting", "value ± U", "limits", "verdict", "probability"),
                align="llrrlr",
                rows=tuple(lines),
                note=t(
                    "Decision rule: {rule} Probability: that the measurand lies within the limits, from value and u.",
                    rule=t(campaign.rule),
                ),
            ),
        ),
    )


def _judged_row(line: CampaignLine, name: str, value: JudgedValue) -> tuple[str, ...]:
    what = f"{words(name)} = {value_text(value.value, value.expanded_uncertainty, unit=value.unit)}"
    ends = [
        "" if end is None else time_text(end) if value.unit == "s" else decimal(f"{end:g}")
        for end in (value.lower, value.upper)
    ]
    limits = (
        f"≤ {ends[1]}" if value.lower is None else f"≥ {ends[0]}" if value.upper is None else f"{ends[0]} … {ends[1]}"
    )
    percent = 100 * (value.probability or 0.0)
    number = "> 99.9" if percent > 99.9 else "< 0.1" if percent < 0.1 else f"{percent:.1f}"
    chance = with_unit(decimal(number), "%")
    return line.camera.name, _setting(line), what, limits, t(value.judgement), chance


def control(campaign: Campaign) -> Section | None:
    """Control charts; None for fewer than four results of a kind."""
    panels = tuple(
        panel(
            chart,
            limits=_limits(campaign, chart.parameter),
            aside=t(", so cameras that differ from each other widen it"),
        )
        for chart in _charts(campaign)
    )
    return Section(title=t("Control charts"), blocks=panels) if panels else None


def _charts(campaign: Campaign) -> Iterator[Chart]:
    return charts([one.point for one in campaign.points])


def _limits(campaign: Campaign, name: str) -> tuple[float | None, float | None]:
    """Where all cameras have the same."""
    found = {(line.values[name].lower, line.values[name].upper) for line in campaign.lines if name in line.values}
    return found.pop() if len(found) == 1 else (None, None)


def out_of_control(campaign: Campaign) -> list[str]:
    """Results outside of the limits of their control chart, in words."""
    return [
        t(
            "control chart of {parameter}: {results} beyond three standard deviations ({cameras}{rest})",
            parameter=words(chart.parameter),
            results=several(len(chart.beyond), "result"),
            cameras=", ".join(chart.labels[k] for k in chart.beyond[:5]),
            rest=", …" if len(chart.beyond) > 5 else "",
        )
        for chart in _charts(campaign)
        if chart.beyond
    ]


def codes(campaign: Campaign) -> Counter[str]:
    """Findings by how many results have them."""
    return Counter(code for one in campaign.points for code in dict.fromkeys(one.point.findings))


def pareto(campaign: Campaign) -> Section | None:
    """Findings by how many results have them, the most frequent first; None where there is none."""
    counts = codes(campaign)
    if campaign.broken:
        counts["not-analysed"] = len(campaign.broken)
    if not counts:
        return None
    most = counts.most_common()
    total = sum(counts.values())
    running = np.cumsum([n for _, n in most])
    rows = tuple((code, str(n), with_unit(f"{100 * n / total:.0f}", "%"), with_unit(f"{100 * at / total:.0f}", "%"))
                 for (code, n), at in zip(most, running, strict=True))  # fmt: skip
    drawn = sheet.svg(draw_frequencies(dict(most[:_MOST_BARS])), title=t("Findings by frequency"))
    table = Table(
        title=t("Findings"), columns=heads("code", "results", "share", "sum"), align="lrrr", rows=rows,
        note=t("Each code stands once per result; docs/reference/findings.md says what each means."),
    )  # fmt: skip
    panel = Panel(title=t("Findings by frequency"), caption=t("The most frequent first (Pareto)."), svg=drawn)
    return Section(title=t("Findings"), blocks=(panel, table))


def draw_frequencies(shown: Mapping[str, int]) -> "Figure":
    """Bars as long as there are results with each code, the first on top."""
    from matplotlib.ticker import MaxNLocator

    with sheet.style():
        drawn = sheet.figure(height_in=0.9 + 0.24 * len(shown))
        axes = drawn.add_subplot()
        axes.barh([*shown][::-1], [*shown.values()][::-1], color=sheet.BLUE, height=0.65)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlabel(t("results"))
    return drawn


def repeatability(campaign: Campaign) -> Section | None:
    """Gauge repeatability and reproducibility; None where nothing was repeated."""
    if not campaign.studies:
        return None
    rows = tuple(_study_row(one) for one in campaign.studies)
    first = campaign.studies[0]
    left = f" {with_capital(with_numbers(campaign.left_out_of_study))}." if campaign.left_out_of_study else ""
    design = t(
        "{cameras} by {operators}, {n} times each",
        cameras=several(first.n_cameras, "camera"),
        operators=several(first.n_operators, "operator"),
        n=first.n_repeats,
    )
    return Section(
        title=t("Repeatability and reproducibility"),
        blocks=(
            Table(
                title=design,
                columns=heads(
                    "parameter", "repeatability", "reproducibility", "both", "between cameras", "share", "stated u, own"
                ),
                align="lrrrrrr",
                rows=rows,
                note=t(
                    "Standard deviations by analysis of variance (AIAG MSA; the interaction is pooled where p > 0.25). Both: "
                    "of one measurement of one camera. Share: both over the whole spread. Stated u, own: what the results "
                    "say of their part that they do not have in common, rms; it should be about the repeatability.{left}",
                    left=left,
                ),
            ),
        ),
    )


def _study_row(one: GaugeStudy) -> tuple[str, ...]:
    across = "–" if one.n_operators == 1 else size(sqrt(one.reproducibility), one.unit)
    share = with_unit(f"{100 * sqrt(one.gauge / one.total):.0f}", "%") if one.total > 0 else "–"
    return (
        words(one.parameter), size(sqrt(one.repeatability), one.unit), across, size(sqrt(one.gauge), one.unit),
        size(sqrt(one.cameras), one.unit), share, size(one.rms_u_own, one.unit),
    )  # fmt: skip


def cameras(campaign: Campaign) -> Section:
    """Every line, up to some hundreds; all are in the table beside the page."""
    names = [name for name in LEADING if any(name in line.values for line in campaign.lines)]
    settings = [name for name in SETTINGS if _varies(campaign, name)]
    shown = campaign.lines[:_MOST_LINES]
    rows = tuple(
        (
            line.camera.name,
            *(setting_text(name, line.settings[name]) if name in line.settings else "–" for name in settings),
            *(_value(line, name) for name in names),
            str(line.n_results),
            t(line.judgement),
        )
        for line in shown
    )
    return Section(
        title=t("Cameras"),
        blocks=(
            Table(
                title=t("One line for each camera and setting")
                + (
                    t(", {shown} of {lines}", shown=len(shown), lines=len(campaign.lines))
                    if len(shown) < len(campaign.lines)
                    else ""
                ),
                columns=(
                    t("camera"),
                    *(setting_name(name) for name in settings),
                    *(f"{words(name)} ± u" for name in names),
                    t("results"),
                    t("verdict"),
                ),
                align="l" + "r" * (len(settings) + len(names) + 1) + "l",
                rows=rows,
                note=t(
                    "Several results of a camera at one setting are their weighted mean; errors of the rig that they have in "
                    "common do not become smaller by it, and u is widened where they scatter more than it says. All: "
                    "table.csv."
                ),
            ),
        ),
    )


def _value(line: CampaignLine, name: str) -> str:
    found = line.values.get(name)
    return "–" if found is None else value_text(found.value, found.standard_uncertainty, unit=found.unit)


def _varies(campaign: Campaign, name: SettingName) -> bool:
    return len({line.settings.get(name) for line in campaign.lines}) > 1


def _setting(line: CampaignLine) -> str:
    """Integration time and internal delay, as far as they are known."""
    texts = [setting_text(name, line.settings[name]) for name in ("integration_time", "internal_delay_set", "gain_setting")
            if name in line.settings]  # fmt: skip
    return ", ".join(texts) or "–"
