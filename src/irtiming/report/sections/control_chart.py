"""Control charts: values in order of time, about their mean and within the limits of their moving range."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.records.arrays import Array
from irtiming.records.setting_point import SettingPoint, groups, in_time
from irtiming.report import sheet
from irtiming.report.blocks import Panel
from irtiming.report.language import several, t, with_capital
from irtiming.report.meanings import words
from irtiming.report.rounding import significant, time_unit, uncertainty_text
from irtiming.report.sections.over_settings import LEADING

FEWEST_POINTS = 4
"""Below, there is nothing to chart."""

_OF_MOVING_RANGE = 1.128  # d2 of two values: mean moving range over standard deviation
_SIGMAS = 3.0


def size(value: float, unit: str) -> str:
    """A standard deviation with its unit."""
    return uncertainty_text(value) if unit == "s" else significant(value)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Chart:
    """Values in order of time with the centre and the limits of their moving range; shapes (n,)."""

    parameter: str
    unit: str
    labels: tuple[str, ...]
    values: Array
    u: Array
    centre: float
    sigma: float

    @property
    def beyond(self) -> tuple[int, ...]:
        """Those outside of three standard deviations."""
        return tuple(np.flatnonzero(np.abs(self.values - self.centre) > _SIGMAS * self.sigma).tolist())


def charts(results: Sequence[SettingPoint]) -> Iterator[Chart]:
    """Of each leading parameter of the kind of camera and the setting with most results; none for fewer than four of a kind.

    Parameters
    ----------
    results
        At least one.

    Notes
    -----
    Individuals and moving range (ISO 7870-2, 6.3): sigma is the mean of |x_i - x_(i-1)| over 1.128.
    """
    largest = max(groups(results, of_kind=True), key=len)
    points = sorted(largest, key=lambda one: (in_time(one.start_time), one.label))
    for name in LEADING:
        measured = [one for one in points if name in one.parameters]
        if len(measured) < FEWEST_POINTS:
            continue
        found = [one.parameters[name] for one in measured]
        values = np.array([one.value for one in found])
        yield Chart(
            parameter=name, unit=found[0].unit, labels=tuple(one.camera.serial_number for one in measured), values=values,
            u=np.array([one.standard_uncertainty for one in found]), centre=float(values.mean()),
            sigma=float(np.mean(np.abs(np.diff(values)))) / _OF_MOVING_RANGE,
        )  # fmt: skip


def panel(chart: Chart, *, limits: tuple[float | None, float | None] = (None, None), aside: str = "") -> Panel:
    """Figure and caption.

    Parameters
    ----------
    chart
        What to draw.
    limits
        Lower and upper, in the unit of the values, where there are any.
    aside
        What else to say of the moving range, in the middle of a sentence.
    """
    scale, unit = time_unit(float(np.max(np.abs(chart.values)))) if chart.unit == "s" else (1.0, chart.unit)
    place = np.arange(1, chart.values.size + 1)
    with sheet.style():
        figure = sheet.figure(height_in=2.7)
        axes = figure.subplots()
        for at, style in ((0.0, "-"), (-_SIGMAS, "--"), (_SIGMAS, "--")):
            axes.axhline((chart.centre + at * chart.sigma) / scale, color=sheet.FAINT, linewidth=0.9, linestyle=style)
        for limit in limits:
            if limit is not None:
                axes.axhline(limit / scale, color=sheet.RED, linewidth=1.1)
        axes.errorbar(place, chart.values / scale, chart.u / scale, fmt="none", ecolor=sheet.FAINT, elinewidth=0.8)
        axes.plot(place, chart.values / scale, "-o", color=sheet.BLUE, markersize=3, linewidth=0.7)
        beyond = list(chart.beyond)
        axes.plot(place[beyond], chart.values[beyond] / scale, "o", color=sheet.RED, markersize=5)
        axes.set_xlabel(t("result, in order of time"))
        axes.set_ylabel(f"{words(chart.parameter)} ({unit})")
        drawn = sheet.svg(figure, title=t("Control chart of {parameter}", parameter=words(chart.parameter)))
    red = t(" Red lines: limits.") if any(one is not None for one in limits) else ""
    return Panel(
        title=t(
            "{parameter} of {results}",
            parameter=with_capital(words(chart.parameter)),
            results=several(chart.values.size, "result"),
        ),
        caption=t(
            "Individuals in order of time, with u. Grey: mean and ± 3 standard deviations by the mean moving range "
            "({sigma}){aside}. Red points lie outside.{red}",
            sigma=size(chart.sigma, chart.unit),
            aside=aside,
            red=red,
        ),
        svg=drawn,
    )
