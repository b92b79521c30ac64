"""Maps of every pixel's timing as a picture: images, histograms of pulls, means over rows and columns."""

import io
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from irtiming.records.arrays import Array
from irtiming.records.pixel_maps import LineMeans, PixelMaps
from irtiming.records.reduced import Region
from irtiming.report import sheet
from irtiming.report.rounding import in_unit, time_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Drawn: TypeAlias = "Axes"
"""Axes of matplotlib, for those who may not load it."""

_UNITS = {"_s": (1e6, "µs"), "_dn": (1.0, "DN")}
_SIGNED = ("deviation_s",)
_FEWEST = 8  # pixels of a row or column whose mean is shown
_TITLES = {
    "delay_s": "Delay", "u_delay_s": "Its standard uncertainty by noise", "deviation_s": "Delay less the fit",
    "u_shape_s": "What errors of the shape add, shared by all", "time_constant_s": "Time constant",
    "u_time_constant_s": "Its standard uncertainty by noise", "correlation": "Correlation of delay and time constant",
    "contrast_dn": "Contrast", "u_contrast_dn": "Its standard uncertainty by noise", "noise_dn": "Noise of a frame",
}  # fmt: skip


def draw(name: str, image: Array, *, roi: Region, axes: "Axes | None" = None) -> "Axes":
    """One map with its scale, over all but the rarest values, in axes of its own if none are given.

    Parameters
    ----------
    name
        Of the map, which ends in its unit.
    image, roi
        Shape (roi rows, roi columns), and where in the image it lies.
    axes
        Where to draw.
    """
    factor, unit = next((one for end, one in _UNITS.items() if name.endswith(end)), (1.0, ""))
    with sheet.style():
        if axes is None:
            axes = sheet.figure(height_in=4.0, width_in=6.0).add_subplot()
        shown = factor * image
        low, high = (float(v) for v in np.nanquantile(shown, [0.005, 0.995]))
        if name in _SIGNED:
            low, high = -max(abs(low), abs(high)), max(abs(low), abs(high))
        places = (roi[2] - 0.5, roi[3] - 0.5, roi[1] - 0.5, roi[0] - 0.5)
        colours = axes.imshow(
            shown,
            extent=places,
            vmin=low,
            vmax=high,
            cmap="RdBu_r" if name in _SIGNED else "viridis",
            interpolation="nearest",
        )
        axes.figure.colorbar(colours, ax=axes, shrink=0.8, pad=0.02, label=unit)
        axes.set_title(_TITLES.get(name, name))
        axes.set_xlabel("column (px)")
        axes.set_ylabel("row (px)")
        axes.grid(visible=False)
    return axes


def figure(maps: PixelMaps) -> "Figure":
    """Deviation, delay, contrast and time constant or noise; histograms of their pulls; means over rows and columns.

    Parameters
    ----------
    maps
        Of one camera.
    """
    lags = maps.time_constant_s is not None
    names = ("delay_s", "deviation_s", "time_constant_s" if lags else "noise_dn", "contrast_dn")
    with sheet.style():
        drawn = sheet.figure(height_in=8.8, width_in=11.0)
        panels = drawn.subplots(3, 4, width_ratios=[1.7, 1, 1.7, 1])
        for k, name in enumerate(names):
            image, beside = panels[k // 2, 2 * (k % 2) : 2 * (k % 2) + 2]
            draw(name, maps.images[name], roi=maps.roi, axes=image)
            image.set_xlim(*_columns(maps))
            image.set_ylim(*_rows(maps))
            _histogram(beside, name, maps)
        for panel in panels[2]:
            panel.remove()
        grid = panels[0, 0].get_gridspec()
        for k, (axis, means) in enumerate((("row", maps.rows), ("column", maps.columns))):
            _means(drawn.add_subplot(grid[2, 2 * k : 2 * k + 2]), means, axis=axis)
        drawn.suptitle(_heading(maps), x=0.01, ha="left", fontsize=9)
    return drawn


def png(maps: PixelMaps) -> bytes:
    """The figure as a picture."""
    made = io.BytesIO()
    figure(maps).savefig(made, format="png", dpi=130, metadata={"Software": None})
    return made.getvalue()


def _columns(maps: PixelMaps) -> tuple[float, float]:
    """Limits of an image that shows the pixels with values."""
    columns = maps.roi[2] + np.flatnonzero(np.isfinite(maps.delay_s).any(axis=0))
    return float(columns[0]) - 1.5, float(columns[-1]) + 1.5


def _rows(maps: PixelMaps) -> tuple[float, float]:
    """The same from below."""
    rows = maps.roi[0] + np.flatnonzero(np.isfinite(maps.delay_s).any(axis=1))
    return float(rows[-1]) + 1.5, float(rows[0]) - 1.5


def _heading(maps: PixelMaps) -> str:
    fitted = in_unit(maps.fitted_row_delay_s, maps.u_row_delay_s, unit_s=1e-6)
    rows = f"row delay by the map {time_text(maps.row_delay_s, maps.u_row_delay_s)}, by the fit {fitted} µs"
    strays = f"{int(maps.is_deviating.sum())} deviate, {int(maps.is_dead.sum())} dead"
    return f"{maps.delay_name.replace('_', ' ').capitalize()} of {maps.n_pixels} pixels ({strays}); {rows}"


def _histogram(axes: "Axes", name: str, maps: PixelMaps) -> None:
    """Of a map: of deviations over their standard uncertainties with the normal curve, of others of the values."""
    image, u = maps.images[name], maps.images.get(f"u_{name}")
    if name == "deviation_s":
        u = maps.u_delay_s
    inside = np.isfinite(image) & ~maps.is_border
    if name in ("deviation_s", "time_constant_s") and u is not None:
        values = image[inside] - np.average(image[inside], weights=1 / u[inside] ** 2)
        pulls = values / u[inside]
        axes.hist(np.clip(pulls, -5, 5), bins=50, range=(-5, 5), color=sheet.BLUE, density=True)
        at = np.linspace(-5, 5, 201)
        axes.plot(at, np.exp(-(at**2) / 2) / np.sqrt(2 * np.pi), color=sheet.RED, linewidth=1.0)
        axes.set_xlabel(f"over u: spread {pulls.std():.2f}")
    else:
        factor, unit = next((one for end, one in _UNITS.items() if name.endswith(end)), (1.0, ""))
        low, high = np.quantile(image[inside], [0.002, 0.998])
        axes.hist(factor * np.clip(image[inside], low, high), bins=50, color=sheet.BLUE)
        axes.set_xlabel(f"{_TITLES[name].lower()} ({unit})")
    axes.set_yticks([])


def _means(axes: "Axes", means: LineMeans, *, axis: str) -> None:
    many = means.n_pixels >= _FEWEST
    axes.errorbar(
        means.line_px[many], 1e6 * means.deviation_s[many], 1e6 * means.u_delay_s[many], fmt=".", color=sheet.BLUE,
        ecolor=sheet.FAINT, elinewidth=0.6, markersize=4,
    )  # fmt: skip
    sheet.zero_line(axes)
    axes.set_xlabel(f"{axis} (px)")
    axes.set_ylabel("µs")
    axes.set_title(f"Delay less the fit, mean over each {axis}")
