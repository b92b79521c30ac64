"""Constants of substrate and scene over a wide range of temperatures, as tables and as a figure."""

from math import inf
from typing import TYPE_CHECKING

import numpy as np

from irtiming.records.two_constants import NAMES, TwoConstantsResult
from irtiming.report import budget, sheet
from irtiming.report.blocks import MS, US, Panel, Section, Table
from irtiming.report.language import decimal, heads, t
from irtiming.report.meanings import bound_text, label
from irtiming.report.rounding import fixed, signed, time_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WHAT = {
    "substrate_time_constant": "exchange of heat with the detector’s substrate alone, by conduction",
    "scene_time_constant": "exchange of heat with the scene alone, by radiation, for a pixel at {kelvin:g} K",
}
_TWO_U = 4.0
_HIGHEST = 12.0  # of the deviation shown
_WHEEL_FROM = {"you": "by you", "contrast": "where the contrast vanishes", "assumption": "assumed"}


def section(found: TwoConstantsResult | None) -> Section | None:
    """Tables and figure; None where they were not asked for."""
    if found is None:
        return None
    return Section(title=t("Wide temperature range"), blocks=(constants(found), effective(found), panel(found)))


def what(name: str, found: TwoConstantsResult) -> str:
    """What a constant is."""
    return t(_WHAT[name], kelvin=found.reference_temperature_k)


def constants(found: TwoConstantsResult) -> Table:
    """Both constants, or what is known of them, and what they rest on."""
    change = found.change_per_k_s
    names = found.estimate.names
    rows = []
    for k, name in enumerate(NAMES):
        words = what(name, found)
        if name in names:
            value, u = float(found.estimate.values[k]), float(found.estimate.standard_uncertainties[k])
            moved = [decimal(f"{1e6 * one:+.1f}") for one in change[k]]
            rows.append((label(name), time_text(value, u), budget.expanded_text(u, inf)[0], *moved, words))
        else:
            rows.append(
                (label(name), bound_text(next(b for b in found.bounds if b.name == name)), "–", "–", "–", words)
            )
    around = found.surroundings
    return Table(
        title=t("Separate time constants"),
        columns=(
            t("parameter"),
            t("value ± u"),
            decimal(f"U\u00a0(k\u00a0=\u00a0{budget.coverage_factor(inf):.2f})"),
            t("per K of substrate (µs)"),
            t("per K of wheel (µs)"),
            t("what it is"),
        ),
        align="lrrrrl",
        rows=tuple(rows),
        note=t(
            "Substrate at {substrate:.2f} K, by you; solid wheel like {wheel:.2f} K, "
            "{chosen}. u holds the uncertainty of the effective constants alone, not that of these temperatures: "
            "what a kelvin of either would change stands in the report.",
            substrate=around.substrate_temperature_k,
            wheel=around.wheel_temperature_k,
            chosen=t(_WHEEL_FROM[around.wheel_temperature_from]),
        )
        + (
            t(" Correlation of the two: {correlation}.", correlation=fixed(float(found.estimate.correlation[0, 1]), 3))
            if names
            else ""
        ),
    )


def effective(found: TwoConstantsResult) -> Table:
    """The constant that was fitted at each blackbody temperature beside the model."""
    u = np.sqrt(np.diag(found.effective.covariance_s2))
    rows = tuple(
        (decimal(f"{kelvin:.2f}"), decimal(f"{pixel:.2f}"), time_text(float(tau), float(one)), time_text(float(model)),
         signed(float(tau - model), float(one), unit_s=US), decimal(f"{1e6 * bend:.2f}"))
        for kelvin, pixel, tau, one, model, bend in zip(
            found.effective.blackbody_temperature_k, found.pixel_temperature_k, found.effective.time_constant_s, u,
            found.model_time_constant_s, found.bend_s, strict=True,
        )
    )  # fmt: skip
    return Table(
        title=t("Effective time constants"),
        columns=heads(
            "blackbody (K)",
            "pixel, middle (K)",
            "fitted ± u",
            "two constants",
            "difference (µs)",
            "for bending (µs)",
        ),
        align="rrrrrr",
        rows=rows,
        note=t(
            "A pixel lies between scene and substrate; warmer, it radiates more per kelvin and is faster. For "
            "bending: what the model adds because the answer to a large step is no exponential."
        ),
    )


def panel(found: TwoConstantsResult) -> Panel:
    """The figure with its caption."""
    end = (
        t("The curve is the two-constant model.")
        if found.estimate.names
        else t("The two constants are not determined apart: the curve is one of many that would do.")
    )
    return Panel(
        title=t("Time constant over the blackbody’s temperature"),
        caption=t(
            "Left: effective constants as fitted, with standard uncertainties (part of which they share), and below "
            "what the model leaves over. {end} Right: how much worse other shares of the scene fit; below the dashed "
            "line lie those within two standard uncertainties.",
            end=end,
        ),
        svg=sheet.svg(figure(found), title=t("Time constant over the temperature of the blackbody")),
    )


def figure(found: TwoConstantsResult) -> "Figure":
    """Effective constants with model and residuals; deviation over the scene's share."""
    with sheet.style():
        drawn = sheet.figure(height_in=3.7)
        grid = drawn.add_gridspec(2, 2, height_ratios=[2.6, 1], width_ratios=[1.5, 1])
        _effective(drawn.add_subplot(grid[0, 0]), drawn.add_subplot(grid[1, 0]), found)
        _share(drawn.add_subplot(grid[:, 1]), found)
    return drawn


def _effective(top: "Axes", below: "Axes", found: TwoConstantsResult) -> None:
    data = found.effective
    u = np.sqrt(np.diag(data.covariance_s2))
    kelvin, tau = data.blackbody_temperature_k, data.time_constant_s
    top.plot(
        found.curve_blackbody_k,
        found.curve_time_constant_s / MS,
        color=sheet.INK,
        linewidth=0.9,
        label=t("two-constant model"),
    )
    top.errorbar(
        kelvin, tau / MS, yerr=u / MS, fmt="o", color=sheet.BLUE, markersize=4.5, capsize=3, label=t("fitted ± u")
    )
    top.set_ylabel(t("effective time constant (ms)"))
    top.tick_params(labelbottom=False)
    top.legend(loc="upper right")
    sheet.zero_line(below)
    left = (tau - found.model_time_constant_s) / US
    below.errorbar(kelvin, left, yerr=u / US, fmt="o", color=sheet.BLUE, markersize=4, capsize=3)
    sheet.robust_limits(below, [np.abs(left) + u / US])
    below.set_xlim(top.get_xlim())
    below.set_xlabel(t("blackbody (K)"))
    below.set_ylabel(t("fitted −\nmodel (µs)"), fontsize=8)


def _share(axes: "Axes", found: TwoConstantsResult) -> None:
    axes.plot(found.share_scan, found.deviation, color=sheet.INK, linewidth=1)
    axes.axhline(_TWO_U, color=sheet.FAINT, linestyle="--", linewidth=0.9)
    axes.axvline(found.scene_share, color=sheet.RED, linewidth=1)
    axes.set_xlim(0, 1)
    axes.set_ylim(0, _HIGHEST)
    axes.set_xlabel(t("share of the scene in the exchange of heat (1)"))
    axes.set_ylabel(t("2 · log-likelihood lost (1)"))
