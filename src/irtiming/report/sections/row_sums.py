"""Rows over the wheel angle: figure 6, the delay of each row, and what the fit leaves over."""

from typing import TYPE_CHECKING

import numpy as np

from irtiming.physics.wheel import TURN
from irtiming.records.analysis import Analysis
from irtiming.records.arrays import Array
from irtiming.records.lag_estimate import PublishedLagFit
from irtiming.records.row_timing import RowTimingFit
from irtiming.report import bent_edge, row_curves, sheet
from irtiming.report.blocks import MS, US, Panel, Section
from irtiming.report.language import t
from irtiming.report.meanings import has_lag
from irtiming.report.rounding import uncertainty_text
from irtiming.report.row_curves import Curve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BINS = 144


def sections(analysis: Analysis) -> tuple[Section, ...]:
    """Figure 6, and row by row; none of a camera whose pixels were summed at once."""
    fits = row_fits(analysis)
    if not fits:
        return ()
    return (
        Section(title=t("Exposed fraction and fit"), blocks=(_figure_6_panel(analysis),)),
        Section(title=t("Row by row"), blocks=(_row_panel(analysis), _map_panel(analysis))),
    )


def row_fits(analysis: Analysis) -> list[RowTimingFit]:
    """Fits of row sums, one per recording; none of another camera."""
    return [fit for fit in analysis.fits if isinstance(fit, RowTimingFit)]


def published_fits(analysis: Analysis) -> list[PublishedLagFit]:
    """By the published simulation, one per nominal delay and wheel speed."""
    fits = () if analysis.published is None else analysis.published.fits
    return [fit for fit in fits if isinstance(fit, PublishedLagFit)]


def absent(analysis: Analysis) -> str:
    """Why nothing of the published procedure is shown."""
    return (
        t("The published procedure was not run.")
        if analysis.published is None
        else t("The published procedure could not be run.")
    )


def _figure_6_panel(analysis: Analysis) -> Panel:
    fit = row_fits(analysis)[0]
    rows = ", ".join(str(fit.row_px[k]) for k in row_curves.show_rows(fit))
    lags, rolls = has_lag(analysis), fit.row_delay_s != 0
    rounds = (
        t("Pixels lag, so every corner is rounded behind it")
        if lags
        else t("The integration window rounds every corner")
    )
    later = t("; later rows show the wheel further on") if rolls else ""
    bend = (
        t(
            " Rows are read one after the other, which bends the edge; dashed: where it would be if all rows were "
            "read with the middle one."
        )
        if rolls
        else ""
    )
    return Panel(
        title=t("Opening fractions of the whole opening and of four rows"),
        caption=t(
            "As figure 6 of Schatz 2023, from {name}. (a) Rows weighted by their light; (c) to (f) rows {rows}, "
            "marked in (b). Points: frames, over the wheel angle at the trigger with its set delay; black: the exact "
            "model with the fitted numbers; below each what it leaves over, red its mean over 6°. {rounds}{later}. "
            "(b) A frame as recorded. Red: the edge where {lagging}pixels are half way.{bend}",
            name=fit.name,
            rows=rows,
            rounds=rounds,
            later=later,
            lagging=t("lagging ") if lags else "",
            bend=bend,
        ),
        svg=sheet.svg(figure_6(analysis), title=t("Opening fractions over the wheel angle with residuals")),
    )


def _row_panel(analysis: Analysis) -> Panel:
    fit = row_fits(analysis)[0]
    ours = row_curves.row_delays(fit)
    weight = 1 / ours.u_delay_s**2
    rms = float(np.sqrt(np.sum(weight * (ours.delay_s - ours.line_s) ** 2) / weight.sum()))
    theirs = absent(analysis)
    for published in published_fits(analysis)[:1]:
        line = published.timing.trigger_delay_s + published.timing.row_delay_s * published.row_px
        rms_published = float(np.sqrt(np.nanmean((published.delay_of_row_s - line) ** 2)))
        theirs = t(
            "Orange: published row delays (horizontal distance of the slopes; outliers lie at the edge of the "
            "picture), rms {rms} about their line.",
            rms=uncertainty_text(rms_published),
        )
    return Panel(
        title=t("Delay of each image row"),
        caption=t(
            "Blue, {name}: where each row alone would have the exact model, the other numbers held, with standard "
            "uncertainties from noise; weighted rms distance from the line {rms}. Rows with much less light than the "
            "others are left out of the picture, not of the fit. {theirs} A bend would show distortion by the lens "
            "or an uneven readout.",
            name=fit.name,
            rms=uncertainty_text(rms),
            theirs=theirs,
        ),
        svg=sheet.svg(row_delays(analysis), title=t("Delay over the image row with residuals")),
    )


def _map_panel(analysis: Analysis) -> Panel:
    wrong = t("time constant") if has_lag(analysis) else t("integration time")
    return Panel(
        title=t("Residuals of all rows"),
        caption=t(
            "{name}: data minus model, mean over 2.5° of wheel angle, over the standard deviation that the row’s "
            "noise would give that mean. Good: speckle between −2 and 2. Stripes along an edge’s passing would show "
            "a wrong {wrong}, a wrong edge or a mask that is no sector.",
            name=row_fits(analysis)[0].name,
            wrong=wrong,
        ),
        svg=sheet.svg(residual_map(analysis), title=t("Residuals over image row and wheel angle")),
    )


def figure_6(analysis: Analysis) -> "Figure":
    """Whole opening (a), a frame with a bent edge (b), four rows (c) to (f): data, exact model and residuals."""
    fit = row_fits(analysis)[0]
    rows = row_curves.show_rows(fit)
    hues = sheet.SERIES[: len(rows)]
    with sheet.style():
        drawn = sheet.figure(height_in=9.6)
        grid = drawn.add_gridspec(
            8, 2, height_ratios=[2.3, 1.0, 0.08, 2.0, 0.9, 0.08, 2.0, 0.9], width_ratios=[1.12, 1.0]
        )
        pair = drawn.add_subplot(grid[0, 0]), drawn.add_subplot(grid[1, 0])
        _curve(pair, row_curves.whole(fit), sheet.BLUE, t("(a) whole opening"))
        bent_edge.draw(
            drawn.add_subplot(grid[0:2, 1]), analysis, marked=dict(zip(fit.row_px[rows].tolist(), hues, strict=True))
        )
        for k, (index, hue) in enumerate(zip(rows, hues, strict=True)):
            place = 3 * (1 + k // 2)
            pair = drawn.add_subplot(grid[place, k % 2]), drawn.add_subplot(grid[place + 1, k % 2])
            _curve(
                pair,
                row_curves.one_row(fit, index),
                hue,
                t("({letter}) row {row}", letter="cdef"[k], row=fit.row_px[index]),
            )
    return drawn


def _curve(pair: "tuple[Axes, Axes]", curve: Curve, hue: str, title: str) -> None:
    """Points with the model through them, and the residuals below."""
    top, below = pair
    top.plot(
        np.degrees(curve.wheel_angle_rad), curve.fraction, ".", color=hue, markersize=4.5, markeredgewidth=0,
        rasterized=curve.fraction.size > 600,
    )  # fmt: skip
    top.plot(np.degrees(curve.dense_rad), curve.model, color=sheet.INK, linewidth=0.5)
    spread = 1e3 * float(curve.residual.std())
    top.set_title(t("{title}: residuals {spread:.2f}·10⁻³ rms", title=title, spread=spread))
    top.set_ylabel(t("opening fraction (1)"))
    top.set_ylim(-0.08, 1.08)
    sheet.degrees_axis(top, label=None)
    sheet.zero_line(below)
    sheet.points(below, x=np.degrees(curve.wheel_angle_rad), y=1e3 * curve.residual, colour=hue)
    angle, mean = _binned(curve.wheel_angle_rad, 1e3 * curve.residual[:, None], 60)
    below.plot(np.degrees(angle), mean[:, 0], color=sheet.RED, linewidth=0.9)
    sheet.robust_limits(below, [1e3 * curve.residual])
    below.set_ylabel(t("data − model\n(10⁻³ of step)"), fontsize=7.5)
    sheet.degrees_axis(below, label=t("wheel angle (degrees)"))
    below.xaxis.label.set_fontsize(7.5)


def _binned(angle_rad: Array, values: Array, n_bins: int) -> tuple[Array, Array]:
    """Middle of each filled bin of a turn and the mean of the values (n, k) in it, shapes (bins,) and (bins, k)."""
    place = np.minimum((angle_rad / TURN * n_bins).astype(int), n_bins - 1)
    count = np.bincount(place, minlength=n_bins)
    total = np.zeros((n_bins, values.shape[1]))
    np.add.at(total, place, values)
    filled = count > 0
    return ((np.arange(n_bins) + 0.5) * TURN / n_bins)[filled], total[filled] / count[filled, None]


def residual_map(analysis: Analysis) -> "Figure":
    """Residuals of all rows over the wheel angle, means of narrow bins over what noise would leave of them."""
    fit = row_fits(analysis)[0]
    rows = np.arange(fit.row_px[0], fit.row_px[-1] + 1)
    table = np.full((rows.size, _BINS), np.nan)
    angle, mean = _binned(fit.wheel_angle_rad, fit.residual / fit.noise, _BINS)
    place = (angle / TURN * _BINS).astype(int)
    count = np.bincount(np.minimum((fit.wheel_angle_rad / TURN * _BINS).astype(int), _BINS - 1), minlength=_BINS)
    table[np.ix_(fit.row_px - rows[0], place)] = (mean * np.sqrt(count[place])[:, None]).T
    with sheet.style():
        drawn = sheet.figure(height_in=3.4)
        axes = drawn.add_subplot()
        shades = axes.imshow(
            table, cmap="RdBu_r", vmin=-4, vmax=4, interpolation="nearest", aspect="auto",
            extent=(0, 360, rows[-1] + 0.5, rows[0] - 0.5),
        )  # fmt: skip
        axes.figure.colorbar(shades, ax=axes, label=t("mean residual over its noise (1)"), pad=0.015)
        axes.set_ylabel(t("image row (px)"))
        axes.grid(visible=False)
        sheet.degrees_axis(axes, label=t("wheel angle (degrees)"))
    return drawn


def row_delays(analysis: Analysis) -> "Figure":
    """Delay of each row by both methods, what its straight line is, and the distance from it."""
    fit = row_fits(analysis)[0]
    ours = row_curves.row_delays(fit)
    clear = ours.u_delay_s < 5 * float(np.median(ours.u_delay_s))
    theirs = published_fits(analysis)[:1]
    with sheet.style():
        drawn = sheet.figure(height_in=4.4)
        top, *below = drawn.subplots(2 + len(theirs), 1, sharex=True, height_ratios=[2.2, 1, 1][: 2 + len(theirs)])
        top.plot(ours.row_px, ours.line_s / MS, color=sheet.BLUE, linewidth=1, label=_line_name(t("row sums"), fit))
        top.plot(ours.row_px[clear], ours.delay_s[clear] / MS, ".", color=sheet.BLUE, markersize=4)
        for published in theirs:
            _published_rows(top, below[1], published, ours.line_s)
        top.set_ylabel(t("delay of the row (ms)"))
        top.legend(loc="best")
        below[0].errorbar(
            ours.row_px[clear], (ours.delay_s - ours.line_s)[clear] / US, yerr=ours.u_delay_s[clear] / US, fmt=".",
            color=sheet.BLUE, markersize=4, elinewidth=0.8,
        )  # fmt: skip
        for axes, name in zip(below, (t("row sums"), t("published")), strict=False):
            sheet.zero_line(axes)
            axes.set_ylabel(t("{name}:\nrow − line (µs)", name=name), fontsize=8)
        below[-1].set_xlabel(t("image row (px)"))
    return drawn


def _published_rows(top: "Axes", below: "Axes", published: PublishedLagFit, our_line_s: Array) -> None:
    """Row delays of the published procedure, outliers at the edge of the picture, and their distance from their line."""
    line_s = published.timing.trigger_delay_s + published.timing.row_delay_s * published.row_px
    away_s = published.delay_of_row_s - line_s
    reach = 4 * max(float(np.nanmedian(np.abs(away_s))), 1e-7)
    low, high = np.min([*our_line_s, *line_s]) - reach, np.max([*our_line_s, *line_s]) + reach
    top.plot(published.row_px, line_s / MS, color=sheet.ORANGE, linewidth=1, label=t("as published: line"))
    top.plot(
        published.row_px, np.clip(published.delay_of_row_s, low, high) / MS, "x", color=sheet.ORANGE, markersize=3.5
    )
    top.set_ylim(low / MS, high / MS)
    apart = np.clip(away_s, -reach, reach) / US
    below.plot(published.row_px, apart, "x", color=sheet.ORANGE, markersize=3.5)
    sheet.robust_limits(below, [apart])


def _line_name(name: str, fit: RowTimingFit) -> str:
    rows = t(" + row · {delay:.2f} µs", delay=fit.row_delay_s / US) if fit.row_delay_s else ""
    return t("{name}: {mean:.3f} ms{rows}", name=name, mean=fit.edge_delay_s.mean() / MS, rows=rows)
