"""Rows of the tables of a certificate, as text."""

from typing import Any

from irtiming.archive.result_model import Result
from irtiming.records.choices import Language
from irtiming.report.budget import freedom_text
from irtiming.report.calibration.content import MeasuredItem, Sheet
from irtiming.report.calibration.measurands import BudgetLine, Measurand
from irtiming.report.calibration.numbers import plain, small, stated, with_unit
from irtiming.report.language import localised, translated
from irtiming.report.rounding import significant

VERDICTS = {
    "pass": "pass", "conditionalPass": "pass on condition", "conditionalFail": "fail on condition", "fail": "fail",
}  # fmt: skip


def name_of(one: Measurand, language: Language) -> str:
    """A measurand's name as people write it; of a relative delay with what was set."""
    name = translated(one.name.replace("_", " "), language)
    if one.nominal_s is None:
        return name
    runs = f", {one.runs} {translated('recordings', language)}" if one.runs > 1 else ""
    speed = "" if one.speed_hz is None else f", {plain(one.speed_hz, 'Hz', language=language)}"
    return f"{name}, {translated('set', language)} {plain(one.nominal_s, 's', language=language)}{speed}{runs}"


def measurand(one: Measurand, language: Language) -> dict[str, Any]:
    """One row of the results, and the lines of its budget."""
    value, expanded = stated(one.value, one.expanded, language=language)
    total = one.u**2 or 1.0
    return {
        "name": name_of(one, language),
        "event": event(one, language),
        "sign": "" if one.sign is None else translated(one.sign, language),
        "value": value,
        "expanded": expanded,
        "u": small(one.u, "s", language=language, digits=2),
        "k": localised(f"{one.coverage_factor:.2f}", language),
        "freedom": localised(freedom_text(one.degrees_of_freedom), language),
        "lines": [_line(line, language, total=total) for line in one.budget],
    }


def event(one: Measurand, language: Language) -> str:
    """What the time ends with."""
    return translated(one.event, language)


def _line(line: BudgetLine, language: Language, *, total: float) -> dict[str, str]:
    share = line.contribution**2 / total
    return {
        "source": translated(line.source, language),
        "estimate": small(line.estimate, line.unit, language=language, digits=5) if line.estimate else "0",
        "u": small(line.u, line.unit, language=language, digits=2),
        "distribution": f"{translated(line.distribution, language)} ({line.kind})",
        "sensitivity": _sensitivity(line, language),
        "contribution": small(line.contribution, "s", language=language, digits=2),
        "freedom": localised(freedom_text(line.degrees_of_freedom), language),
        "share": with_unit(localised(f"{100 * share:.0f}" if share >= 0.005 else "< 1", language), "%"),
    }


def _sensitivity(line: BudgetLine, language: Language) -> str:
    if line.unit == "s":
        return localised(significant(line.sensitivity, digits=3), language) if line.sensitivity else "0"
    unit = "s" if line.unit in ("1", "") else f"s/{line.unit}"
    return (
        small(line.sensitivity, unit, language=language)
        if unit != "s"
        else small(line.sensitivity, "s", language=language)
    )


def bounds(result: Result, language: Language) -> str:
    """What is known of parameters that are not determined."""
    texts = []
    for name, one in result.bounds.items():
        words = translated(name.replace("_", " "), language)
        ends = ["…" if end is None else small(end, one.unit, language=language) for end in (one.lower, one.upper)]
        texts.append(f"{words} [{'; '.join(ends)}]")
    return ", ".join(texts)


def correlation(one: MeasuredItem, language: Language) -> dict[str, Any] | None:
    """Coefficients between the times; None where there is only one."""
    absolute = [row.name for row in one.measurands if row.nominal_s is None]
    names, matrix = one.result.correlation.names, one.result.correlation.matrix
    kept = [k for k, name in enumerate(names) if name in absolute]
    if len(kept) < 2:
        return None
    words = [translated(names[k].replace("_", " "), language) for k in kept]
    return {
        "names": words,
        "rows": [
            {"name": word, "cells": [_coefficient(matrix[k][m], language) for m in kept]}
            for word, k in zip(words, kept, strict=True)
        ],
    }


def _coefficient(r: float | None, language: Language) -> str:
    return "–" if r is None else localised(f"{r:+.3f}", language)


def rig(result: Result, language: Language) -> list[dict[str, str]]:
    """Numbers and words of rig.toml."""
    return [
        {
            "name": one.name,
            "value": one.value if isinstance(one.value, str) else _as_stated(one.value, one.unit, language),
            "u": "–"
            if not one.standard_uncertainty
            else small(one.standard_uncertainty, one.unit, language=language, digits=2),
        }
        for one in result.rig.values
    ]


def _as_stated(value: float, unit: str, language: Language) -> str:
    """With the digits that people write."""
    if unit == "s":
        return plain(value, unit, language=language)
    return with_unit(localised(f"{value:.9g}", language), unit)


def files(one: MeasuredItem) -> list[dict[str, str]]:
    """Recordings with the frames that were used, and the result."""
    recordings = [
        {"name": each.file.rsplit("/", 1)[-1], "frames": f"{each.frames if each.frames_used is None else each.frames_used}",
         "sha256": each.sha256}
        for each in one.result.inputs
    ]  # fmt: skip
    return [*recordings, {"name": one.file.name, "frames": "–", "sha256": one.file.sha256}]


def conformity(sheet: Sheet) -> list[dict[str, str]]:
    """Every result that has limits, with what the rule says of it."""
    language = sheet.language
    return [
        {
            "name": name_of(row, language) + (f" ({one.file.name})" if len(sheet.results) > 1 else ""),
            "limits": _limits(row, language),
            "value": " ± ".join(stated(row.value, row.expanded, language=language)),
            "outcome": row.conformity.outcome,
            "verdict": translated(VERDICTS[row.conformity.outcome], language),
            "probability": _probability(row.conformity.probability, language),
        }
        for one in sheet.results
        for row in one.measurands
        if row.conformity is not None
    ]


def _probability(probability: float, language: Language) -> str:
    percent = 100 * probability
    text = "> 99.9" if percent > 99.9 else "< 0.1" if percent < 0.1 else f"{percent:.1f}"
    return with_unit(localised(text, language), "%")


def _limits(row: Measurand, language: Language) -> str:
    low, high = row.limits
    ends = ["" if end is None else plain(end, "s", language=language) for end in (low, high)]
    text = f"≤ {ends[1]}" if low is None else f"≥ {ends[0]}" if high is None else f"{ends[0]} … {ends[1]}"
    return f"{text} ({row.specification})" if row.specification else text
