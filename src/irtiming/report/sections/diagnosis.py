"""What may stand behind structured residuals: causes that the fit does not have, and numbers that it has for defects."""

from irtiming.records.analysis import Analysis
from irtiming.records.diagnosis import Diagnosis
from irtiming.report.blocks import Section, Table, of_tables
from irtiming.report.rounding import significant

_SHORT = {"exposure_midpoint_delay": "midpoint", "trigger_delay": "trigger delay"}


def section(analysis: Analysis) -> Section | None:
    """Both tables; None where nobody asked."""
    found = analysis.diagnosis
    if found is None:
        return None
    return Section(title="What the residuals point to", blocks=of_tables(causes(found), fitted(found)))


def causes(found: Diagnosis) -> Table:
    """Every cause that was tried, in the order of what it explains."""
    parameters = list(dict.fromkeys(name for one in found.causes for name in one.moves))
    rows = tuple(
        (
            one.name,
            f"{one.gained:.1f}",
            str(one.n_numbers),
            "no" if one.chance > 0.05 else f"{one.chance:.0e}",
            f"{1e3 * one.size:.3f}",
            *(_signed(one.moves[name]) if name in one.moves else "–" for name in parameters),
        )
        for one in found.causes
    )
    return Table(
        title="Causes that the fit does not have",
        columns=(
            "cause", "deviance gained", "numbers", "more than chance?", "size / 10⁻³",
            *(f"moves {_SHORT.get(name, name.replace('_', ' '))} / u" for name in parameters),
        ),
        align="lrrrr" + "r" * len(parameters),
        rows=rows,
        note="Each is tried alone, beside all that was fitted (score test). Deviance of the residuals over the noise of "
        f"neighbouring frames: {found.deviance:.0f} with {found.degrees_of_freedom} degrees of freedom. Each number gains about "
        "1 by chance. More than chance: the probability that noise gains as much, times the number of causes. Size: rms "
        "of what it adds, in parts of the contrast. The last columns say how far each parameter would move, were it fitted.",
    )  # fmt: skip


def fitted(found: Diagnosis) -> Table:
    """Numbers of the fit that stand for defects, the farthest from none first."""
    rows = tuple(
        (
            one.name.replace("_", " "),
            f"{one.value.value:.3g}",
            significant(one.value.standard_uncertainty) if one.value.standard_uncertainty > 0 else "–",
            "" if one.unit == "1" else one.unit,
            f"{one.from_none:+.1f}",
            f"{one.gained:.1f}",
        )
        for one in found.fitted
    )
    return Table(
        title="Defects that the fit has numbers for",
        columns=("number", "value", "u", "unit", "from none / u", "deviance gained"),
        align="lrrlrr",
        rows=rows,
        note="Errors of the rig are counted in the standard uncertainties that rig.toml states, and so is their distance from "
        "none; a number of a recording is as far from none as its own uncertainty says. Deviance gained: by having it.",
    )


def _signed(value: float) -> str:
    text = f"{value:+.2f}"
    return "0" if float(text) == 0 else text
