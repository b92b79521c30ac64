"""History of a camera: its drift since the last calibration, and every result."""

from collections.abc import Sequence

from irtiming.records.drift import Drift
from irtiming.records.setting_point import SETTINGS, SettingPoint
from irtiming.report.blocks import Table
from irtiming.report.language import heads, several, t
from irtiming.report.meanings import words
from irtiming.report.rounding import value_text
from irtiming.report.sections.over_settings import LEADING, setting_text


def drift(drifts: Sequence[Drift]) -> Table:
    """What has moved; leading parameters alone."""
    newest = [one.newest[0] for one in drifts]
    rows = tuple(
        (
            words(one.parameter),
            _settings(one.newest[0], among=newest),
            f"{one.earlier[0].start_time[:10]} … {one.newest[0].start_time[:10]}",
            value_text(one.value, one.standard_uncertainty, unit=one.unit),
            value_text(one.change, one.u_change, unit=one.unit),
            t("moved") if one.has_moved else t("within U"),
            "–" if one.rate_per_year is None or one.u_rate_per_year is None
            else value_text(one.rate_per_year, one.u_rate_per_year, unit=one.unit),
        )
        for one in drifts if one.parameter in LEADING
    )  # fmt: skip
    return Table(
        title=t("Drift since the last calibration"),
        columns=heads("parameter", "setting", "from … to", "now ± u", "change ± u", "verdict", "per year ± u"),
        align="lllrrlr",
        rows=rows,
        note=t(
            "Means of a day’s results. Errors of the rig that both days have in common are in u of the value and "
            "cancel in u of the change. Moved: by more than U = 2 u of the change."
        ),
    )


def results(points: Sequence[SettingPoint]) -> Table:
    """Every result, the oldest first."""
    names = [name for name in LEADING if any(name in one.parameters for one in points)]
    rows = tuple(
        (
            one.start_time[:19].replace("T", " ") or "–",
            _settings(one, among=points),
            *(value_text(one.parameters[name].value, one.parameters[name].standard_uncertainty, unit=one.parameters[name].unit)
              if name in one.parameters else "–" for name in names),
            one.label.rsplit("/", 1)[-1],
        )
        for one in points
    )  # fmt: skip
    return Table(
        title=t("{results} of {camera}", results=several(len(points), "result"), camera=points[0].camera.name),
        columns=(t("measured"), t("setting"), *(f"{words(name)} ± u" for name in names), t("result")),
        align="ll" + "r" * len(names) + "l",
        rows=rows,
    )


def _settings(one: SettingPoint, *, among: Sequence[SettingPoint]) -> str:
    """In words; how the camera was read out stands with them where others were read out otherwise."""
    texts = [setting_text(name, one.settings[name]) for name in SETTINGS if name in one.settings and name != "rows"]
    if len({each.camera.readout_mode for each in among}) > 1:
        texts.insert(0, t(one.camera.readout_mode))
    return ", ".join(texts) or "–"
