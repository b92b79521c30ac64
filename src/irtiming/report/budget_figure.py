"""A parameter's uncertainty budget as bars, for notebooks."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, TypeAlias

from irtiming.report import sheet
from irtiming.report.language import t
from irtiming.report.quantity import Quantity
from irtiming.report.rounding import time_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST = 12

Drawn: TypeAlias = "Axes"
"""Axes of matplotlib, for those who may not load it."""


def draw(name: str, quantity: Quantity, *, parts: Mapping[str, float], axes: "Axes | None" = None) -> "Axes":
    """Bars of what each source adds, the largest on top, in axes of its own if none are given.

    Parameters
    ----------
    name, quantity
        Of the parameter.
    parts
        Standard uncertainty by source, in the unit of the quantity; at most the twelve largest are shown.
    axes
        Where to draw.
    """
    with sheet.style():
        if axes is None:
            axes = sheet.figure(height_in=3.2, width_in=7.2).add_subplot()
        factor, unit = time_unit(quantity.u) if quantity.unit == "s" else (1.0, quantity.unit)
        shown = sorted((part for part in parts.items() if part[1] > 0), key=lambda part: part[1])[-_MOST:]
        axes.barh([source for source, _ in shown], [u / factor for _, u in shown], color=sheet.BLUE)
        axes.axvline(quantity.u / factor, color=sheet.RED, linewidth=1.2, label=t("all together"))
        axes.set_xlabel(t("standard uncertainty ({unit})", unit=unit))
        axes.set_title(f"{name.replace('_', ' ')}: {quantity}")
        axes.grid(visible=False, axis="y")
        axes.legend(loc="lower right")
    return axes
