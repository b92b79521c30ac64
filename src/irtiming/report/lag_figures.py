"""The time constant: how well others fit by both methods, and how noise ties it to the trigger delay."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from irtiming.records.arrays import Array
from irtiming.report import rolling_noise, sheet
from irtiming.report.evidence import RollingEvidence

MS, US = 1e-3, 1e-6


def scan(evidence: RollingEvidence) -> Figure:
    """Deviation over the time constant by both methods, each with its parabola and estimate."""
    with sheet.style():
        drawn = sheet.figure(height_in=3.5)
        grid = drawn.add_gridspec(2, 2, height_ratios=[2.6, 1])
        _likelihood(drawn.add_subplot(grid[0, 0]), drawn.add_subplot(grid[1, 0]), evidence)
        _published(drawn.add_subplot(grid[0, 1]), drawn.add_subplot(grid[1, 1]), evidence)
    return drawn


def _likelihood(top: Axes, below: Axes, evidence: RollingEvidence) -> None:
    tau, deviation = evidence.scan.time_constant_s / MS, evidence.scan.deviation
    parabola = np.polyfit(tau - tau.mean(), deviation, 2)
    dense = np.linspace(tau[0], tau[-1], 200)
    top.plot(dense, np.polyval(parabola, dense - tau.mean()), color=sheet.INK, linewidth=0.9, label="parabola")
    top.plot(tau, deviation, "o", color=sheet.BLUE, markersize=3.5, label="fits at fixed τ")
    fit = evidence.row_fits[0]
    value, u = fit.estimate.value("time_constant") / MS, fit.estimate.u("time_constant") / MS
    _estimate(top, value, u)
    top.set_ylabel("2 · log-likelihood lost (1)")
    top.set_title("Row sums")
    top.legend(loc="upper center", frameon=True, framealpha=0.92, edgecolor="none")
    _rest(below, tau, deviation - np.polyval(parabola, tau - tau.mean()), sheet.BLUE)
    below.set_ylabel("points −\nparabola (1)", fontsize=8)


def _published(top: Axes, below: Axes, evidence: RollingEvidence) -> None:
    if not evidence.published_fits:
        top.set_axis_off()
        below.set_axis_off()
        return
    fit = evidence.published_fits[0]
    tau, rms = fit.time_constants_s, 1e3 * fit.rms
    dense = np.linspace(tau[0], tau[-1], 200)
    level = 1e3 * np.polyval(fit.parabola[::-1], dense)
    top.plot(dense / MS, level, color=sheet.INK, linewidth=0.9, label="parabola")
    top.plot(tau / MS, rms, "s", color=sheet.ORANGE, markersize=3.5, label="simulations")
    _estimate(top, fit.timing.time_constant_s / MS, fit.u_timing.time_constant_s / MS)
    top.set_ylabel("rms deviation (10⁻³)")
    top.set_title("As published")
    top.legend(loc="upper center", frameon=True, framealpha=0.92, edgecolor="none")
    _rest(below, tau / MS, rms - 1e3 * np.polyval(fit.parabola[::-1], tau), sheet.ORANGE)
    below.set_ylabel("points −\nparabola (10⁻³)", fontsize=8)


def _estimate(axes: Axes, value: float, u: float) -> None:
    axes.axvspan(value - u, value + u, color=sheet.RED, alpha=0.15, linewidth=0)
    axes.axvline(value, color=sheet.RED, linewidth=1, label="estimate ± u (noise)")
    axes.tick_params(labelbottom=False)


def _rest(axes: Axes, tau_ms: Array, rest: Array, hue: str) -> None:
    sheet.zero_line(axes)
    axes.plot(tau_ms, rest, "o", color=hue, markersize=3)
    sheet.robust_limits(axes, [rest])
    axes.set_xlabel("time constant (ms)")


def ellipse(evidence: RollingEvidence) -> Figure:
    """Trigger delay and time constant as noise alone scatters them, and with all parts of their uncertainty."""
    found = rolling_noise.noise(evidence.row_fits)
    panels = [("Noise alone", found.covariance_s2[:2, :2])]
    names = evidence.best.estimate.names
    if {"trigger_delay", "time_constant"} <= set(names):
        pick = [names.index("trigger_delay"), names.index("time_constant")]
        panels.append(("All parts of the uncertainty", evidence.best.estimate.covariance[np.ix_(pick, pick)]))
    with sheet.style():
        drawn = sheet.figure(height_in=3.9)
        grid = drawn.subplots(1, 2)
        for axes, (title, covariance) in zip(grid, panels, strict=False):
            _ellipses(axes, covariance / US**2)
            axes.set_title(title)
        for axes in grid[len(panels) :]:
            axes.set_axis_off()
        drawn.legend(*grid[0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return drawn


def _ellipses(axes: Axes, covariance: Array) -> None:
    """Ellipses of one and two u, the box of one u of each, and the line of equal differences; covariance in us^2."""
    u = np.sqrt(np.diag(covariance))
    root = np.linalg.cholesky(covariance + 1e-12 * np.diag(u**2))
    turn = np.linspace(0, 2 * np.pi, 200)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    for factor, line in ((1, "-"), (2, ":")):
        across, up = factor * root @ circle
        axes.plot(across, up, line, color=sheet.BLUE, linewidth=1.4, label=f"{factor} u ellipse")
    corners = np.array([[-1, 1, 1, -1, -1], [-1, -1, 1, 1, -1]])
    axes.plot(u[0] * corners[0], u[1] * corners[1], "--", color=sheet.RED, linewidth=1, label="box of ± u each")
    reach = 2.4 * float(u.max())
    axes.plot([-reach, reach], [-reach, reach], color=sheet.FAINT, linewidth=0.9, label="same t_delay − τ")
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_aspect("equal")
    axes.set_xlabel("trigger delay − estimate (µs)")
    axes.set_ylabel("time constant − estimate (µs)")
