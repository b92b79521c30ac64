"""A camera's parameters over its settings: every point, slopes, internal delays, and a figure of each."""

from collections.abc import Iterator

import numpy as np

from irtiming.records.setting_point import SETTINGS, SettingName, SettingPoint
from irtiming.records.setting_series import CameraSeries, OverSetting
from irtiming.report import sheet
from irtiming.report.blocks import US, Panel, Section, Table
from irtiming.report.language import decimal, heads, several, t, with_capital, with_unit
from irtiming.report.meanings import words
from irtiming.report.rounding import in_unit, signed, significant, time_text, time_unit, value_text

DELAYS = ("trigger_delay", "strobe_delay", "timestamp_delay")
LEADING = (*DELAYS, "exposure_midpoint_delay", "time_constant", "row_delay")
_MEANT = {
    ("start", 0.0): "the start of integration stays",
    ("start", -0.5): "the middle of integration stays",
    ("start", -1.0): "the end of integration stays",
    ("middle", 0.5): "the start of integration stays",
    ("middle", 0.0): "the middle of integration stays",
    ("middle", -0.5): "the end of integration stays",
}
_DOUBTFUL = 0.01


def sections(series: tuple[CameraSeries, ...]) -> tuple[Section, ...]:
    """One for each camera."""
    return tuple(section(one, alone=len(series) == 1) for one in series)


def section(one: CameraSeries, *, alone: bool) -> Section:
    """All of one camera; ``alone`` where there is no other."""
    leading = [each for each in one.over if each.parameter in LEADING]
    delays = [internal_delays(each) for each in one.over if _is_internal(each)]
    return Section(
        title=t("Over the settings") if alone else t("Over the settings: {name}", name=one.camera.name),
        blocks=(slopes(one), *delays, *(panel(each) for each in leading), points(one)),
    )


def setting_name(name: SettingName) -> str:
    """A setting as people say it."""
    return t(SETTINGS[name][0])


def slopes(one: CameraSeries) -> Table:
    """Every parameter over every setting: slope, what it agrees with, whether a line will do, and a step."""
    rows = tuple(
        (
            t("{parameter} over {setting}", parameter=words(each.parameter), setting=setting_name(each.setting)),
            str(each.x.size),
            slope_text(each),
            meaning(each),
            "–" if each.line.degrees_of_freedom < 1 else f"{chi_text(each)}, p = {_chance(each.line.probability)}",
            step_text(each) or t("none"),
        )
        for each in one.over if each.parameter in LEADING
    )  # fmt: skip
    return Table(
        title=t("Slopes"),
        columns=heads("what", "results", "slope ± u", "agrees with", "is a straight line", "step"),
        align="lrrlll",
        rows=rows,
        note=t(
            "Generalised least squares: errors of rig and wheel, which all results have in common, are in their "
            "covariance and hardly in a slope. Where p, the probability of a χ² as large, is small, results lie "
            "further from the line than their u says, and u of the slope was widened by √(χ²/ν). A step is reported "
            "where one as clear would arise by chance in fewer than 1 of 100 series. Agrees: within 2 u."
        ),
    )


def chi_text(one: OverSetting) -> str:
    """How far results lie from their line."""
    return f"χ² = {significant(one.line.chi_squared)}, ν = {one.line.degrees_of_freedom}"


def slope_text(one: OverSetting) -> str:
    """Slope with its standard uncertainty and unit."""
    value, u = one.slope
    axis = SETTINGS[one.setting][1]
    if one.is_time_over_time:
        return f"{in_unit(value, u, unit_s=1.0)} ± {significant(u)}"
    if one.unit == "s":
        return f"{time_text(value, u)}" + ("" if axis == "1" else t(" per {axis}", axis=axis))
    return t("{value} ± {u} per {axis}", value=in_unit(value, u, unit_s=1.0), u=significant(u), axis=axis)


def meaning(one: OverSetting) -> str:
    """Which simple slopes it agrees with, and what they say."""
    if not one.is_time_over_time:
        value, u = one.slope
        return t("no change") if abs(value) <= 2 * u else t("a change")
    if not one.simple_slopes:
        return t("none of 0, ±1/2, ±1")
    kind = "start" if one.parameter in DELAYS else "middle" if one.parameter == "exposure_midpoint_delay" else ""
    texts = []
    for slope in one.simple_slopes:
        text = {-1.0: "−1", -0.5: "−1/2", 0.0: "0", 0.5: "1/2", 1.0: "1"}[slope]
        meant = t(_MEANT.get((kind, slope), "")) if one.setting == "integration_time" else ""
        texts.append(f"{text}: {meant}" if meant else text)
    return "; ".join(texts)


def step_text(one: OverSetting) -> str:
    """The step of a line, empty where there is none."""
    if one.step is None:
        return ""
    low, high = (setting_text(one.setting, at) for at in (one.step.after, one.step.before))
    size = value_text(one.step.size, one.step.standard_uncertainty, unit=one.unit)
    return t("{size} between {low} and {high}", size=size, low=low, high=high)


def internal_delays(one: OverSetting) -> Table:
    """What the camera's own delay is beyond the smallest that was set, beside what was set."""
    found, u = one.differences
    rows = []
    for k in range(one.x.size):
        nominal = float(one.x[k] - one.x[0])
        deviation = float(found[k]) - nominal
        rows.append(
            (
                setting_text(one.setting, float(one.x[k])),
                value_text(float(one.values[k]), float(np.sqrt(one.covariance[k, k])), unit=one.unit),
                "–" if k == 0 else time_text(float(found[k]), float(u[k])),
                "–" if k == 0 else signed(deviation, float(u[k]), unit_s=US),
                "–" if k == 0 else significant(float(u[k]) / US),
            )
        )
    return Table(
        title=t("The camera’s internal delay: {parameter} by what was set", parameter=words(one.parameter)),
        columns=heads("set in the camera", "measured ± u", "beyond the first ± u", "deviation (µs)", "u (µs)"),
        align="rrrrr",
        rows=tuple(rows),
        note=t(
            "Deviation: beyond the first as measured, less as set; errors of the rig, which all results have in "
            "common, cancel in it (Schatz 2023, 3.1.4)."
        ),
    )


def points(one: CameraSeries) -> Table:
    """Every result: settings and leading parameters."""
    settings = [name for name in SETTINGS if any(name in each.settings for each in one.points)]
    names = [name for name in LEADING if any(name in each.parameters for each in one.points)]
    rows = tuple(
        (_called(each), *(_setting(each, name) for name in settings), *(_value(each, name) for name in names))
        for each in one.points
    )  # fmt: skip
    return Table(
        title=t("{results} of {camera}", results=several(len(one.points), "result"), camera=one.camera.name),
        columns=(t("result"), *(setting_name(name) for name in settings), *(f"{words(name)} ± u" for name in names)),
        align="l" + "r" * (len(settings) + len(names)),
        rows=rows,
        note=_joined(one),
    )


def _files(point: SettingPoint) -> list[str]:
    """Names of the recordings or the result that a point comes from, without their folders."""
    return [file.rsplit("/", 1)[-1] for file in point.label.split(", ")]


def _called(point: SettingPoint) -> str:
    first, *others = _files(point)
    return t("{first} and {n} more", first=first, n=len(others)) if others else first


def _joined(one: CameraSeries) -> str:
    """Which recordings make one result; empty where each makes its own."""
    groups = [" + ".join(files) for point in one.points if len(files := _files(point)) > 1]
    if not groups:
        return ""
    return t(
        "Recordings of one camera at one setting are analysed together, whatever the speed of the wheel; frame periods within "
        "0.5 % are one setting, as plans for several speeds have them. Together: {groups}.",
        groups="; ".join(groups),
    )


def panel(one: OverSetting) -> Panel:
    """Values with their line above, residuals with what each has of its own below."""
    factor, unit = (
        time_unit(float(np.max(np.abs(one.x)))) if SETTINGS[one.setting][1] == "s" else (1.0, SETTINGS[one.setting][1])
    )
    scale, y_unit = time_unit(float(np.max(np.abs(one.values)))) if one.unit == "s" else (1.0, one.unit)
    what, over = words(one.parameter), setting_name(one.setting)
    title = t("{parameter} over {setting}", parameter=with_capital(what), setting=over)
    whole, own = np.sqrt(np.diag(one.covariance)), _own(one)
    with sheet.style():
        figure = sheet.figure(height_in=3.6)
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
        dense = np.linspace(one.x.min(), one.x.max(), 50)
        level, slope = one.line.coefficients
        above.plot(dense / factor, (level + slope * dense) / scale, color=sheet.FAINT, linewidth=1)
        above.errorbar(
            one.x / factor, one.values / scale, whole / scale, fmt="o", color=sheet.BLUE, markersize=4, capsize=2
        )
        above.set_ylabel(f"{what} ({y_unit})")
        sheet.zero_line(below)
        small, small_unit = (
            time_unit(float(np.max(np.abs(one.line.residuals) + own))) if one.unit == "s" else (1.0, one.unit)
        )
        below.errorbar(
            one.x / factor, one.line.residuals / small, own / small, fmt="o", color=sheet.RED, markersize=4, capsize=2
        )
        below.set_ylabel(t("residual ({unit})", unit=small_unit))
        below.set_xlabel(f"{over} ({unit})" if unit not in ("", "1") else over)
        drawn = sheet.svg(figure, title=f"{title}, {one.points[0].camera.name}")
    return Panel(
        title=title,
        caption=t(
            "Above: results with their whole standard uncertainty, and the line. Slope {slope}. Below: what is left, "
            "with the part of u that each result has of its own.",
            slope=slope_text(one),
        ),
        svg=drawn,
    )


def _own(one: OverSetting) -> np.ndarray:
    """Standard uncertainty of each value without what it has in common with all others, shape (n,)."""
    others = one.covariance - np.diag(np.diag(one.covariance))
    shared = others.sum(axis=1) / max(1, one.x.size - 1)
    return np.asarray(np.sqrt(np.maximum(np.diag(one.covariance) - shared, 0.0)))


def doubts(series: tuple[CameraSeries, ...]) -> Iterator[str]:
    """What is not as it should be."""
    for one in series:
        for each in (other for other in one.over if other.parameter in LEADING):
            what = t(
                "{camera}: {parameter} over {setting}",
                camera=one.camera.name,
                parameter=words(each.parameter),
                setting=setting_name(each.setting),
            )
            if each.step is not None:
                yield t("{what} has a step of {step}", what=what, step=step_text(each))
            elif each.line.probability < _DOUBTFUL:
                yield t("{what} is no straight line: {chi}", what=what, chi=chi_text(each))


def setting_text(name: SettingName, value: float | str) -> str:
    """A setting with its unit."""
    unit = SETTINGS[name][1]
    if isinstance(value, str):
        return value
    if unit == "s":
        return time_text(float(f"{value:.6g}"))
    number = decimal(f"{value:.6g}")
    return number if unit in ("", "1") else with_unit(number, unit)


def _setting(point: SettingPoint, name: SettingName) -> str:
    return setting_text(name, point.settings[name]) if name in point.settings else "–"


def _value(point: SettingPoint, name: str) -> str:
    found = point.parameters.get(name)
    return "–" if found is None else value_text(found.value, found.standard_uncertainty, unit=found.unit)


def _is_internal(one: OverSetting) -> bool:
    return one.setting == "internal_delay_set" and one.parameter in DELAYS


def _chance(p: float) -> str:
    return "< 0.001" if p < 0.001 else decimal(f"{p:.2g}")
