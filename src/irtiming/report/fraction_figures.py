"""Exposed fraction over the wheel angle: the model (figure 4b), the user's figure 5, and the fits with residuals."""

from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from irtiming.physics.wheel import TURN, corner_angles_rad, exposed_fraction, slope_centres_rad
from irtiming.records.arrays import Array
from irtiming.records.estimate import EdgeDelayFit, PublishedFit, SlopeLine
from irtiming.records.wheel_geometry import WheelModel
from irtiming.report import sheet
from irtiming.report.evidence import Evidence, WheelEvidence

_MOST_PANELS = 8
_BINS = 60


def model(evidence: WheelEvidence) -> Figure:
    """Figure 4(b): exposed fraction without any delay, its corners and which edge makes each slope."""
    wheel = evidence.geometry.model
    with sheet.style():
        drawn = sheet.figure(height_in=2.9)
        axes = drawn.add_subplot()
        angle = _dense(wheel)
        axes.plot(np.degrees(angle), exposed_fraction(angle, wheel), color=sheet.BLUE, linewidth=1.8)
        for edge, (start, end) in enumerate(corner_angles_rad(wheel)):
            falls = edge in (0, 2)
            _corner(axes, start, level=1.0 if falls else 0.0, starts=True)
            _corner(axes, end, level=0.0 if falls else 1.0, starts=False)
            _middle(axes, slope_centres_rad(wheel)[edge], edge)
        axes.set_ylim(-0.17, 1.17)
        axes.set_ylabel("exposed fraction (1)")
        sheet.degrees_axis(axes, label="wheel angle (degrees)")
    return drawn


def _corner(axes: Axes, angle_rad: float, *, level: float, starts: bool) -> None:
    """Corner where a slope starts or ends, its angle written on the side of the plateau's outside."""
    angle = float(np.degrees(angle_rad % TURN))
    axes.plot([angle], [level], "o", color=sheet.BLUE, markersize=4, zorder=4)
    right = (starts or angle < 18) and angle < 335
    axes.annotate(
        f"{angle:.2f}°", (angle, level), xytext=(-5 if right else 5, 6 if level else -6), textcoords="offset points",
        ha="left" if right else "right", va="bottom" if level else "top", fontsize=8,
    )  # fmt: skip


def _middle(axes: Axes, angle_rad: float, edge: int) -> None:
    """Middle of a slope, with the edge that makes it."""
    angle, falls = float(np.degrees(angle_rad)), edge in (0, 2)
    axes.plot([angle], [0.5], "o", color=sheet.RED, markersize=4, zorder=4)
    right = angle < 300
    axes.annotate(
        f"edge {edge} {'covers' if falls else 'uncovers'}\nat {angle:.2f}°", (angle, 0.5),
        xytext=(7 if right else -7, 2 if falls == right else -2), textcoords="offset points",
        ha="left" if right else "right", va="bottom" if falls == right else "top", fontsize=8, color=sheet.RED,
    )  # fmt: skip


def _dense(wheel: WheelModel) -> Array:
    """Angles of a turn with the corners among them, rad."""
    corners = np.mod(corner_angles_rad(wheel).ravel(), TURN)
    return np.sort(np.concatenate([np.linspace(0, TURN, 721), corners]))


def averaged(evidence: Evidence) -> Figure:
    """Figure 5 for the user's camera, with the lines through the slopes and what they leave over."""
    fits = evidence.published_fits
    names = sheet.run_names(
        [fit.data.trigger_delay_time_set_s for fit in fits], [fit.data.rotation_speed_hz for fit in fits]
    )
    hues = sheet.colours(names)
    with sheet.style():
        drawn = sheet.figure(height_in=5.4)
        top, below = drawn.subplots(2, 1, sharex=True, height_ratios=[2.4, 1.2])
        wheel = evidence.equal_geometry.model
        angle = _dense(wheel)
        top.plot(
            np.degrees(angle),
            exposed_fraction(angle, wheel),
            "--",
            color=sheet.INK,
            linewidth=1,
            label="model, no delay",
        )
        for fit, name, hue in zip(fits, names, hues, strict=True):
            _averaged_points(top, fit, name, hue)
            for line in fit.lines:
                _line_and_rest(top, below, line, hue)
        sheet.robust_limits(below, [np.asarray(line.get_ydata(), dtype=float) for line in below.get_lines()])
        top.set_ylabel("exposed fraction (1)")
        top.set_ylim(-0.06, 1.06)
        drawn.legend(loc="outside upper center", ncols=min(6, len(fits) + 1), markerscale=3, columnspacing=1.4)
        sheet.degrees_axis(top, label=None)
        sheet.zero_line(below)
        below.set_ylabel("points − line\n(10⁻³ of the step)")
        sheet.degrees_axis(below, label="wheel angle at the trigger (degrees)")
    return drawn


def _averaged_points(axes: Axes, fit: PublishedFit, name: str, hue: str) -> None:
    data = fit.data
    runs = "1 run" if len(data.names) == 1 else f"{len(data.names)} runs"
    label = f"{name}, {runs}"
    sheet.points(axes, x=np.degrees(data.wheel_angle_rad), y=data.fraction, colour=hue, label=label)
    if data.u_wheel_angle_rad is not None and data.u_fraction is not None:
        axes.errorbar(
            np.degrees(data.wheel_angle_rad), data.fraction, xerr=np.degrees(data.u_wheel_angle_rad),
            yerr=data.u_fraction, fmt="none", ecolor=hue, elinewidth=0.5, rasterized=True,
        )  # fmt: skip


def _line_and_rest(top: Axes, below: Axes, line: SlopeLine, hue: str) -> None:
    """The fitted line, broken where it leaves the turn, and the points minus the line."""
    x = np.sort(line.angle_rad)
    for turn in np.unique(np.floor(x / TURN)):
        part = x[np.floor(x / TURN) == turn]
        height = 0.5 + line.slope_per_rad * (part - line.centre_rad)
        top.plot(np.degrees(part - turn * TURN), height, color=hue, linewidth=0.9)
    rest = line.fraction - 0.5 - line.slope_per_rad * (line.angle_rad - line.centre_rad)
    sheet.points(below, x=np.degrees(np.mod(line.angle_rad, TURN)), y=1e3 * rest, colour=hue)


def fitted(evidence: Evidence) -> Figure:
    """Pixel sums with the fitted model; below, what it leaves over per nominal delay, with its distribution."""
    groups = _groups(evidence)
    shown = groups[:_MOST_PANELS]
    names = sheet.run_names([delay for (_, delay), _ in groups], [speed for (speed, _), _ in groups])
    hues = sheet.colours(names)
    with sheet.style():
        drawn = sheet.figure(height_in=2.5 + 1.0 * len(shown))
        grid = drawn.add_gridspec(1 + len(shown), 2, width_ratios=[6, 1], height_ratios=[2.3] + [1.0] * len(shown))
        top = drawn.add_subplot(grid[0, 0])
        for (_, fits), name, hue in zip(groups, names, hues, strict=True):
            _fitted_points(top, fits, name, hue)
        top.plot([], [], color=sheet.RED, linewidth=1, label="fitted model")
        beside = drawn.add_subplot(grid[0, 1])
        beside.set_axis_off()
        beside.legend(*top.get_legend_handles_labels(), loc="center left", bbox_to_anchor=(-0.3, 0.5), markerscale=3)
        top.set_ylabel("exposed fraction (1)")
        top.set_ylim(-0.06, 1.06)
        sheet.degrees_axis(top, label=None)
        largest = max(float(np.max(np.abs(fit.residual))) for _, fits in shown for fit in fits)
        for row, ((_, fits), name, hue) in enumerate(zip(shown, names, hues, strict=False), start=1):
            last = row == len(shown)
            rest, beside = drawn.add_subplot(grid[row, 0]), drawn.add_subplot(grid[row, 1])
            _rest(rest, fits, name, hue)
            sheet.degrees_axis(rest, label="wheel angle at the start of integration (degrees)" if last else None)
            _spread(beside, fits, hue)
            beside.set_xlabel("frames (1)" if last else "")
            for axes in (rest, beside):
                axes.set_ylim(-1.1e3 * largest, 1.1e3 * largest)
    return drawn


def _groups(evidence: Evidence) -> list[tuple[tuple[float, float], list[EdgeDelayFit]]]:
    """Fits of the same wheel speed and nominal delay, in order."""
    fits = list(evidence.edge_fits)
    speeds = [round(recording.rotation_speed_hz, 6) for recording in evidence.recordings]
    keyed = [((s, round(f.trigger_delay_time_set_s, 9)), f) for s, f in zip(speeds, fits, strict=True)]
    return [(key, [f for _, f in part]) for key, part in groupby(sorted(keyed, key=_key), key=_key)]


def _key(entry: tuple[tuple[float, float], EdgeDelayFit]) -> tuple[float, float]:
    return entry[0]


def _fitted_points(axes: Axes, fits: list[EdgeDelayFit], name: str, hue: str) -> None:
    angle = np.concatenate([fit.wheel_angle_rad for fit in fits])
    fraction = np.concatenate([fit.fraction for fit in fits])
    sheet.points(axes, x=np.degrees(angle), y=fraction, colour=hue, label=name)
    one = fits[0]
    axes.plot(np.degrees(one.wheel_angle_rad), one.fraction - one.residual, color=sheet.RED, linewidth=0.7, zorder=3)


def _rest(axes: Axes, fits: list[EdgeDelayFit], name: str, hue: str) -> None:
    angle = np.concatenate([fit.wheel_angle_rad for fit in fits])
    rest = 1e3 * np.concatenate([fit.residual for fit in fits])
    sheet.zero_line(axes)
    sheet.points(axes, x=np.degrees(angle), y=rest, colour=hue)
    place = np.minimum((angle / TURN * _BINS).astype(int), _BINS - 1)
    count = np.bincount(place, minlength=_BINS)
    mean = np.bincount(place, rest, _BINS) / np.maximum(count, 1)
    filled = count > 0
    axes.plot(((np.arange(_BINS) + 0.5) * 360 / _BINS)[filled], mean[filled], color=sheet.RED, linewidth=1)
    axes.set_ylabel("sums − model\n(10⁻³ of step)", fontsize=7.5)
    noise = 1e3 * float(np.sqrt(np.mean([fit.noise**2 for fit in fits])))
    runs = "" if len(fits) == 1 else f", {len(fits)} runs"
    widening = max(fit.widening for fit in fits)
    axes.set_title(
        f"{name}{runs}: standard deviation {noise:.2f}·10⁻³, "
        f"widening for correlation {widening**0.5:.2f}",
        fontsize=8, fontweight="normal", color=hue, pad=2,
    )  # fmt: skip


def _spread(axes: Axes, fits: list[EdgeDelayFit], hue: str) -> None:
    """Distribution of the residuals beside a normal one of the same spread."""
    rest = 1e3 * np.concatenate([fit.residual for fit in fits])
    spread = float(rest.std())
    _, bins, _ = axes.hist(rest, bins=31, orientation="horizontal", color=hue, alpha=0.5)
    level = np.linspace(bins[0], bins[-1], 200)
    density = np.exp(-0.5 * (level / spread) ** 2) / (spread * np.sqrt(2 * np.pi))
    axes.plot(density * rest.size * (bins[1] - bins[0]), level, color=sheet.INK, linewidth=0.8)
    axes.tick_params(labelleft=False)
