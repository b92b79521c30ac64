"""What the camera saw: mean frames with everything that was found in them, and the histogram with the threshold."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from irtiming.records.arrays import Array
from irtiming.records.reduced import Opening, ReducedRecording
from irtiming.report import sheet
from irtiming.report.evidence import Evidence

_SUM, _OUTLINE, _LEVEL, _BOX = "#ffd23f", "#35c4f0", "#ff4d4d", "#58e08f"


def mean_frames(evidence: Evidence) -> Figure:
    """Mean frame of the open wheel with what was found in it; beside it, the summed region seen closely."""
    recording = evidence.recordings[0]
    opening = recording.opening
    with sheet.style():
        drawn = sheet.figure(height_in=4.1)
        left, right = drawn.subplots(1, 2, width_ratios=[1.15, 1])
        picture(left, opening.open_frame_dn)
        left.set_title(f"Mean open frame, {recording.name}")
        row0, row1, column0, column1 = opening.roi
        left.add_patch(
            Rectangle(
                (column0 - 0.5, row0 - 0.5), column1 - column0, row1 - row0, fill=False, edgecolor=_BOX, linewidth=1.2
            )
        )
        _axle(left, recording)
        picture(right, opening.open_frame_dn - opening.covered_frame_dn)
        right.set_title("Open minus covered, region of interest")
        _outlines(left, opening, closely=False)
        _outlines(right, opening, closely=True)
        for axes in (left, right):
            axes.set_xlabel("column (px)")
            axes.set_ylabel("row (px)")
            axes.grid(visible=False)
        right.set_xlim(column0 - 0.5, column1 - 0.5)
        right.set_ylim(row1 - 0.5, row0 - 0.5)
        drawn.legend(handles=_legend(recording), loc="outside lower center", ncols=3)
    return drawn


def picture(axes: Axes, frame: Array, *, label: str = "corrected value (DN)", shrink: float = 0.8) -> None:
    """Grey picture of a frame, shape (row, column), black to white over all but the rarest values, with its scale beside it."""
    low, high = (float(v) for v in np.quantile(frame, [0.002, 0.998]))
    shades = axes.imshow(frame, cmap="gray", vmin=low, vmax=high, interpolation="nearest")
    axes.figure.colorbar(shades, ax=axes, label=label, shrink=shrink, pad=0.02)


def _outlines(axes: Axes, opening: Opening, *, closely: bool) -> None:
    """Outline of the summed region; closely also that of the opening, and the threshold as a contour."""
    row0, row1, column0, column1 = opening.roi
    axes.contour(opening.summed.astype(float), levels=[0.5], colors=_SUM, linewidths=1.3)
    if not closely:
        return
    axes.contour(opening.mask.astype(float), levels=[0.5], colors=_OUTLINE, linewidths=1.6)
    if opening.histogram is None:
        return
    part, threshold_dn = np.full(opening.mask.shape, np.nan), opening.histogram.threshold_dn
    part[row0:row1, column0:column1] = opening.open_frame_dn[row0:row1, column0:column1]
    if np.nanmin(part) < threshold_dn < np.nanmax(part):
        axes.contour(part, levels=[threshold_dn], colors=_LEVEL, linewidths=1.6, linestyles="dashed")


def _axle(axes: Axes, recording: ReducedRecording) -> None:
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


def _legend(recording: ReducedRecording) -> list[Line2D | Patch]:
    opening = recording.opening
    entries: list[Line2D | Patch] = [
        Patch(facecolor="none", edgecolor=_BOX, linewidth=1.5, label="region of interest"),
        Line2D([], [], color=_SUM, linewidth=2, label=f"summed region, border {opening.border_px} px"),
        Line2D([], [], color=_OUTLINE, linewidth=2, label="mask opening at half contrast"),
    ]
    if opening.histogram is not None:
        words = f"threshold {opening.histogram.threshold_dn:.0f} DN"
        entries.append(Line2D([], [], color=_LEVEL, linestyle="--", linewidth=2, label=words))
    if recording.axle is not None:
        entries += [
            Line2D([], [], color=sheet.ORANGE, marker="+", markersize=10, linestyle="none", label="axle"),
            Line2D([], [], color=sheet.ORANGE, linestyle="-.", label="bisector of the mask opening"),
        ]
    return entries


def histogram(evidence: Evidence) -> Figure:
    """Pixel values of the region of interest in open frames, the two peaks and the threshold between them."""
    found = evidence.recordings[0].opening.histogram
    with sheet.style():
        drawn = sheet.figure(height_in=2.7)
        if found is None:
            return drawn
        axes = drawn.add_subplot()
        axes.stairs(found.count, found.bin_edges_dn, fill=True, color=sheet.BLUE, alpha=0.45)
        axes.stairs(found.count, found.bin_edges_dn, color=sheet.BLUE, linewidth=0.8)
        axes.set_yscale("log")
        axes.set_ylim(0.5, 4 * float(found.count.max()))
        level = (found.threshold_dn - found.plate_dn) / (found.blackbody_dn - found.plate_dn)
        for value, text, colour in (
            (found.plate_dn, f"mask plate\n{found.plate_dn:.0f} DN", sheet.INK),
            (found.threshold_dn, f"threshold {found.threshold_dn:.0f} DN\n{level:.0%} of the step", sheet.RED),
            (found.blackbody_dn, f"blackbody\n{found.blackbody_dn:.0f} DN", sheet.INK),
        ):
            axes.axvline(value, color=colour, linewidth=1.1, linestyle="--")
            right = value < float(np.mean(found.bin_edges_dn[[0, -1]]))
            axes.annotate(
                text, (value, 0.97), xycoords=("data", "axes fraction"), xytext=(5 if right else -5, 0),
                textcoords="offset points", va="top", ha="left" if right else "right", color=colour, fontsize=8,
            )  # fmt: skip
        axes.set_xlabel("corrected value in the mean open frame (DN)")
        axes.set_ylabel("pixels (1)")
    return drawn
