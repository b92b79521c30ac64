"""What a rolling camera saw of the opening: open frame with the fitted sector, mask, contrast, and what the sector leaves."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from irtiming.physics.lens import Lens
from irtiming.records.arrays import Array
from irtiming.records.row_timing import SectorShape
from irtiming.report import sheet
from irtiming.report.evidence import RollingEvidence
from irtiming.report.image_figures import picture

_SUM, _OUTLINE, _SECTOR, _BAD = "#ffd23f", "#35c4f0", "#ff4d4d", "#b86bff"


def opening(evidence: RollingEvidence) -> Figure:
    """Mean open frame with the sector, open minus covered with the masks; contrast, and its parts."""
    sector = evidence.sector
    with sheet.style():
        drawn = sheet.figure(height_in=9.2)
        frame, masks, contrast, *below = drawn.subplots(3, 2).ravel()
        _frame(frame, evidence)
        _masks(masks, evidence)
        box = sector.roi
        extent = (box[2] - 0.5, box[3] - 0.5, box[1] - 0.5, box[0] - 0.5)
        _map(contrast, sector.contrast, extent, None, "contrast (1)")
        contrast.set_title("Contrast of each pixel, from all frames")
        beyond = sector.contrast - sector.model_contrast
        for axes, values, title in zip(
            below,
            (sector.model_contrast, beyond, sector.excess),
            ("Contrast of the fitted sector", "Measured minus sector", "Excess: what nothing in the model explains"),
            strict=True,
        ):
            spread = None if values is sector.model_contrast else max(float(np.quantile(np.abs(values), 0.995)), 1e-3)
            _map(axes, values, extent, spread, "contrast (1)")
            axes.set_title(title)
        for axes in (frame, masks, contrast, *below):
            axes.set_xlabel("column (px)")
            axes.set_ylabel("row (px)")
            axes.grid(visible=False)
    return drawn


def _frame(axes: Axes, evidence: RollingEvidence) -> None:
    found = evidence.recordings[0].opening
    picture(axes, found.open_frame_dn, label="value (DN)", shrink=0.8)
    axes.set_title("Mean open frame, fitted sector")
    _sector(axes, evidence.sector.shape, found.open_frame_dn.shape)


def _masks(axes: Axes, evidence: RollingEvidence) -> None:
    found, box = evidence.recordings[0].opening, evidence.sector.roi
    picture(axes, found.open_frame_dn - found.covered_frame_dn, label="open − covered (DN)", shrink=0.8)
    axes.set_title(f"Open minus covered; summed with a border of {found.border_px} px")
    axes.contour(found.summed.astype(float), levels=[0.5], colors=_SUM, linewidths=1.3)
    axes.contour(found.mask.astype(float), levels=[0.5], colors=_OUTLINE, linewidths=1.3)
    bad_row, bad_column = np.nonzero(found.bad & found.summed)
    axes.plot(bad_column, bad_row, "s", color=_BAD, markersize=2.5, markeredgewidth=0)
    axes.set_xlim(box[2] - 0.5, box[3] - 0.5)
    axes.set_ylim(box[1] - 0.5, box[0] - 0.5)


def _map(
    axes: Axes, values: Array, extent: tuple[float, float, float, float], spread: float | None, label: str
) -> None:  # fmt: skip
    """Picture of contrasts: grey from covered to open, or red and blue to both sides of zero up to ``spread``."""
    low, high = (-0.05, 1.1) if spread is None else (-spread, spread)
    shades = axes.imshow(
        values, cmap="gray" if spread is None else "RdBu_r", vmin=low, vmax=high, interpolation="nearest", extent=extent
    )
    axes.figure.colorbar(shades, ax=axes, label=label, shrink=0.8, pad=0.02)


def _sector(axes: Axes, shape: SectorShape, size: tuple[int, ...]) -> None:
    """Arcs and radial edges of the fitted sector, axle and bisector, in the image."""
    sense = -1.0 if shape.mirrored else 1.0
    lens = Lens(distortion=shape.distortion, rows=shape.image_rows, columns=shape.image_columns)
    axle_row, axle_column = lens.flat(shape.axle_row_px, shape.axle_column_px)
    row, column = axle_row + shape.offset_row_px, axle_column + sense * shape.offset_column_px
    half = shape.opening_angle_rad / 2
    around = shape.bisector_rad + np.linspace(-half, half, 100)
    polar = np.concatenate([around, around[::-1], around[:1]])
    radius = np.repeat([shape.outer_radius_px, shape.inner_radius_px, shape.outer_radius_px], [100, 100, 1])
    border = lens.seen(row + radius * np.sin(polar), column + sense * radius * np.cos(polar))
    axes.plot(border[1], border[0], color=_SECTOR, linewidth=1.2)
    reach = np.linspace(0.0, 1.15 * shape.outer_radius_px, 50)
    middle = lens.seen(
        axle_row + reach * np.sin(shape.bisector_rad), axle_column + sense * reach * np.cos(shape.bisector_rad)
    )
    axes.plot(middle[1], middle[0], "-.", color=sheet.ORANGE, linewidth=1)
    axes.plot([shape.axle_column_px], [shape.axle_row_px], "+", color=sheet.ORANGE, markersize=12, markeredgewidth=1.8)
    axes.set_xlim(min(-0.5, shape.axle_column_px - 3), max(size[1] - 0.5, shape.axle_column_px + 3))
    axes.set_ylim(max(size[0] - 0.5, shape.axle_row_px + 3), min(-0.5, shape.axle_row_px - 3))
