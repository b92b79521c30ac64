"""What the camera recorded of the opening: mean frames with what was found in them, histogram, fitted sector and contrast."""

from typing import TYPE_CHECKING

import numpy as np

from irtiming.physics.projection import projection_of
from irtiming.records.analysis import Analysis
from irtiming.records.arrays import Array
from irtiming.records.reduced import Histogram, Opening, ReducedRecording
from irtiming.records.row_timing import SectorFit, SectorShape
from irtiming.report import sheet
from irtiming.report.blocks import Panel, Section, Table, of_tables
from irtiming.report.language import heads, t
from irtiming.report.rounding import in_unit, significant
from irtiming.report.sections import level

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

_SUM, _OUTLINE, _RED, _BOX, _BAD = "#ffd23f", "#35c4f0", "#ff4d4d", "#58e08f", "#b86bff"
_SHAPE = (
    ("axle, row (px)", "axle_row_px", 1.0),
    ("axle, column (px)", "axle_column_px", 1.0),
    ("mask centre beside the axle, rows (px)", "offset_row_px", 1.0),
    ("mask centre beside the axle, columns (px)", "offset_column_px", 1.0),
    ("inner radius (px)", "inner_radius_px", 1.0),
    ("outer radius (px)", "outer_radius_px", 1.0),
    ("bisector (degrees)", "bisector_rad", 180 / np.pi),
    ("opening angle (degrees)", "opening_angle_rad", 180 / np.pi),
    ("blur, standard deviation (px)", "blur_px", 1.0),
    ("distortion of the lens", "distortion", 1.0),
    ("blur over columns against rows", "blur_ellipticity", 1.0),
    ("blur, correlation of rows and columns", "blur_correlation", 1.0),
    ("blur, growth of its variance over half a diagonal (%)", "blur_growth", 100.0),
    ("glare, share of the light", "glare", 1.0),
    ("glare, standard deviation (px)", "glare_px", 1.0),
    ("keystone, rows (% over half a diagonal)", "keystone_row", 100.0),
    ("keystone, columns (% over half a diagonal)", "keystone_column", 100.0),
    ("logarithm of the focal length in half diagonals", "log_focal_length", 1.0),
    ("lens centre beside the image’s middle, rows (px)", "lens_row_px", 1.0),
    ("lens centre beside the image’s middle, columns (px)", "lens_column_px", 1.0),
)


def section(analysis: Analysis) -> Section:
    """Frames, histogram, sector, and the camera's level over time, as far as the recordings have them."""
    found = analysis.recordings[0].opening.histogram
    histograms = (_histogram_panel(found),) if found is not None else ()
    fits = analysis.sectors[:1]
    sectors = [block for fit in fits for block in (_contrast_panel(fit), sector(fit))]
    events = of_tables(level.shutter_events(analysis))
    return Section(
        title=t("What the camera recorded"),
        blocks=(_frames_panel(analysis), *histograms, *sectors, *level.panels(analysis), *events),
    )


def _frames_panel(analysis: Analysis) -> Panel:
    others = len(analysis.recordings) - 1
    more = (
        ""
        if not others
        else t(" The other recording shares this region.")
        if others == 1
        else t(" The other recordings share this region.")
    )
    sectors = t(" Red: the fitted sector.") if analysis.sectors else ""
    return Panel(
        title=t("The mask opening in the image"),
        caption=t(
            "Left: mean frame with the wheel open. Right: open minus covered. The summed region holds the opening "
            "with its blurred border: cut at half contrast it would lose light. Violet: bad pixels, for which "
            "neighbours stand in. The axle follows from how each pixel follows the wheel, the bisector from the "
            "mask’s two straight edges.{sectors}{more}",
            sectors=sectors,
            more=more,
        ),
        svg=sheet.svg(mean_frames(analysis), title=t("Mean frame with region of interest and opening")),
    )


def _histogram_panel(found: Histogram) -> Panel:
    return Panel(
        title=t("Histogram and threshold"),
        caption=t(
            "Corrected pixel values in the region of interest. The threshold serves the published method only; the "
            "pixel sums need none."
        ),
        svg=sheet.svg(histogram(found), title=t("Histogram of the region of interest with threshold")),
    )


def _contrast_panel(fit: SectorFit) -> Panel:
    return Panel(
        title=t("Contrast of the opening"),
        caption=t(
            "Contrast of each pixel from the wheel’s second harmonic; that of the fitted sector; the difference, "
            "which also holds mask-plate contrast and reflection by an uneven wheel; and what nothing but pixel "
            "gains or burrs of the mask explains. The model keeps all of it."
        ),
        svg=sheet.svg(contrasts(fit), title=t("Contrast, fitted sector and excess")),
    )


def mean_frames(analysis: Analysis) -> "Figure":
    """Mean frame of the open wheel with what was found in it; beside it, the summed region closely."""
    from matplotlib.patches import Rectangle

    recording = analysis.recordings[0]
    opening = recording.opening
    with sheet.style():
        drawn = sheet.figure(height_in=4.1)
        left, right = drawn.subplots(1, 2, width_ratios=[1.15, 1])
        picture(left, opening.open_frame_dn)
        left.set_title(t("Mean open frame, {name}", name=recording.name))
        row0, row1, column0, column1 = opening.roi
        corner, size = (column0 - 0.5, row0 - 0.5), (column1 - column0, row1 - row0)
        left.add_patch(Rectangle(corner, *size, fill=False, edgecolor=_BOX, linewidth=1.2))
        _axle(left, recording)
        for fit in analysis.sectors[:1]:
            _sector(left, fit.shape)
        picture(right, opening.open_frame_dn - opening.covered_frame_dn)
        right.set_title(t("Open minus covered, region of interest"))
        _outlines(left, opening, closely=False)
        _outlines(right, opening, closely=True)
        _label(left, right)
        right.set_xlim(column0 - 0.5, column1 - 0.5)
        right.set_ylim(row1 - 0.5, row0 - 0.5)
        drawn.legend(handles=_legend(recording), loc="outside lower center", ncols=3)
    return drawn


def _label(*panels: "Axes") -> None:
    for axes in panels:
        axes.set_xlabel(t("column (px)"))
        axes.set_ylabel(t("row (px)"))
        axes.grid(visible=False)


def picture(axes: "Axes", frame: Array, *, label: str = "") -> None:
    """Grey picture (row, column), black to white over all but the rarest values, with its scale beside it."""
    low, high = (float(v) for v in np.quantile(frame, [0.002, 0.998]))
    shades = axes.imshow(frame, cmap="gray", vmin=low, vmax=high, interpolation="nearest")
    axes.figure.colorbar(shades, ax=axes, label=label or t("corrected value (DN)"), shrink=0.8, pad=0.02)


def _outlines(axes: "Axes", opening: Opening, *, closely: bool) -> None:
    """Outline of the summed region; closely also that of the opening, and the threshold as a contour."""
    row0, row1, column0, column1 = opening.roi
    axes.contour(opening.summed.astype(float), levels=[0.5], colors=_SUM, linewidths=1.3)
    if not closely:
        return
    axes.contour(opening.mask.astype(float), levels=[0.5], colors=_OUTLINE, linewidths=1.6)
    bad_row, bad_column = np.nonzero(opening.bad & opening.summed)
    axes.plot(bad_column, bad_row, "s", color=_BAD, markersize=2.5, markeredgewidth=0)
    if opening.histogram is None:
        return
    part, threshold_dn = np.full(opening.mask.shape, np.nan), opening.histogram.threshold_dn
    part[row0:row1, column0:column1] = opening.open_frame_dn[row0:row1, column0:column1]
    if np.nanmin(part) < threshold_dn < np.nanmax(part):
        axes.contour(part, levels=[threshold_dn], colors=_RED, linewidths=1.6, linestyles="dashed")


def _axle(axes: "Axes", recording: ReducedRecording) -> None:
    """Cross at the axle and the bisector of the opening from there to the edge of the image."""
    view = recording.axle
    if view is None:
        return
    rows, columns = recording.opening.open_frame_dn.shape
    reach = 2.0 * (rows + columns)
    axes.plot(
        [view.column_px, view.column_px + reach * np.cos(view.bisector_rad)],
        [view.row_px, view.row_px + reach * np.sin(view.bisector_rad)],
        "-.", color=sheet.ORANGE, linewidth=1,
    )  # fmt: skip
    axes.plot([view.column_px], [view.row_px], "+", color=sheet.ORANGE, markersize=13, markeredgewidth=1.8)
    axes.set_xlim(min(-0.5, view.column_px - 3), max(columns - 0.5, view.column_px + 3))
    axes.set_ylim(max(rows - 0.5, view.row_px + 3), min(-0.5, view.row_px - 3))


def _legend(recording: ReducedRecording) -> "list[Line2D | Patch]":
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    opening = recording.opening
    entries: list[Line2D | Patch] = [
        Patch(facecolor="none", edgecolor=_BOX, linewidth=1.5, label=t("region of interest")),
        Line2D(
            [],
            [],
            color=_SUM,
            linewidth=2,
            label=t("summed region, border {border_px} px", border_px=opening.border_px),
        ),
        Line2D([], [], color=_OUTLINE, linewidth=2, label=t("mask opening at half contrast")),
    ]
    if opening.histogram is not None:
        words = t("threshold {threshold_dn:.0f} DN", threshold_dn=opening.histogram.threshold_dn)
        entries.append(Line2D([], [], color=_RED, linestyle="--", linewidth=2, label=words))
    if recording.axle is not None:
        entries += [
            Line2D([], [], color=sheet.ORANGE, marker="+", markersize=10, linestyle="none", label=t("axle")),
            Line2D([], [], color=sheet.ORANGE, linestyle="-.", label=t("bisector of the mask opening")),
        ]
    return entries


def histogram(found: Histogram) -> "Figure":
    """Pixel values of the region of interest in open frames, the two peaks and the threshold between them."""
    with sheet.style():
        drawn = sheet.figure(height_in=2.7)
        axes = drawn.add_subplot()
        axes.stairs(found.count, found.bin_edges_dn, fill=True, color=sheet.BLUE, alpha=0.45)
        axes.stairs(found.count, found.bin_edges_dn, color=sheet.BLUE, linewidth=0.8)
        axes.set_yscale("log")
        axes.set_ylim(0.5, 4 * float(found.count.max()))
        level = (found.threshold_dn - found.plate_dn) / (found.blackbody_dn - found.plate_dn)
        for value, text, colour in (
            (found.plate_dn, t("mask plate\n{plate_dn:.0f} DN", plate_dn=found.plate_dn), sheet.INK),
            (
                found.threshold_dn,
                t(
                    "threshold {threshold_dn:.0f} DN\n{level:.0%} of the step",
                    threshold_dn=found.threshold_dn,
                    level=level,
                ),
                sheet.RED,
            ),
            (found.blackbody_dn, t("blackbody\n{blackbody_dn:.0f} DN", blackbody_dn=found.blackbody_dn), sheet.INK),
        ):
            axes.axvline(value, color=colour, linewidth=1.1, linestyle="--")
            right = value < float(np.mean(found.bin_edges_dn[[0, -1]]))
            axes.annotate(
                text, (value, 0.97), xycoords=("data", "axes fraction"), xytext=(5 if right else -5, 0),
                textcoords="offset points", va="top", ha="left" if right else "right", color=colour, fontsize=8,
            )  # fmt: skip
        axes.set_xlabel(t("corrected value in the mean open frame (DN)"))
        axes.set_ylabel(t("pixels (1)"))
    return drawn


def contrasts(fit: SectorFit) -> "Figure":
    """Contrast of each pixel as measured, by the sector, and what the sector and then the whole model leave over."""
    row0, row1, column0, column1 = fit.roi
    beyond = fit.contrast - fit.model_contrast
    with sheet.style():
        drawn = sheet.figure(height_in=6.2)
        panels = drawn.subplots(2, 2).ravel()
        for axes, values, title in zip(
            panels,
            (fit.contrast, fit.model_contrast, beyond, fit.excess),
            (t("Contrast of each pixel, from all frames"), t("Contrast of the fitted sector"), t("Measured minus sector"),
             t("Excess: what nothing in the model explains")),
            strict=True,
        ):  # fmt: skip
            rest = values is beyond or values is fit.excess
            spread = max(float(np.quantile(np.abs(values), 0.995)), 1e-3)
            low, high = (-spread, spread) if rest else (-0.05, 1.1)
            shades = axes.imshow(
                values, cmap="RdBu_r" if rest else "gray", vmin=low, vmax=high, interpolation="nearest",
                extent=(column0 - 0.5, column1 - 0.5, row1 - 0.5, row0 - 0.5),
            )  # fmt: skip
            drawn.colorbar(shades, ax=axes, label=t("contrast (1)"), shrink=0.8, pad=0.02)
            axes.set_title(title)
        _label(*panels)
    return drawn


def _sector(axes: "Axes", shape: SectorShape) -> None:
    """Arcs and radial edges of the fitted sector in the image."""
    half = shape.opening_angle_rad / 2
    around = shape.bisector_rad + np.linspace(-half, half, 100)
    polar = np.concatenate([around, around[::-1], around[:1]])
    radius = np.repeat([shape.outer_radius_px, shape.inner_radius_px, shape.outer_radius_px], [100, 100, 1])
    down, across = shape.offset_row_px + radius * np.sin(polar), shape.offset_column_px + radius * np.cos(polar)
    border = projection_of(shape).seen(down, shape.sense * across)
    axes.plot(border[1], border[0], color=_RED, linewidth=1.2)


def sector(found: SectorFit) -> Table:
    """The opening in the image as fitted."""
    rows = [
        (
            t(words),
            in_unit(found.value(name), found.u(name), unit_s=1 / factor),
            significant(found.u(name) * factor),
        )
        for words, name, factor in _SHAPE
    ]
    if found.u_row_delay_s > 0:
        phases = in_unit(found.row_delay_s, found.u_row_delay_s, unit_s=1e-6)
        rows.append((t("row delay by the pixels’ phases (µs)"), phases, significant(1e6 * found.u_row_delay_s)))
    return Table(
        title=t("The fitted sector"),
        columns=heads("what", "value", "u"),
        align="lrr",
        rows=tuple(rows),
        note=t(
            "An annular sector, blurred, fitted to the contrast image; reduced χ² {reduced_chi_square:.3g}. Above 1 "
            "the opening is no perfect sector or pixels differ in gain: what is left over enters the model as it is.",
            reduced_chi_square=found.reduced_chi_square,
        ),
    )
