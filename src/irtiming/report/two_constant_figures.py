"""Effective time constants over the blackbody's temperature with the two-constant model, and how sharply it is told."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from irtiming.records.two_constants import TwoConstantsResult
from irtiming.report import sheet
from irtiming.report.figures import Panel

MS, US = 1e-3, 1e-6
_TWO_U = 4.0
_HIGHEST = 12.0  # of the deviation shown


def panel(found: TwoConstantsResult) -> Panel:
    """The figure with its caption."""
    end = (
        "The curve is the two-constant model."
        if found.estimate.names
        else "The two constants are not told apart: the curve is one of many that would do."
    )
    return Panel(
        title="Time constant over the blackbody’s temperature",
        caption="Left: effective constants as fitted, with standard uncertainties (part of which they share), and below what the "
        f"model leaves over. {end} Right: how much worse other shares of the scene fit; below the dashed line lie those "
        "within two standard uncertainties.",
        svg=sheet.svg(figure(found), title="Time constant over the temperature of the blackbody"),
    )


def figure(found: TwoConstantsResult) -> Figure:
    """Effective constants with model and residuals; deviation over the scene's share."""
    with sheet.style():
        drawn = sheet.figure(height_in=3.7)
        grid = drawn.add_gridspec(2, 2, height_ratios=[2.6, 1], width_ratios=[1.5, 1])
        _effective(drawn.add_subplot(grid[0, 0]), drawn.add_subplot(grid[1, 0]), found)
        _share(drawn.add_subplot(grid[:, 1]), found)
    return drawn


def _effective(top: Axes, below: Axes, found: TwoConstantsResult) -> None:
    data = found.effective
    u = np.sqrt(np.diag(data.covariance_s2))
    kelvin, tau = data.blackbody_temperature_k, data.time_constant_s
    top.plot(found.curve_blackbody_k, found.curve_time_constant_s / MS, color=sheet.INK, linewidth=0.9, label="model")
    top.errorbar(
        kelvin, tau / MS, yerr=u / MS, fmt="o", color=sheet.BLUE, markersize=4.5, capsize=3, label="fitted ± u"
    )
    top.set_ylabel("effective time constant (ms)")
    top.tick_params(labelbottom=False)
    top.legend(loc="upper right")
    sheet.zero_line(below)
    left = (tau - found.model_time_constant_s) / US
    below.errorbar(kelvin, left, yerr=u / US, fmt="o", color=sheet.BLUE, markersize=4, capsize=3)
    sheet.robust_limits(below, [np.abs(left) + u / US])
    below.set_xlim(top.get_xlim())
    below.set_xlabel("blackbody (K)")
    below.set_ylabel("fitted −\nmodel (µs)", fontsize=8)


def _share(axes: Axes, found: TwoConstantsResult) -> None:
    axes.plot(found.share_scan, found.deviation, color=sheet.INK, linewidth=1)
    axes.axhline(_TWO_U, color=sheet.FAINT, linestyle="--", linewidth=0.9)
    axes.axvline(found.scene_share, color=sheet.RED, linewidth=1)
    axes.set_xlim(0, 1)
    axes.set_ylim(0, _HIGHEST)
    axes.set_xlabel("share of the scene in the exchange of heat (1)")
    axes.set_ylabel("2 · log-likelihood lost (1)")
