"""The certificate of a snapshot photon camera: verdict, remarks, and the sections in the order of the argument."""

from dataclasses import replace

import numpy as np

from irtiming.report import budget, figures, joint_tables, likelihood_figures, prediction_tables, tables, wheel_tables
from irtiming.report.combination import combined
from irtiming.report.evidence import Evidence
from irtiming.report.page import Section, Verdict
from irtiming.report.rounding import time_text, uncertainty_text
from irtiming.report.tables import METHOD_NAMES, REFERENCE_EVENTS


def verdict(evidence: Evidence) -> Verdict:
    """What was measured, in one sentence, and what limits it."""
    estimate = evidence.result.estimate
    name = "trigger_delay" if "trigger_delay" in estimate.names else "exposure_midpoint_delay"
    k = estimate.names.index(name)
    value, u = float(estimate.values[k]), float(estimate.standard_uncertainties[k])
    n = len(evidence.recordings)
    side = "after" if value >= 0 else "before"
    expanded, factor = budget.expanded_text(u, budget.degrees_of_freedom(evidence.result, name))
    sentence = (
        f"The {REFERENCE_EVENTS[name]} comes {time_text(abs(value), u)} {side} the trigger edge that the camera accepts "
        f"(standard uncertainty, k = 1; expanded uncertainty U = {expanded}, "
        f"k = {factor}), by {METHOD_NAMES[evidence.result.method]} from {n} recording{'s' if n > 1 else ''}."
    )
    remarks = [_relative_remark(evidence), _budget_remark(evidence), _split_remark(evidence)]
    return Verdict(
        number=f"{name.replace('_', ' ')} = {time_text(value, u)}",
        sentence=sentence,
        remarks=tuple(remark for remark in remarks if remark),
    )


def _relative_remark(evidence: Evidence) -> str:
    rows = combined(evidence, evidence.result)
    if not rows:
        return "All recordings have the same delay set: no relative delay to check the measurement with."
    rms = float(np.sqrt(np.mean([row.deviation_s**2 for row in rows])))
    worst = max(rows, key=lambda row: abs(row.deviation_s))
    ratio = abs(worst.deviation_s) / worst.standard_uncertainty_s if worst.standard_uncertainty_s > 0 else float("inf")
    return (
        f"Relative delays meet what was set within {uncertainty_text(rms)} rms over {len(rows)} nominal "
        f"delay{'s' if len(rows) > 1 else ''}; the largest deviation is {ratio:.1f} of its standard uncertainty."
    )


def _budget_remark(evidence: Evidence) -> str:
    parts = evidence.result.budget
    if len(parts) < 2:
        return ""
    largest = max(parts, key=lambda part: part.standard_uncertainty_s)
    return (
        f"The largest part of the uncertainty is: {largest.source}, "
        f"{uncertainty_text(largest.standard_uncertainty_s)} (type {largest.kind})."
    )


def _split_remark(evidence: Evidence) -> str:
    split = budget.falling_minus_rising(evidence.result)
    if split is None:
        return ""
    value, u = split.value_s, split.standard_uncertainty_s
    agrees = abs(value) <= budget.coverage_factor(split.degrees_of_freedom) * u
    return (
        f"Delays from falling and from rising slopes {'agree' if agrees else 'differ'}: falling − rising = "
        f"{time_text(value, u)}."
    )


def sections(evidence: Evidence) -> tuple[Section, ...]:
    """The body of the page, in the order of the argument."""
    return (
        Section(title="Result", blocks=(tables.parameters(evidence), tables.both_methods(evidence))),
        Section(
            title="Relative delays",
            blocks=(
                tables.relative_delays(evidence, evidence.best),
                *(
                    (replace(tables.relative_delays(evidence, evidence.as_published), note=""),)
                    if evidence.published_fits
                    else ()
                ),
                figures.relative(evidence),
                tables.relative_delays_by_file(evidence),
            ),
        ),
        Section(
            title="Exposed fraction and fit",
            blocks=(
                figures.fitted(evidence),
                *((figures.averaged(evidence),) if evidence.published_fits else ()),
                figures.by_edge(evidence),
            ),
        ),
        Section(
            title="Joint fit",
            blocks=(
                *joint_tables.blocks(evidence),
                likelihood_figures.whiteness(evidence.joint.whiteness),
                likelihood_figures.profiles(evidence.joint.profiles),
            ),
        ),
        Section(
            title="Uncertainty",
            blocks=(figures.budget(evidence), tables.budget(evidence), *prediction_tables.compared(evidence)),
        ),
        Section(title="Rig and model", blocks=(figures.wheel(evidence), figures.model(evidence))),
        Section(title="What the camera saw", blocks=(figures.mean_frames(evidence), figures.histogram(evidence))),
        Section(
            title="What the wheel did",
            blocks=(figures.speed(evidence), figures.slots(evidence), *wheel_tables.blocks(evidence.wheel)),
        ),
        Section(
            title="Choices, inputs, software",
            blocks=(tables.choices(evidence), tables.inputs(evidence), tables.software()),
        ),
    )
