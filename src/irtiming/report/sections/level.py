"""The camera's level over time: the drift that was taken off, the camera's own corrections, and what is left."""

from typing import TYPE_CHECKING

import numpy as np

from irtiming.records.analysis import Analysis
from irtiming.records.arrays import Array
from irtiming.records.reduced import ReducedRecording, ShutterEvent
from irtiming.records.row_timing import RowTimingFit
from irtiming.report import row_curves, sheet
from irtiming.report.blocks import Panel, Table
from irtiming.report.language import heads, t
from irtiming.report.rounding import fixed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST = 4


def panels(analysis: Analysis) -> tuple[Panel, ...]:
    """Level over time; none of a camera whose level was not followed."""
    shown, n = len(_shown(analysis)), len(analysis.recordings)
    if not shown:
        return ()
    more = t(" The first {shown} of {n} recordings.", shown=shown, n=n) if n > shown else ""
    return (
        Panel(
            title=t("Level of the camera over time"),
            caption=t(
                "Line: slow change of a pixel’s level that was taken off, each stretch between corrections with a level "
                "of its own. Shaded: the camera corrects itself (orange: shutter closed, violet: frozen); these frames "
                "are left out. Below: what the fit leaves over in each frame; a trend would be drift that was not "
                "caught.{more}",
                more=more,
            ),
            svg=sheet.svg(drift(analysis), title=t("Drift of the level over time with shutter events")),
        ),
    )


def _shown(analysis: Analysis) -> list[tuple[ReducedRecording, RowTimingFit]]:
    pairs = zip(analysis.recordings, analysis.fits, strict=True)
    return [(recording, fit) for recording, fit in pairs if recording.rows and isinstance(fit, RowTimingFit)][:_MOST]


def drift(analysis: Analysis) -> "Figure":
    """Level of one pixel over time with shutter events shaded, recording by recording, and the residual of each frame."""
    shown = _shown(analysis)
    with sheet.style():
        drawn = sheet.figure(height_in=1.2 + 2.0 * len(shown))
        grid = drawn.subplots(2 * len(shown), 1, height_ratios=[1.5, 1] * len(shown), squeeze=False)[:, 0]
        for k, (recording, fit) in enumerate(shown):
            top, below = grid[2 * k], grid[2 * k + 1]
            time_s = frame_time_s(recording, recording.frame_index.astype(float))
            _by_stretch(top, time_s, recording.row_sums.drift_dn, recording.segment)
            top.set_title(
                t(
                    "{name}: drift {drift:.1f} DN in all",
                    name=recording.name,
                    drift=np.ptp(recording.row_sums.drift_dn),
                )
            )
            top.set_ylabel(t("level (DN)"))
            top.tick_params(labelbottom=False)
            sheet.zero_line(below)
            sheet.points(below, x=time_s[fit.kept], y=1e3 * row_curves.whole(fit).residual, colour=sheet.BLUE)
            below.set_ylabel(t("residual\n(10⁻³ of step)"), fontsize=7.5)
            for axes in (top, below):
                axes.set_xlim(*_span(recording, time_s))
                for event in recording.shutter_events:
                    _shade(axes, recording, event)
            below.set_xlabel(t("time after the first kept frame (s)") if k == len(shown) - 1 else "")
    return drawn


def frame_time_s(recording: ReducedRecording, frame: Array) -> Array:
    """Time of frames after the first kept one, s, by their index, shapes (n,); beyond the kept ones at the mean frame rate."""
    index = recording.frame_index.astype(float)
    time_s = (recording.trigger_ticks - recording.trigger_ticks[0]) / recording.track.clock_frequency_hz
    period_s = float((time_s[-1] - time_s[0]) / max(index[-1] - index[0], 1.0))
    wanted = np.asarray(frame, float)
    within = np.interp(wanted, index, time_s)
    beyond = np.minimum(wanted - index[0], 0) + np.maximum(wanted - index[-1], 0)
    return np.asarray(within + beyond * period_s)


def _span(recording: ReducedRecording, time_s: Array) -> tuple[float, float]:
    ends = [frame for event in recording.shutter_events for frame in (event.first_frame, event.end_frame)]
    edges = frame_time_s(recording, np.array([0, recording.n_frames - 1, *ends]))
    return float(min(edges.min(), time_s[0])), float(max(edges.max(), time_s[-1]))


def _by_stretch(axes: "Axes", time_s: Array, level: Array, segment: np.ndarray) -> None:
    for number in np.unique(segment):
        part = segment == number
        axes.plot(time_s[part], level[part], color=sheet.BLUE, linewidth=1.3)


def _shade(axes: "Axes", recording: ReducedRecording, event: ShutterEvent) -> None:
    start, end = frame_time_s(recording, np.array([event.first_frame, event.end_frame]))
    axes.axvspan(start, end, color=sheet.ORANGE if event.kind == "closed" else sheet.PURPLE, alpha=0.3, linewidth=0)


def shutter_events(analysis: Analysis) -> Table:
    """When the camera corrected itself."""
    rows = []
    for recording in analysis.recordings:
        for event in recording.shutter_events:
            start, end = frame_time_s(recording, np.array([event.first_frame, event.end_frame], float))
            frames = f"{event.first_frame} … {event.end_frame - 1}"
            what = t("shutter closed") if event.kind == "closed" else t("frame repeated")
            rows.append((recording.name, what, frames, fixed(float(start), 2), fixed(float(end - start), 2)))
    return Table(
        title=t("Corrections by the camera itself"),
        columns=heads("recording", "what", "frames", "after the first kept frame (s)", "for (s)"),
        align="llrrr",
        rows=tuple(rows),
        note=t("These frames and those around them are left out; each stretch between them has its own level."),
    )
