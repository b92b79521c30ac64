"""The certificate of a rolling microbolometer camera: verdict, remarks, and the sections in the order of the argument."""

import numpy as np

from irtiming.records.two_constants import TwoConstantsResult
from irtiming.report import (
    budget,
    figures,
    likelihood_figures,
    prediction_tables,
    rolling_figures,
    rolling_inputs,
    rolling_tables,
    tables,
    two_constant_figures,
    two_constant_tables,
    wheel_tables,
)
from irtiming.report.evidence import RollingEvidence
from irtiming.report.page import Section, Verdict
from irtiming.report.rolling_result import last_row_read
from irtiming.report.rolling_tables import METHOD_NAMES, NAMES
from irtiming.report.rounding import time_text, uncertainty_text


def verdict(evidence: RollingEvidence) -> Verdict:
    """The three numbers, what they are, and what limits each."""
    found = {name: (value, u) for name, value, u in rolling_tables.entries(evidence.result)}
    bounds = {bound.name: rolling_tables.bound_text(bound) for bound in evidence.result.bounds}
    numbers = [
        f"{_words(name)} = {time_text(*found[name])}"
        if name in found
        else f"{_words(name)}: {bounds.get(name, 'unknown')}"
        for name in NAMES
    ]
    n = len(evidence.recordings)
    sentence = (
        f"{_sentence(found, bounds)}, by {METHOD_NAMES[evidence.result.method]} from {n} "
        f"recording{'s' if n > 1 else ''} (standard uncertainties, k = 1)."
    )
    remarks = [
        *(_limit(evidence, name, u) for name, (_, u) in found.items()),
        _readout(evidence),
        _relative_remark(evidence),
    ]
    return Verdict(
        number=numbers[0],
        further=tuple(numbers[1:]),
        sentence=sentence,
        remarks=tuple(text for text in remarks if text),
    )


def _words(name: str) -> str:
    return name.replace("_", " ")


def _sentence(found: dict[str, tuple[float, float]], bounds: dict[str, str]) -> str:
    """What the three numbers mean, where they are determined and where not."""
    if "trigger_delay" in found:
        value, u = found["trigger_delay"]
        side = "after" if value >= 0 else "before"
        first = f"Image row 0 is read {time_text(abs(value), u)} {side} the trigger edge that the camera accepts"
    else:
        first = f"The trigger delay is not determined ({bounds.get('trigger_delay', 'no bounds')}, k = 2)"
    if "row_delay" in found:
        value, u = found["row_delay"]
        order = "each row below it later" if value >= 0 else "each row below it earlier"
        second = f"{order} by {time_text(abs(value), u)}"
    else:
        second = f"the row delay is not determined ({bounds.get('row_delay', 'no bounds')}, k = 2)"
    if "time_constant" in found:
        third = f"a pixel needs {time_text(*found['time_constant'])} for 63 % of its response to a step of the scene"
    else:
        third = f"the time constant is not determined ({bounds.get('time_constant', 'no bounds')}, k = 2)"
    return f"{first}, {second}; {third}"


def _limit(evidence: RollingEvidence, name: str, u: float) -> str:
    largest = rolling_tables.largest_part(evidence, name)
    expanded, factor = budget.expanded_text(u, budget.of_rolling(evidence.result, name).degrees_of_freedom)
    start = f"{_words(name).capitalize()}: U = {expanded} (k = {factor})"
    if largest is None:
        return f"{start}; a single part of uncertainty is known."
    part, size = largest
    return f"{start}; the largest part of u is {part.source}, {uncertainty_text(size)} (type {part.kind})."


def _readout(evidence: RollingEvidence) -> str:
    """By when the last row is read, and which way the readout goes."""
    last = last_row_read(evidence, evidence.result)
    if last is None:
        return ""
    row, value, u = last
    first = dict(zip(evidence.result.estimate.names, evidence.result.estimate.values, strict=True))["trigger_delay"]
    span = f"the whole readout takes {time_text(abs(value - first), u)}".split(" ± ")[0]
    unit = time_text(abs(value - first)).split()[-1]
    if value >= first:
        return f"The last row (y = {row}) is read {time_text(value, u)} after the trigger edge; {span} {unit}."
    return (
        f"Rows are read from the bottom up: row {row} first, {time_text(value, u)} after the trigger edge, row 0 last; "
        f"{span} {unit}."
    )


def _relative_remark(evidence: RollingEvidence) -> str:
    delays = [delay for delay in evidence.result.relative_delays if delay.nominal_s > 0]
    if not delays:
        return "All recordings have the same delay set: no relative delay to check the measurement with."
    deviations = np.array([delay.value_s - delay.nominal_s for delay in delays])
    u = np.array([delay.standard_uncertainty_s for delay in delays])
    rms = float(np.sqrt(np.mean(deviations**2)))
    ratio = float(np.max(np.abs(deviations) / np.maximum(u, 1e-15)))
    return (
        f"Relative delays meet what was set within {uncertainty_text(rms)} rms over {len(delays)} "
        f"recording{'s' if len(delays) > 1 else ''}; the largest deviation is {ratio:.1f} of its standard uncertainty."
    )


def wide_range(found: TwoConstantsResult | None) -> tuple[Section, ...]:
    """Constants of substrate and scene, where somebody asked for them."""
    if found is None:
        return ()
    tables_of = (two_constant_tables.constants(found), two_constant_tables.effective(found))
    return (Section(title="Wide temperature range", blocks=(*tables_of, two_constant_figures.panel(found))),)


def sections(evidence: RollingEvidence) -> tuple[Section, ...]:
    """The body of the page, in the order of the argument."""
    delays = rolling_tables.relative_delays(evidence)
    events = rolling_tables.shutter_events(evidence)
    relative = Section(title="Relative delays", blocks=(delays, rolling_figures.relative(evidence)))
    return (
        Section(title="Result", blocks=(rolling_tables.parameters(evidence), rolling_tables.both_methods(evidence))),
        Section(title="Opening fractions and fit", blocks=(rolling_figures.figure_6(evidence),)),
        Section(
            title="Lag and delay",
            blocks=(rolling_figures.scan(evidence), rolling_figures.ellipse(evidence), rolling_tables.noise(evidence)),
        ),
        *wide_range(evidence.two_constants),
        Section(
            title="Row by row", blocks=(rolling_figures.row_delays(evidence), rolling_figures.residual_map(evidence))
        ),
        *((relative,) if delays.rows else ()),
        Section(
            title="Uncertainty",
            blocks=(
                rolling_figures.budget(evidence),
                rolling_tables.budget(evidence),
                *prediction_tables.compared_rolling(evidence),
                rolling_tables.correlation(evidence),
                rolling_figures.by_edge(evidence),
            ),
        ),
        Section(
            title="How well the fits went",
            blocks=(
                rolling_tables.fits(evidence),
                rolling_tables.searches(evidence),
                likelihood_figures.profiles(evidence.likelihood.profiles),
                likelihood_figures.whiteness(evidence.likelihood.whiteness),
            ),
        ),
        Section(
            title="What the camera saw",
            blocks=(
                rolling_figures.opening(evidence),
                rolling_inputs.sector(evidence),
                rolling_figures.drift(evidence),
                *((events,) if events.rows else ()),
            ),
        ),
        Section(title="Rig and model", blocks=(figures.wheel(evidence), figures.model(evidence))),
        Section(
            title="What the wheel did",
            blocks=(figures.speed(evidence), figures.slots(evidence), *wheel_tables.blocks(evidence.wheel)),
        ),
        Section(
            title="Choices, inputs, software",
            blocks=(rolling_inputs.choices(evidence), rolling_inputs.inputs(evidence), tables.software()),
        ),
    )
