"""All figures of a rolling camera's report, each with a caption that says what one sees."""

import numpy as np

from irtiming.report import drift_figures, lag_figures, rolling_budget, rolling_images, row_curves, row_figures, sheet
from irtiming.report.evidence import RollingEvidence
from irtiming.report.figures import Panel
from irtiming.report.rolling_tables import noise_sentence
from irtiming.report.rounding import time_text, uncertainty_text


def figure_6(evidence: RollingEvidence) -> Panel:
    """Figure 6 for the user's camera."""
    fit = evidence.row_fits[0]
    rows = ", ".join(str(fit.row_px[k]) for k in row_curves.show_rows(fit))
    return Panel(
        title="Opening fractions of the whole opening and of four rows",
        caption=f"As figure 6 of Schatz 2023, from {fit.name}. (a) Rows weighted by their light; (c) to (f) rows {rows}, "
        "marked in (b). Points: frames, over the wheel angle at the trigger with its set delay; black: the exact model with the "
        "fitted numbers; below each what it leaves over, red its mean over 6°. Pixels lag, so every corner is rounded behind it; "
        "later rows see the wheel further on. (b) A frame as recorded: "
        "rows are read one after the other, which bends the edge. Red: the edge where lagging pixels are half way; dashed: where "
        "it would be if all rows were read with the middle one.",
        svg=sheet.svg(row_figures.figure_6(evidence), title="Opening fractions over the wheel angle with residuals"),
    )


def scan(evidence: RollingEvidence) -> Panel:
    """Likelihood and RMS over the time constant."""
    fit = evidence.row_fits[0]
    u = fit.estimate.u("time_constant")
    theirs = (
        " Right: the published procedure could not be run."
        if not evidence.published_fits
        else (
            " Right: rms deviation of the published simulation from "
            f"{' and '.join(evidence.published_fits[0].data.names[:2])}, delays determined anew at each τ."
        )
    )
    return Panel(
        title="How well other time constants fit",
        caption=f"Left, {fit.name}: all other numbers fitted anew at each τ; 1 is one standard uncertainty were the residuals "
        f"white; {time_text(fit.timing['time_constant'], u)} from noise alone.{theirs} Below: points minus parabola. The "
        "narrower the valley, the better τ is known; points off the parabola would bias its minimum.",
        svg=sheet.svg(lag_figures.scan(evidence), title="Deviation over the time constant by both methods"),
    )


def ellipse(evidence: RollingEvidence) -> Panel:
    """Noise of trigger delay and time constant."""
    return Panel(
        title="Trigger delay and time constant as noise ties them",
        caption=f"{noise_sentence(evidence)} Box: what ± u of each alone would suggest. Right: with all parts of the budget; "
        "errors of the rig’s angles move the trigger delay only, along the abscissa.",
        svg=sheet.svg(lag_figures.ellipse(evidence), title="Correlation of trigger delay and time constant"),
    )


def row_delays(evidence: RollingEvidence) -> Panel:
    """Delay over image row."""
    fit = evidence.row_fits[0]
    ours = row_curves.row_delays(fit)
    weight = 1 / ours.u_delay_s**2
    rms = float(np.sqrt(np.sum(weight * (ours.delay_s - ours.line_s) ** 2) / weight.sum()))
    theirs = "The published procedure could not be run."
    if evidence.published_fits:
        published = evidence.published_fits[0]
        line = published.timing.trigger_delay_s + published.timing.row_delay_s * published.row_px
        rms_published = float(np.sqrt(np.nanmean((published.delay_of_row_s - line) ** 2)))
        theirs = (
            "Orange: published row delays (horizontal distance of the slopes; outliers lie at the edge of the picture), rms "
            f"{uncertainty_text(rms_published)} about their line."
        )
    return Panel(
        title="Delay of each image row",
        caption=f"Blue, {fit.name}: where each row alone would have the exact model, the other numbers held, with standard "
        f"uncertainties from noise; weighted rms distance from the line {uncertainty_text(rms)}. Rows with much less light than "
        f"the others are left out of the picture, not of the fit. {theirs} A bend would show distortion by the lens or an uneven "
        "readout.",
        svg=sheet.svg(row_figures.row_delays(evidence), title="Delay over the image row with residuals"),
    )


def residual_map(evidence: RollingEvidence) -> Panel:
    """Residuals of all rows."""
    return Panel(
        title="Residuals of all rows",
        caption=f"{evidence.row_fits[0].name}: data minus model, mean over 2.5° of wheel angle, over the standard deviation that "
        "the row’s noise would give that mean. Good: speckle between −2 and 2. Stripes along an edge’s passing would show a "
        "wrong time constant, a wrong edge or a mask that is no sector.",
        svg=sheet.svg(row_figures.residual_map(evidence), title="Residuals over image row and wheel angle"),
    )


def opening(evidence: RollingEvidence) -> Panel:
    """The opening in the image."""
    return Panel(
        title="The mask opening as the camera sees it",
        caption=f"{evidence.recordings[0].name}. Top left: mean of the most open frames with the fitted sector (red), axle and "
        "bisector (orange). Top right: yellow, summed region with its blurred border; light blue, half contrast; violet, bad "
        "pixels, for which neighbours stand in. Then contrast of each pixel from the wheel’s second harmonic, free of lag; "
        "that of the fitted sector; the difference, which also holds the mask plate and an uneven wheel; and what nothing but "
        "pixel gains or burrs of the mask explains. The model of the rows keeps all of it.",
        svg=sheet.svg(rolling_images.opening(evidence), title="Mean open frame, masks, contrast and excess"),
    )


def drift(evidence: RollingEvidence) -> Panel:
    """Level over time."""
    shown, n = min(4, len(evidence.recordings)), len(evidence.recordings)
    more = f" The first {shown} of {n} recordings." if n > shown else ""
    return Panel(
        title="Level of the camera over time",
        caption="Line: slow change of a pixel’s level that was taken off, each stretch between corrections with a level of its "
        "own. Shaded: the camera corrects itself (orange: shutter closed, violet: frozen); these frames are left out. Below: "
        f"what the fit leaves over in each frame; a trend would be drift that was not caught.{more}",
        svg=sheet.svg(drift_figures.drift(evidence), title="Drift of the level over time with shutter events"),
    )


def budget(evidence: RollingEvidence) -> Panel:
    """Budget bars."""
    return Panel(
        title="Where the uncertainty comes from",
        caption="Contributions to the standard uncertainties. Blue: type A, from this measurement; red: type B, from rig.toml. "
        "The long bars are the ones worth measuring better.",
        svg=sheet.svg(rolling_budget.budget(evidence), title="Uncertainty budget"),
    )


def by_edge(evidence: RollingEvidence) -> Panel:
    """Delays per edge."""
    spread = uncertainty_text(float(np.ptp(evidence.best.edge_delay_s)))
    return Panel(
        title="Delay of row 0 as seen from each wheel edge",
        caption=f"Four edges of a perfect wheel would give one delay; these spread by {spread}: noise and the error of the "
        "cutout edges’ angles. Error bars: standard uncertainty from noise alone, most of it common to the four.",
        svg=sheet.svg(rolling_budget.by_edge(evidence), title="Delay by wheel edge"),
    )


def relative(evidence: RollingEvidence) -> Panel:
    """Deviations of the relative delays."""
    return Panel(
        title="Relative delays: measured minus nominal",
        caption="The trigger generator sets delays to a tick of its clock, so each deviation is the measurement’s own error. "
        "Error bars: standard uncertainty (k = 1). The ordinates differ.",
        svg=sheet.svg(rolling_budget.relative(evidence), title="Deviations of the relative delays"),
    )
