"""What may stand behind structured residuals: causes that the fit does not have, and numbers that it has for defects."""

from irtiming.records.analysis import Analysis
from irtiming.records.diagnosis import Diagnosis
from irtiming.report.blocks import Section, Table, of_tables
from irtiming.report.language import decimal, heads, t, with_numbers
from irtiming.report.rounding import in_unit, significant

_SHORT = {"exposure_midpoint_delay": "midpoint", "trigger_delay": "trigger delay"}


def section(analysis: Analysis) -> Section | None:
    """Both tables; None where not asked for."""
    found = analysis.diagnosis
    if found is None:
        return None
    return Section(title=t("What the residuals point to"), blocks=of_tables(causes(found), fitted(found)))


def causes(found: Diagnosis) -> Table:
    """Every cause that was tried, in the order of what it explains."""
    parameters = list(dict.fromkeys(name for one in found.causes for name in one.moves))
    rows = tuple(
        (
            t(one.name),
            decimal(f"{one.gained:.1f}"),
            str(one.n_numbers),
            t("no") if one.chance > 0.05 else decimal(f"{one.chance:.0e}"),
            decimal(f"{1e3 * one.size:.3f}"),
            *(_signed(one.moves[name]) if name in one.moves else "–" for name in parameters),
        )
        for one in found.causes
    )
    return Table(
        title=t("Causes that the fit does not have"),
        columns=(
            t("cause"),
            t("deviance gained"),
            t("numbers"),
            t("more than chance?"),
            t("size / 10⁻³"),
            *(t("moves {name} / u", name=t(_SHORT.get(name, name.replace("_", " ")))) for name in parameters),
        ),
        align="lrrrr" + "r" * len(parameters),
        rows=rows,
        note=t(
            "Each is tried alone, beside all that was fitted (score test). Deviance of the residuals over the noise "
            "of neighbouring frames: {deviance:.0f} with {degrees_of_freedom} degrees of freedom. Each number gains "
            "about 1 by chance. More than chance: the probability that noise gains as much, times the number of "
            "causes. Size: rms of what it adds, in parts of the contrast. The last columns say how far each "
            "parameter would move, were it fitted.",
            deviance=found.deviance,
            degrees_of_freedom=found.degrees_of_freedom,
        ),
    )


def fitted(found: Diagnosis) -> Table:
    """Numbers of the fit that stand for defects, the farthest from none first."""
    rows = tuple(
        (
            _called(one.name),
            in_unit(one.value.value, one.value.standard_uncertainty, unit_s=1.0),
            significant(one.value.standard_uncertainty) if one.value.standard_uncertainty > 0 else "–",
            "" if one.unit == "1" else one.unit,
            decimal(f"{one.from_none:+.1f}"),
            decimal(f"{one.gained:.1f}"),
        )
        for one in found.fitted
    )
    return Table(
        title=t("Defects that the fit has numbers for"),
        columns=heads("number", "value", "u", "unit", "from none / u", "deviance gained"),
        align="lrrlrr",
        rows=rows,
        note=t(
            "Errors of the rig are counted in the standard uncertainties that rig.toml states, and so is their "
            "distance from none; a number of a recording is as far from none as its own uncertainty says. Deviance "
            "gained: by having it."
        )
        + (
            t(
                " A combination is one of several errors of the opening's numbers in the image that are independent of each "
                "other."
            )
            if any(", combination " in one.name for one in found.fitted)
            else ""
        ),
    )


def _signed(value: float) -> str:
    text = f"{value:+.2f}"
    return "0" if float(text) == 0 else decimal(text)


def _called(name: str) -> str:
    """A number with the recording that it is of."""
    recording, colon, own = name.rpartition(": ")
    return f"{recording}{colon}{with_numbers(own.replace('_', ' '))}"
