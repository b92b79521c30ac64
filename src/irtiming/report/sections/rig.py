"""The rig as it was measured, and the model without any delay (Schatz 2023, figure 4)."""

import re
from typing import TYPE_CHECKING

import numpy as np

from irtiming.physics.wheel import TURN, corner_angles_rad, exposed_fraction, slope_centres_rad
from irtiming.physics.wheel_drawing import drawing
from irtiming.records.analysis import Analysis
from irtiming.records.arrays import Array
from irtiming.records.wheel_geometry import WheelModel
from irtiming.report import sheet
from irtiming.report.blocks import Panel, Section
from irtiming.report.language import decimal, t, with_numbers

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def _in_language(svg: str) -> str:
    """The drawing with its words and numbers in the language."""
    return re.sub(r">([^<>]*[^<>\s][^<>]*)<", lambda match: f">{with_numbers(match[1])}<", svg)


def section(analysis: Analysis) -> Section:
    """Figure 4 with the rig's own numbers."""
    geometry = analysis.geometry
    wheel = Panel(
        title=t("Wheel, mask opening and light beams"),
        caption=t(
            "The rig from the camera’s side, angles and beams to scale. Edge i passes the application beam at wheel "
            "angle αᵢ; θ grows with rotation and is zero when edge 0 is at the beam. The opening is uncovered where "
            "a cutout lies over it. A camera rolled about its axis turns this picture as a whole."
        ),
        svg=_in_language(
            drawing(
                geometry.model,
                geometry.gates,
                rotation=analysis.rig.wheel.rotation,
                control_slots=analysis.rig.wheel.control_slots,
            )
        ),
    )
    fraction = Panel(
        title=t("Model: exposed fraction without any delay"),
        caption=t(
            "Uncovered part of the mask opening over the wheel angle, from rig.toml and the timestamps alone. Blue: "
            "corners. Red: middle of each slope, where an edge passes the bisector of the opening."
        ),
        svg=sheet.svg(model(geometry.model), title=t("Model of the exposed fraction")),
    )
    return Section(title=t("Rig and model"), blocks=(wheel, fraction))


def model(wheel: WheelModel) -> "Figure":
    """Figure 4(b): exposed fraction without any delay, its corners and which edge makes each slope."""
    with sheet.style():
        drawn = sheet.figure(height_in=2.9)
        axes = drawn.add_subplot()
        angle = dense_rad(wheel)
        axes.plot(np.degrees(angle), exposed_fraction(angle, wheel), color=sheet.BLUE, linewidth=1.8)
        for edge, (start, end) in enumerate(corner_angles_rad(wheel)):
            falls = edge in (0, 2)
            _corner(axes, start, level=1.0 if falls else 0.0, starts=True)
            _corner(axes, end, level=0.0 if falls else 1.0, starts=False)
            _middle(axes, slope_centres_rad(wheel)[edge], edge)
        axes.set_ylim(-0.17, 1.17)
        axes.set_ylabel(t("exposed fraction (1)"))
        sheet.degrees_axis(axes, label=t("wheel angle (degrees)"))
    return drawn


def _corner(axes: "Axes", angle_rad: float, *, level: float, starts: bool) -> None:
    """Corner where a slope starts or ends, its angle written on the side of the plateau's outside."""
    angle = float(np.degrees(angle_rad % TURN))
    axes.plot([angle], [level], "o", color=sheet.BLUE, markersize=4, zorder=4)
    right = (starts or angle < 18) and angle < 335
    axes.annotate(
        decimal(f"{angle:.2f}°"), (angle, level), xytext=(-5 if right else 5, 6 if level else -6), textcoords="offset points",
        ha="left" if right else "right", va="bottom" if level else "top", fontsize=8,
    )  # fmt: skip


def _middle(axes: "Axes", angle_rad: float, edge: int) -> None:
    """Middle of a slope, with the edge that makes it."""
    angle, falls = float(np.degrees(angle_rad)), edge in (0, 2)
    axes.plot([angle], [0.5], "o", color=sheet.RED, markersize=4, zorder=4)
    right = angle < 300
    axes.annotate(
        t("edge {edge} covers\nat {angle:.2f}°", edge=edge, angle=angle) if falls
        else t("edge {edge} uncovers\nat {angle:.2f}°", edge=edge, angle=angle), (angle, 0.5),
        xytext=(7 if right else -7, 2 if falls == right else -2), textcoords="offset points",
        ha="left" if right else "right", va="bottom" if falls == right else "top", fontsize=8, color=sheet.RED,
    )  # fmt: skip


def dense_rad(wheel: WheelModel) -> Array:
    """Angles of a turn with the corners among them, shape (n,), rad."""
    corners = np.mod(corner_angles_rad(wheel).ravel(), TURN)
    return np.sort(np.concatenate([np.linspace(0, TURN, 721), corners]))
