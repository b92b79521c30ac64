"""The page of a campaign: how many cameras pass, control charts, findings, repeatability and reproducibility, every line."""

from collections import Counter
from datetime import datetime
from math import sqrt
from typing import Any

from irtiming.records.campaign import WORST_FIRST, Campaign, GaugeStudy
from irtiming.report.language import several, t, with_capital
from irtiming.report.meanings import words
from irtiming.report.page import Content, Verdict, Warned, render
from irtiming.report.sections import campaign as sections
from irtiming.report.sections import control_chart


def page(campaign: Campaign, *, created: datetime | None = None) -> str:
    """One HTML page without any link to the outside.

    Parameters
    ----------
    campaign
        With at least one line.
    created
        Date to print; now, where none is given.
    """
    made = (
        sections.judged(campaign),
        sections.control(campaign),
        sections.pareto(campaign),
        sections.repeatability(campaign),
        sections.cameras(campaign),
    )
    return render(
        Content(
            heading=t("Timing of many cameras"),
            verdict=verdict(campaign),
            warnings=tuple(Warned(text=one) for one in doubts(campaign)),
            sections=tuple(section for section in made if section is not None),
        ),
        created=created,
    )


def verdict(campaign: Campaign) -> Verdict:
    """How many pass."""
    cameras = {one.camera for one in campaign.lines}
    counts = Counter(one.judgement for one in campaign.lines)
    lines = several(len(campaign.lines), "line")
    what = t(
        "{results} of {cameras}, {lines} of camera and setting.",
        results=several(len(campaign.points), "result"),
        cameras=several(len(cameras), "camera"),
        lines=lines,
    )
    number = t("{cameras} measured", cameras=several(len(cameras), 'camera')) if not campaign.rule else (
        t("{n} of {total} pass", n=counts["pass"], total=len(campaign.lines))
    )  # fmt: skip
    others = [f"{counts[word]} {t(word)}" for word in WORST_FIRST if counts[word] and word not in ("pass", "no limits")]
    remarks = (
        [t("Decision rule: {rule}", rule=t(campaign.rule))]
        if campaign.rule
        else [t("No limits were given: nothing was judged.")]
    )
    remarks += [t("Others: {others}.", others=", ".join(others))] if others else []
    remarks += [_gauge(one) for one in campaign.studies[:1]]
    if any(one.simulated for one in campaign.lines):
        remarks.append(t("SIMULATED: results of no real camera are among them."))
    return Verdict(number=number, sentence=what, remarks=tuple(remarks))


def _gauge(study: GaugeStudy) -> str:
    who = t("any operator") if study.n_operators > 1 else t("one operator")
    size = control_chart.size(sqrt(study.gauge), study.unit)
    return t(
        "{parameter}: one measurement by {who} repeats within {size} (standard deviation).",
        parameter=with_capital(words(study.parameter)),
        who=who,
        size=size,
    )


def doubts(campaign: Campaign) -> list[str]:
    """What could not be analysed, in short; limits of cameras that are not there; what is out of control; results' warnings."""
    broken = [f"{', '.join(one.files)}: {one.what.removeprefix(f'{one.files[0]}: ')}" for one in campaign.broken[:20]]
    if len(campaign.broken) > 20:
        broken.append(t("and {n} more, in campaign.json", n=len(campaign.broken) - 20))
    unknown = [
        t(
            "there are limits of the camera with serial number {serial}, and no result of it: correct limits.toml",
            serial=one,
        )
        for one in campaign.limits_of_none
    ]
    return [*broken, *unknown, *sections.out_of_control(campaign), *_of_results(campaign)]


def _of_results(campaign: Campaign) -> list[str]:
    """What analyses warn of, by how many results have it."""
    named = ", ".join(f"{code} ({n})" for code, n in sections.codes(campaign).most_common())
    if not named:
        return []
    return [
        t("results have warnings of their own, by code and how many: {codes}; each says more in its JSON", codes=named)
    ]


def study_as_json(one: GaugeStudy) -> dict[str, Any]:
    """Variances as standard deviations, in the unit of the parameter."""
    return {
        "parameter": one.parameter,
        "unit": one.unit,
        "cameras": one.n_cameras,
        "operators": one.n_operators,
        "repeats": one.n_repeats,
        "repeatability": sqrt(one.repeatability),
        "reproducibility": None if one.n_operators == 1 else sqrt(one.reproducibility),
        "between_operators": None if one.n_operators == 1 else sqrt(one.operators),
        "interaction": None if one.n_operators == 1 else sqrt(one.interaction),
        "interaction_chance": one.interaction_p_value,
        "gauge": sqrt(one.gauge),
        "between_cameras": sqrt(one.cameras),
        "total": sqrt(one.total),
        "rms_own_standard_uncertainty": one.rms_u_own,
    }
