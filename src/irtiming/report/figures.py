"""All figures of the report in the order of the argument, each with a caption that says what one sees."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.physics.wheel_drawing import drawing
from irtiming.records.wheel_calibration import WheelCalibration
from irtiming.report import delay_figures, fraction_figures, image_figures, sheet, wheel_figures
from irtiming.report.evidence import Evidence, WheelEvidence
from irtiming.report.rounding import uncertainty_text


@final
@dataclass(frozen=True, kw_only=True)
class Panel:
    """A figure as SVG text that stands alone, its title and its caption."""

    title: str
    caption: str
    svg: str


def wheel(evidence: WheelEvidence) -> Panel:
    """Figure 4(a) with the rig's own numbers."""
    return Panel(
        title="Wheel, mask opening and light beams",
        caption="The rig as the camera sees it, angles and beams to scale. Edge i passes the application beam at wheel angle "
        "αᵢ; θ grows with rotation and is zero when edge 0 is at the beam. The opening is uncovered where a cutout lies "
        "over it. A camera rolled about its axis turns this picture as a whole.",
        svg=drawing(evidence.geometry.model, evidence.geometry.gates, rotation=evidence.rig.wheel.rotation),
    )


def model(evidence: WheelEvidence) -> Panel:
    """Figure 4(b)."""
    return Panel(
        title="Model: exposed fraction without any delay",
        caption="Uncovered part of the mask opening over the wheel angle, from rig.toml and the timestamps alone. Blue: corners. "
        "Red: middle of each slope, where an edge passes the bisector of the opening.",
        svg=sheet.svg(fraction_figures.model(evidence), title="Model of the exposed fraction"),
    )


def averaged(evidence: Evidence) -> Panel:
    """Figure 5."""
    bars = any(fit.data.u_fraction is not None for fit in evidence.published_fits)
    scatter = "Error bars are standard uncertainties from the scatter over runs, mostly smaller than the points. "
    return Panel(
        title="Exposed fraction over the wheel angle at the trigger",
        caption="Counts above the threshold, normalised to the plateaus, as in figure 5 of Schatz 2023. A larger delay shifts "
        "the curve to the left: the same state of the wheel is seen in frames that were triggered earlier. Dashed: the "
        f"model without any delay. {scatter if bars else ''}Below: what the four straight lines leave over.",
        svg=sheet.svg(fraction_figures.averaged(evidence), title="Exposed fraction over wheel angle at the trigger"),
    )


def fitted(evidence: Evidence) -> Panel:
    """The fit of the default method."""
    noise = 1e3 * float(np.sqrt(np.mean([fit.noise**2 for fit in evidence.edge_fits])))
    return Panel(
        title="Pixel sums and fitted model",
        caption="Pixel sums over the opening with its whole blurred border, over the wheel angle at the start of integration: "
        "the delay is taken out, so that all nominal delays fall on one curve. Below: what the fit leaves over, "
        f"{noise:.2f}·10⁻³ of the step (standard deviation); red, its mean over 6°. A fit that is right leaves noise without "
        "structure. Right: its distribution beside a normal one.",
        svg=sheet.svg(fraction_figures.fitted(evidence), title="Pixel sums and fitted model with residuals"),
    )


def mean_frames(evidence: Evidence) -> Panel:
    """What was found in the frames."""
    others = len(evidence.recordings) - 1
    more = f" The other recording{'s share' if others > 1 else ' shares'} this region." if others else ""
    return Panel(
        title="The mask opening as the camera sees it",
        caption="Left: mean frame with the wheel open. Right: open minus covered. The summed region holds the opening with its "
        "blurred border: cut at half contrast it would lose light. The axle follows from when each pixel is covered, the "
        f"bisector from the mask’s two straight edges.{more}",
        svg=sheet.svg(image_figures.mean_frames(evidence), title="Mean frame with region of interest and opening"),
    )


def histogram(evidence: Evidence) -> Panel:
    """Histogram with threshold."""
    return Panel(
        title="Histogram and threshold",
        caption="Corrected pixel values in the region of interest. The threshold serves the published method only; the pixel "
        "sums need none.",
        svg=sheet.svg(image_figures.histogram(evidence), title="Histogram of the region of interest with threshold"),
    )


def speed(evidence: WheelEvidence) -> Panel:
    """Speed of the wheel."""
    return Panel(
        title="Speed of the wheel",
        caption="Mean rate of each turn, from the control slots’ timestamps, relative to the nominal one. Wheel angles are "
        "interpolated between the slots, so that slow wander does no harm.",
        svg=sheet.svg(wheel_figures.speed(evidence), title="Speed of the wheel over time"),
    )


def slots(evidence: WheelEvidence) -> Panel:
    """Learned slot table."""
    return Panel(
        title="Irregularity of the control slots",
        caption=slots_caption(evidence.wheel),
        svg=sheet.svg(wheel_figures.slots(evidence), title="Deviation of the control slots, and its orders"),
    )


def slots_caption(wheel: WheelCalibration | None) -> str:
    """What the figure of the slots shows."""
    if wheel is None:
        return "Too few turns were recorded to learn the slots: they are taken as equal."
    told = (
        "Above: angle of each slot minus its regular place, from all recordings together. The default method corrects for it, "
        "the published one takes the slots as equal. Below: the same as waves around the wheel; order 1 is eccentricity. "
    )
    if wheel.ripple is None:
        return told + (
            "A speed ripple that repeats every turn is in it: no order can be told from such a ripple at a single wheel speed, "
            "the low ones least. Recordings at another speed separate them."
        )
    return told + (
        "Orange: speed ripple that repeats every turn, told from the slots by its fall with the square of the speed, at the "
        f"slowest speed; pale where it may be chance. All orders together are chance with probability {wheel.ripple.chance:.1g}."
    )


def by_edge(evidence: Evidence) -> Panel:
    """Delays per edge."""
    spread = float(np.ptp(evidence.best.edge_delay_s))
    several = len({recording.rotation_speed_hz for recording in evidence.recordings}) > 1
    alone = (
        " Single recordings take all angles from rig.toml: where wheel speeds differ in delay, an angle is wrong, and the "
        "joint fit corrects it."
    )
    return Panel(
        title="Delay as seen from each wheel edge",
        caption="Four edges of a perfect wheel would give one delay. Pixel sums spread by "
        f"{uncertainty_text(spread)} from edge to edge: noise and the error of the cutout edges’ angles. Error bars: "
        "standard uncertainty from the noise of the frames alone. Colours on the right as in the figure before."
        + (alone if several else ""),
        svg=sheet.svg(delay_figures.by_edge(evidence), title="Delay by wheel edge"),
    )


def budget(evidence: Evidence) -> Panel:
    """Budget bars."""
    return Panel(
        title="Where the uncertainty comes from",
        caption="Contributions to the standard uncertainty of the trigger delay. Blue: type A, from this measurement; red: type "
        "B, from rig.toml. The long bars are the ones worth measuring better.",
        svg=sheet.svg(delay_figures.budget(evidence), title="Uncertainty budget"),
    )


def relative(evidence: Evidence) -> Panel:
    """Deviations of the relative delays."""
    return Panel(
        title="Relative delays: measured minus nominal",
        caption="The trigger generator sets delays to a tick of its clock, so each deviation is the measurement’s own error. "
        "Error bars: standard uncertainty (k = 1). Grey: what the paper printed.",
        svg=sheet.svg(delay_figures.relative(evidence), title="Deviations of the relative delays"),
    )
