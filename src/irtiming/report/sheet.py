"""The look of all figures, and how a figure becomes SVG text inside a page.

Figures are made with matplotlib's objects alone, no global state of pyplot; letters become paths and pictures are
embedded, so that the text holds no link to anything outside. Who draws no figure does not wait for matplotlib either.
"""

import io
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from irtiming.records.arrays import Array
from irtiming.report.language import language, t

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, FAINT, GRID = "#1d2733", "#7a8794", "#e3e8ee"
BLUE, RED, GREEN, PURPLE, ORANGE = "#1f5fa8", "#c0271d", "#1d7a3a", "#7b3fa0", "#d98200"
SERIES = ("#0b3c6f", "#2f7ec2", "#2f9e6e", "#d98200", "#b5306f", "#6a4fb3", "#7d6a52", "#4a9aa8")
"""One colour per nominal delay, in order; distinguished by colour-blind readers too."""

_MANY_POINTS = 600  # beyond, the points of a panel are embedded as a picture
_SVG_DPI = 72  # points, in which an SVG file counts
_STYLE: Any = {
    "font.family": "DejaVu Sans", "font.size": 8.5, "axes.titlesize": 9.5, "axes.titlelocation": "left",
    "axes.titleweight": "bold", "axes.edgecolor": FAINT, "axes.labelcolor": INK, "axes.linewidth": 0.7,
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "axes.axisbelow": True,
    "grid.color": GRID, "grid.linewidth": 0.7, "xtick.color": INK, "ytick.color": INK, "text.color": INK,
    "xtick.major.width": 0.7, "ytick.major.width": 0.7, "legend.frameon": False, "legend.fontsize": 8,
    "figure.facecolor": "white", "svg.fonttype": "path", "axes.unicode_minus": True,
}  # fmt: skip


def style() -> Any:
    """Context in which figures are made: house style, restored at its end."""
    import matplotlib as mpl

    return mpl.rc_context(_STYLE)


def figure(*, height_in: float, width_in: float = 9.6) -> "Figure":
    """Empty figure whose axes keep clear of each other."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width_in, height_in), layout="constrained")


def svg(drawn: "Figure", *, title: str) -> str:
    """SVG element with its own names, fit to stand inside an HTML page beside others.

    Parameters
    ----------
    drawn
        Figure.
    title
        What a reader who does not look at the figure gets; also makes the names inside unique.
    """
    import matplotlib as mpl

    text = io.StringIO()
    if language() != "en":
        _numbers_in_language(drawn)
    nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
    with mpl.rc_context(_STYLE | {"svg.hashsalt": title}):
        _laid_out(drawn)
        drawn.savefig(text, format="svg", metadata=nothing, dpi=220)
    body = text.getvalue()
    body = body[body.index("<svg") :]
    body = re.sub(r"<defs>\s*<style.*?</style>\s*</defs>", "", body, count=1, flags=re.DOTALL)
    label = title.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
    body = re.sub(r' (?:width|height)="[\d.]+pt"', "", body, count=2)
    return body.replace("<svg", f'<svg role="img" aria-label="{label}" style="stroke-linejoin:round"', 1)


def _laid_out(drawn: "Figure") -> None:
    """Give axes their places, with letters measured as SVG has them; writing a figure without draws it a second time for that."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    layout = drawn.get_layout_engine()
    if layout is not None:
        FigureCanvasSVG(drawn)
        drawn.dpi = _SVG_DPI
        layout.execute(drawn)
        drawn.set_layout_engine(None)


def _numbers_in_language(drawn: "Figure") -> None:
    """Give the numbers at every axis the decimal mark of the language."""
    from irtiming.report.localised_ticks import Localised

    for axes in drawn.axes:
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter(Localised(axis.get_major_formatter()))


def points(axes: "Axes", *, x: Array, y: Array, colour: str, label: str | None = None) -> None:
    """Small points, shapes (n,); as a picture where there are very many."""
    axes.plot(
        x, y, ".", color=colour, markersize=2.2, markeredgewidth=0, label=label, rasterized=np.size(x) > _MANY_POINTS
    )


def degrees_axis(axes: "Axes", *, label: str | None) -> None:
    """Abscissa of a whole turn in degrees."""
    axes.set_xlim(0, 360)
    axes.set_xticks(range(0, 361, 45))
    axes.tick_params(labelbottom=label is not None)
    if label is not None:
        axes.set_xlabel(label)


def zero_line(axes: "Axes") -> None:
    """Horizontal line at zero, behind the points."""
    axes.axhline(0, color=FAINT, linewidth=0.8, zorder=1)


def robust_limits(axes: "Axes", values: Sequence[Array], *, least: float = 0.0) -> None:
    """Ordinate symmetric about zero that holds all values, of any shape, with some air."""
    largest = max((float(np.max(np.abs(v))) for v in values if np.size(v)), default=0.0)
    largest = max(1.15 * largest, least, 1e-12)
    axes.set_ylim(-largest, largest)


def run_names(delays_s: Sequence[float], speeds_hz: Sequence[float]) -> list[str]:
    """What to call measurements of these set delays; with the wheel speed where there are several."""
    several = len({round(speed, 6) for speed in speeds_hz}) > 1
    return [
        t("{delay:g} ms set", delay=1e3 * delay) + (t(", {speed:g} Hz", speed=speed) if several else "")
        for delay, speed in zip(delays_s, speeds_hz, strict=True)
    ]


def colours(keys: Sequence[object]) -> list[str]:
    """A colour for each of the keys, the same for equal ones, in order of appearance."""
    order = list(dict.fromkeys(keys))
    return [SERIES[order.index(key) % len(SERIES)] for key in keys]
