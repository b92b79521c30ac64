"""Pixel sums over the wheel angle: the fit with its residuals, and the paper's figure 5."""

from typing import TYPE_CHECKING

import numpy as np

from irtiming.physics.wheel import TURN, exposed_fraction
from irtiming.records.analysis import Analysis
from irtiming.records.estimate import EdgeDelayFit, PublishedFit, SlopeLine
from irtiming.report import sheet
from irtiming.report.blocks import Panel, Section
from irtiming.report.language import several, t
from irtiming.report.sections.rig import dense_rad

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_PANELS = 8
_BINS = 60


def section(analysis: Analysis) -> Section | None:
    """The pixel sums with the model, and figure 5 where the published procedure was run; None of a camera without them."""
    fits = pixel_fits(analysis)
    if not fits:
        return None
    noise = 1e3 * float(np.sqrt(np.mean([fit.noise**2 for fit in fits])))
    panel = Panel(
        title=t("Pixel sums and fitted model"),
        caption=t(
            "Pixel sums over the opening with its whole blurred border, over the wheel angle at the start of "
            "integration: the delay is taken out, so that all nominal delays fall on one curve. Below: what the fit "
            "leaves over, {noise:.2f}·10⁻³ of the step (standard deviation); red, its mean over 6°. A fit that is "
            "right leaves noise without structure. Right: its distribution beside a normal one.",
            noise=noise,
        ),
        svg=sheet.svg(fitted(analysis), title=t("Pixel sums and fitted model with residuals")),
    )
    published = published_fits(analysis)
    if analysis.published is None or not published:
        return Section(title=t("Exposed fraction and fit"), blocks=(panel,))
    bars = any(fit.data.u_fraction is not None for fit in published)
    scatter = t("Error bars are standard uncertainties from the scatter over runs, mostly smaller than the points. ")
    figure_5 = Panel(
        title=t("Exposed fraction over the wheel angle at the trigger"),
        caption=t(
            "Counts above the threshold, normalised to the plateaus, as in figure 5 of Schatz 2023. A larger delay "
            "shifts the curve to the left: the same state of the wheel stands in frames that were triggered earlier. "
            "Dashed: the model without any delay. {rest}Below: what the four straight lines leave over.",
            rest=scatter if bars else "",
        ),
        svg=sheet.svg(averaged(analysis), title=t("Exposed fraction over wheel angle at the trigger")),
    )
    return Section(title=t("Exposed fraction and fit"), blocks=(panel, figure_5))


def pixel_fits(analysis: Analysis) -> list[EdgeDelayFit]:
    """Fits of pixel sums, one per recording; none of another camera."""
    return [fit for fit in analysis.fits if isinstance(fit, EdgeDelayFit)]


def published_fits(analysis: Analysis) -> list[PublishedFit]:
    """Straight lines through the slopes, one per nominal delay and wheel speed."""
    return (
        [] if analysis.published is None else [fit for fit in analysis.published.fits if isinstance(fit, PublishedFit)]
    )


def averaged(analysis: Analysis) -> "Figure":
    """Figure 5 for the user's camera, with the lines through the slopes and what they leave over."""
    fits, geometry = published_fits(analysis), analysis.geometry
    wheel = geometry.model if analysis.published is None else analysis.published.geometry.model
    names = sheet.run_names(
        [fit.data.trigger_delay_time_set_s for fit in fits], [fit.data.rotation_speed_hz for fit in fits]
    )
    hues = sheet.colours(names)
    with sheet.style():
        drawn = sheet.figure(height_in=5.4)
        top, below = drawn.subplots(2, 1, sharex=True, height_ratios=[2.4, 1.2])
        angle, ink = dense_rad(wheel), sheet.INK
        top.plot(
            np.degrees(angle), exposed_fraction(angle, wheel), "--", color=ink, linewidth=1, label=t("model, no delay")
        )
        for fit, name, hue in zip(fits, names, hues, strict=True):
            _averaged_points(top, fit, name, hue)
            for line in fit.lines:
                _line_and_rest(top, below, line, hue)
        sheet.robust_limits(below, [np.asarray(line.get_ydata(), dtype=float) for line in below.get_lines()])
        top.set_ylabel(t("exposed fraction (1)"))
        top.set_ylim(-0.06, 1.06)
        drawn.legend(loc="outside upper center", ncols=min(6, len(fits) + 1), markerscale=3, columnspacing=1.4)
        sheet.degrees_axis(top, label=None)
        sheet.zero_line(below)
        below.set_ylabel(t("points − line\n(10⁻³ of the step)"))
        sheet.degrees_axis(below, label=t("wheel angle at the trigger (degrees)"))
    return drawn


def _averaged_points(axes: "Axes", fit: PublishedFit, name: str, hue: str) -> None:
    data = fit.data
    label = f"{name}, {several(len(data.names), 'run')}"
    sheet.points(axes, x=np.degrees(data.wheel_angle_rad), y=data.fraction, colour=hue, label=label)
    if data.u_wheel_angle_rad is not None and data.u_fraction is not None:
        axes.errorbar(
            np.degrees(data.wheel_angle_rad), data.fraction, xerr=np.degrees(data.u_wheel_angle_rad),
            yerr=data.u_fraction, fmt="none", ecolor=hue, elinewidth=0.5, rasterized=True,
        )  # fmt: skip


def _line_and_rest(top: "Axes", below: "Axes", line: SlopeLine, hue: str) -> None:
    """The fitted line, broken where it leaves the turn, and the points minus the line."""
    x = np.sort(line.angle_rad)
    for turn in np.unique(np.floor(x / TURN)):
        part = x[np.floor(x / TURN) == turn]
        height = 0.5 + line.slope_per_rad * (part - line.centre_rad)
        top.plot(np.degrees(part - turn * TURN), height, color=hue, linewidth=0.9)
    rest = line.fraction - 0.5 - line.slope_per_rad * (line.angle_rad - line.centre_rad)
    sheet.points(below, x=np.degrees(np.mod(line.angle_rad, TURN)), y=1e3 * rest, colour=hue)


def fitted(analysis: Analysis) -> "Figure":
    """Pixel sums with the fitted model; below, what it leaves over per nominal delay, with its distribution."""
    groups = _groups(analysis)
    shown = groups[:_MOST_PANELS]
    names = sheet.run_names([delay for (_, delay), _ in groups], [speed for (speed, _), _ in groups])
    hues = sheet.colours(names)
    with sheet.style():
        drawn = sheet.figure(height_in=2.5 + 1.0 * len(shown))
        grid = drawn.add_gridspec(1 + len(shown), 2, width_ratios=[6, 1], height_ratios=[2.3] + [1.0] * len(shown))
        top = drawn.add_subplot(grid[0, 0])
        for (_, fits), name, hue in zip(groups, names, hues, strict=True):
            _fitted_points(top, fits, name, hue)
        top.plot([], [], color=sheet.RED, linewidth=1, label=t("fitted model"))
        beside = drawn.add_subplot(grid[0, 1])
        beside.set_axis_off()
        beside.legend(*top.get_legend_handles_labels(), loc="center left", bbox_to_anchor=(-0.3, 0.5), markerscale=3)
        top.set_ylabel(t("exposed fraction (1)"))
        top.set_ylim(-0.06, 1.06)
        sheet.degrees_axis(top, label=None)
        largest = max(float(np.max(np.abs(fit.residual))) for _, fits in shown for fit in fits)
        for row, ((_, fits), name, hue) in enumerate(zip(shown, names, hues, strict=False), start=1):
            last = row == len(shown)
            rest, beside = drawn.add_subplot(grid[row, 0]), drawn.add_subplot(grid[row, 1])
            _rest(rest, fits, name, hue)
            sheet.degrees_axis(rest, label=t("wheel angle at the start of integration (degrees)") if last else None)
            _spread(beside, fits, hue)
            beside.set_xlabel(t("frames (1)") if last else "")
            for axes in (rest, beside):
                axes.set_ylim(-1.1e3 * largest, 1.1e3 * largest)
    return drawn


def _groups(analysis: Analysis) -> list[tuple[tuple[float, float], list[EdgeDelayFit]]]:
    """Fits of the same wheel speed and nominal delay, in order."""
    found: dict[tuple[float, float], list[EdgeDelayFit]] = {}
    for recording, fit in zip(analysis.recordings, pixel_fits(analysis), strict=True):
        found.setdefault((round(recording.rotation_speed_hz, 6), round(fit.trigger_delay_time_set_s, 9)), []).append(
            fit
        )
    return [(key, found[key]) for key in sorted(found)]


def _fitted_points(axes: "Axes", fits: list[EdgeDelayFit], name: str, hue: str) -> None:
    angle = np.concatenate([fit.wheel_angle_rad for fit in fits])
    fraction = np.concatenate([fit.fraction for fit in fits])
    sheet.points(axes, x=np.degrees(angle), y=fraction, colour=hue, label=name)
    one = fits[0]
    axes.plot(np.degrees(one.wheel_angle_rad), one.fraction - one.residual, color=sheet.RED, linewidth=0.7, zorder=3)


def _rest(axes: "Axes", fits: list[EdgeDelayFit], name: str, hue: str) -> None:
    angle = np.concatenate([fit.wheel_angle_rad for fit in fits])
    rest = 1e3 * np.concatenate([fit.residual for fit in fits])
    sheet.zero_line(axes)
    sheet.points(axes, x=np.degrees(angle), y=rest, colour=hue)
    place = np.minimum((angle / TURN * _BINS).astype(int), _BINS - 1)
    count = np.bincount(place, minlength=_BINS)
    mean = np.bincount(place, rest, _BINS) / np.maximum(count, 1)
    filled = count > 0
    axes.plot(((np.arange(_BINS) + 0.5) * 360 / _BINS)[filled], mean[filled], color=sheet.RED, linewidth=1)
    axes.set_ylabel(t("sums − model\n(10⁻³ of step)"), fontsize=7.5)
    noise = 1e3 * float(np.sqrt(np.mean([fit.noise**2 for fit in fits])))
    inflation = max(fit.variance_inflation for fit in fits)
    axes.set_title(
        t(
            "{name}, {fits}: standard deviation {noise:.2f}·10⁻³, u × {widening:.2f} for correlation",
            name=name,
            fits=several(len(fits), "run"),
            noise=noise,
            widening=inflation**0.5,
        ),
        fontsize=8,
        fontweight="normal",
        color=hue,
        pad=2,
    )


def _spread(axes: "Axes", fits: list[EdgeDelayFit], hue: str) -> None:
    """Distribution of the residuals beside a normal one of the same spread."""
    rest = 1e3 * np.concatenate([fit.residual for fit in fits])
    spread = float(rest.std())
    _, bins, _ = axes.hist(rest, bins=31, orientation="horizontal", color=hue, alpha=0.5)
    level = np.linspace(bins[0], bins[-1], 200)
    density = np.exp(-0.5 * (level / spread) ** 2) / (spread * np.sqrt(2 * np.pi))
    axes.plot(density * rest.size * (bins[1] - bins[0]), level, color=sheet.INK, linewidth=0.8)
    axes.tick_params(labelleft=False)
