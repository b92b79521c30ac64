"""The time constant: how well others fit by both methods, and how noise ties it to the trigger delay."""

from typing import TYPE_CHECKING

import numpy as np

from irtiming.records.analysis import Analysis
from irtiming.records.arrays import Array
from irtiming.records.result import Profile
from irtiming.report import camera_noise, sheet
from irtiming.report.blocks import MS, US, Panel, Section, Table
from irtiming.report.language import heads, t
from irtiming.report.meanings import has_lag, label, words
from irtiming.report.rounding import fixed, time_text, uncertainty_text
from irtiming.report.sections.row_sums import absent, published_fits

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PAIR = ("trigger_delay", "time_constant")


def section(analysis: Analysis) -> Section | None:
    """Figures and table; None of a camera without a lag."""
    if not has_lag(analysis):
        return None
    scan = (_scan_panel(analysis),) if _profile_of(analysis) or published_fits(analysis) else ()
    return Section(title=t("Lag and delay"), blocks=(*scan, _ellipse_panel(analysis), noise(analysis)))


def _profile_of(analysis: Analysis) -> Profile | None:
    return next((profile for profile in analysis.profiles if profile.name == "time_constant"), None)


def _scan_panel(analysis: Analysis) -> Panel:
    profile, left, theirs = _profile_of(analysis), "", absent(analysis)
    if profile is not None:
        estimate = time_text(profile.value, profile.standard_uncertainty)
        left = t(
            "Row sums, all recordings: all other numbers at their best at each τ; 1 is one standard uncertainty; "
            "{estimate}. ",
            estimate=estimate,
        )
    for fit in published_fits(analysis)[:1]:
        theirs = t(
            "As published: rms deviation of the published simulation from {names}, delays determined anew at each τ.",
            names=t(" and ").join(fit.data.names[:2]),
        )
    return Panel(
        title=t("How well other time constants fit"),
        caption=t(
            "{left}{theirs} Below: points minus parabola. The narrower the valley, the better τ is known; points off "
            "the parabola would bias its minimum.",
            left=left,
            theirs=theirs,
        ),
        svg=sheet.svg(scan(analysis), title=t("Deviation over the time constant by both methods")),
    )


def scan(analysis: Analysis) -> "Figure":
    """Deviation over the time constant by both methods, each with its parabola and estimate."""
    profile, published = _profile_of(analysis), published_fits(analysis)
    with sheet.style():
        drawn = sheet.figure(height_in=3.5)
        panels = drawn.subplots(2, 2 if profile is not None and published else 1, height_ratios=[2.6, 1], squeeze=False)
        if profile is not None:
            value, u = profile.value, profile.standard_uncertainty
            parabola = np.array([value**2, -2 * value, 1.0]) / u**2
            points = np.stack([profile.values, profile.deviation])
            _valley(panels[:, 0], points, parabola=parabola, found=(value, u), unit="1", hue=sheet.BLUE)
            panels[0, 0].set_title(t("Row sums"))
            panels[0, 0].set_ylabel(t("2 · log-likelihood lost (1)"))
        if published:
            fit = published[0]
            points, found = (
                np.stack([fit.time_constants_s, 1e3 * fit.rms]),
                (fit.timing.time_constant_s, fit.u_timing.time_constant_s),
            )
            _valley(panels[:, -1], points, parabola=1e3 * fit.parabola, found=found, unit="10⁻³", hue=sheet.ORANGE)
            panels[0, -1].set_title(t("As published"))
            panels[0, -1].set_ylabel(t("rms deviation (10⁻³)"))
    return drawn


def _valley(
    pair: np.ndarray, points: Array, *, parabola: Array, found: tuple[float, float], unit: str, hue: str
) -> None:
    """Points (2, n), time constants and deviations, with a parabola p0 + p1 tau + p2 tau^2 and the estimate; below, the rest."""
    (top, below), (tau, deviation) = pair, points
    dense = np.linspace(tau[0], tau[-1], 200)
    top.plot(dense / MS, np.polyval(parabola[::-1], dense), color=sheet.INK, linewidth=0.9, label=t("parabola"))
    top.plot(tau / MS, deviation, "o", color=hue, markersize=3.5, label=t("at fixed τ"))
    top.axvspan((found[0] - found[1]) / MS, (found[0] + found[1]) / MS, color=sheet.RED, alpha=0.15, linewidth=0)
    top.axvline(found[0] / MS, color=sheet.RED, linewidth=1, label=t("estimate ± u"))
    top.tick_params(labelbottom=False)
    top.legend(loc="upper center", frameon=True, framealpha=0.92, edgecolor="none")
    rest = deviation - np.polyval(parabola[::-1], tau)
    sheet.zero_line(below)
    below.plot(tau / MS, rest, "o", color=hue, markersize=3)
    sheet.robust_limits(below, [rest])
    below.set_xlabel(t("time constant (ms)"))
    below.set_ylabel(t("points −\nparabola ({unit})", unit=unit), fontsize=8)


def _ellipse_panel(analysis: Analysis) -> Panel:
    return Panel(
        title=t("Trigger delay and time constant as noise ties them"),
        caption=t(
            "{noise} Box: what ± u of each alone would suggest. Right: with all parts of the budget; errors of "
            "the rig’s angles move the trigger delay only, along the abscissa.",
            noise=noise_sentence(analysis),
        ),
        svg=sheet.svg(ellipse(analysis), title=t("Correlation of trigger delay and time constant")),
    )


def ellipse(analysis: Analysis) -> "Figure":
    """Trigger delay and time constant as noise alone scatters them, and with all parts of their uncertainty."""
    panels = [(t("Noise alone"), camera_noise.noise(analysis).pick(*_PAIR))]
    if all(name in analysis.best.estimate for name in _PAIR):
        panels.append((t("All parts of the uncertainty"), analysis.best.estimate.pick(*_PAIR)))
    with sheet.style():
        drawn = sheet.figure(height_in=3.9)
        grid = drawn.subplots(1, 2)
        for axes, (title, found) in zip(grid, panels, strict=False):
            _ellipses(axes, found.covariance / US**2)
            axes.set_title(title)
        for axes in grid[len(panels) :]:
            axes.set_axis_off()
        drawn.legend(*grid[0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return drawn


def _ellipses(axes: "Axes", covariance: Array) -> None:
    """Ellipses of one and two u, the box of one u of each, and the line of equal differences; covariance in us^2."""
    u = np.sqrt(np.diag(covariance))
    root = np.linalg.cholesky(covariance + 1e-12 * np.diag(u**2))
    turn = np.linspace(0, 2 * np.pi, 200)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    for factor, line in ((1, "-"), (2, ":")):
        across, up = factor * root @ circle
        axes.plot(across, up, line, color=sheet.BLUE, linewidth=1.4, label=t("{factor} u ellipse", factor=factor))
    corners = np.array([[-1, 1, 1, -1, -1], [-1, -1, 1, 1, -1]])
    axes.plot(u[0] * corners[0], u[1] * corners[1], "--", color=sheet.RED, linewidth=1, label=t("box of ± u each"))
    reach = 2.4 * float(u.max())
    axes.plot([-reach, reach], [-reach, reach], color=sheet.FAINT, linewidth=0.9, label=t("same t_delay − τ"))
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_aspect("equal")
    axes.set_xlabel(t("trigger delay − estimate (µs)"))
    axes.set_ylabel(t("time constant − estimate (µs)"))


def noise(analysis: Analysis) -> Table:
    """How well noise alone lets the camera's parameters be distinguished."""
    found = camera_noise.noise(analysis)
    rows = [(label(name), uncertainty_text(found.u(name))) for name in found.names]
    rows.append(
        (
            f"{label(_PAIR[0])} − {label(_PAIR[1])}",
            uncertainty_text(camera_noise.u_of_sum(found, {**_WEIGHTS, _PAIR[1]: -1.0})),
        )
    )
    rows.append((f"{label(_PAIR[0])} + {label(_PAIR[1])}", uncertainty_text(camera_noise.u_of_sum(found, _WEIGHTS))))
    return Table(
        title=t("What the noise of the frames allows"),
        columns=heads("quantity", "u from noise alone"),
        align="lr",
        rows=tuple(rows),
        note=t("Of all recordings and wheel edges together; the budget adds the rig’s angles and the opening’s shape."),
    )


_WEIGHTS = dict.fromkeys(_PAIR, 1.0)


def noise_sentence(analysis: Analysis) -> str:
    """What the correlation of trigger delay and time constant means."""
    found = camera_noise.noise(analysis).pick(*_PAIR)
    ratio = float(found.correlation[0, 1])
    sign, better = (-1.0, t("difference")) if ratio > 0 else (1.0, t("sum"))
    u_better = camera_noise.u_of_sum(found, {_PAIR[0]: 1.0, _PAIR[1]: sign})
    worse = float(found.standard_uncertainties.max())
    return t(
        "Noise correlates {first} and {second} by {ratio}: a lag of τ shows each long slope as it was τ ago, "
        "which a reading later by the same time makes up for; only the rounding of the corners distinguishes "
        "the two. So their {better} is known to {u} from noise, each alone to {worse} or better.",
        first=words(_PAIR[0]),
        second=words(_PAIR[1]),
        ratio=fixed(ratio, 3),
        better=better,
        u=uncertainty_text(u_better),
        worse=uncertainty_text(worse),
    )
