"""A frame in which an edge crosses the opening, and the bend that the rolling readout gives it."""

from typing import TYPE_CHECKING

import numpy as np

from irtiming.physics.wheel import TURN
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.analysis import Analysis
from irtiming.records.arrays import Array
from irtiming.records.row_timing import RowTimingFit
from irtiming.report import sheet
from irtiming.report.language import t

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw(axes: "Axes", analysis: Analysis, *, marked: dict[int, str]) -> None:
    """The frame, the edge as read row by row and as a snapshot would show it, and lines at the marked rows.

    Parameters
    ----------
    axes
        To draw in.
    analysis
        Its first recording.
    marked
        Colours of image rows.
    """
    recording, fit = analysis.recordings[0], analysis.fits[0]
    if recording.rows is None or not isinstance(fit, RowTimingFit):
        return
    place = recording.rows.edge_frame
    at = recording.trigger_ticks[place : place + 1]
    angle = float(
        np.mod(wheel_angle_rad(0.0, recording.track, at_ticks=at, set_s=recording.trigger_delay_time_set_s)[0], TURN)
    )
    frame = recording.rows.edge_frame_dn
    row0, row1, column0, column1 = recording.opening.roi
    low, high = (float(v) for v in np.quantile(frame[row0:row1, column0:column1], [0.01, 0.99]))
    axes.imshow(frame, cmap="gray", vmin=low, vmax=high, interpolation="nearest")
    for marked_row, hue in marked.items():
        axes.axhline(marked_row, color=hue, linewidth=1)
    for rolling, line in ((True, "-"), (False, "--"))[: 2 if fit.row_delay_s else 1]:
        for row, column in edges(analysis, fit, wheel_angle_rad=angle, rolling=rolling):
            axes.plot(column, row, line, color=sheet.RED if rolling else "#ffd23f", linewidth=1.2)
    axes.set_xlim(column0 - 0.5, column1 - 0.5)
    axes.set_ylim(row1 - 0.5, row0 - 0.5)
    axes.set_xlabel(t("column (px)"))
    axes.set_ylabel(t("row (px)"))
    axes.grid(visible=False)
    axes.set_title(
        t(
            "(b) frame {frame}, wheel at {angle:.1f}°",
            frame=recording.frame_index[place],
            angle=np.degrees(angle),
        )
    )


def edges(analysis: Analysis, fit: RowTimingFit, *, wheel_angle_rad: float, rolling: bool) -> list[tuple[Array, Array]]:
    """Rows and columns (px), shapes (n,), of each wheel edge within the opening where its pixels are half way.

    Without ``rolling`` all rows are read together with the middle one: then an edge is straight.
    """
    shape, model = analysis.sectors[0].shape, analysis.geometry.model
    omega, middle = fit.angular_frequency_rad_per_s, float(fit.row_px.mean())
    row = np.linspace(float(fit.row_px[0]), float(fit.row_px[-1]), 200)
    read_s = fit.row_delay_s * (row if rolling else np.full(row.size, middle)) - np.log(2) * fit.timing.get(
        "time_constant", 0.0
    )
    found = []
    for edge, delay in zip(model.cutout_edges_rad, fit.edge_delay_s, strict=True):
        polar = wheel_angle_rad + omega * (delay + read_s) + model.opening_coordinate_rad - edge
        polar = np.mod(polar + np.pi, 2 * np.pi) - np.pi
        direction = polar + shape.bisector_rad
        radius = (row - shape.axle_row_px) / np.sin(direction)
        column = shape.axle_column_px + shape.sense * radius * np.cos(direction)
        inside = (np.abs(polar) < shape.opening_angle_rad / 2) & (radius > shape.inner_radius_px)
        inside &= radius < shape.outer_radius_px
        if inside.any():
            found.append((row[inside], column[inside]))
    return found
