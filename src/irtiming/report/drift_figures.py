"""The camera's level over time: the drift that was taken off, the camera's own corrections, and what is left."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from irtiming.records.arrays import Array
from irtiming.records.reduced import ReducedRecording, ShutterEvent
from irtiming.report import row_curves, sheet
from irtiming.report.evidence import RollingEvidence

_MOST = 4


def drift(evidence: RollingEvidence) -> Figure:
    """Level of one pixel over time with shutter events shaded, recording by recording, and the residual of each frame."""
    shown = list(zip(evidence.recordings, evidence.row_fits, strict=True))[:_MOST]
    with sheet.style():
        drawn = sheet.figure(height_in=1.2 + 2.0 * len(shown))
        grid = drawn.subplots(2 * len(shown), 1, height_ratios=[1.5, 1] * len(shown), squeeze=False)[:, 0]
        for k, (recording, fit) in enumerate(shown):
            top, below = grid[2 * k], grid[2 * k + 1]
            time_s = frame_time_s(recording, recording.frame_index)
            _by_stretch(top, time_s, recording.row_sums.drift_dn, recording.segment)
            top.set_title(f"{recording.name}: drift {np.ptp(recording.row_sums.drift_dn):.1f} DN in all")
            top.set_ylabel("level (DN)")
            top.tick_params(labelbottom=False)
            sheet.zero_line(below)
            sheet.points(below, x=time_s, y=1e3 * row_curves.whole(fit).residual, colour=sheet.BLUE)
            below.set_ylabel("residual\n(10⁻³ of step)", fontsize=7.5)
            for axes in (top, below):
                axes.set_xlim(*_span(recording, time_s))
                for event in recording.shutter_events:
                    _shade(axes, recording, event)
            below.set_xlabel("time after the first kept frame (s)" if k == len(shown) - 1 else "")
    return drawn


def frame_time_s(recording: ReducedRecording, frame: Array | np.ndarray) -> Array:
    """Time of frames after the first kept one, s, by their index, any shape; beyond the kept ones at the mean frame rate."""
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


def _by_stretch(axes: Axes, time_s: Array, level: Array, segment: np.ndarray) -> None:
    for number in np.unique(segment):
        part = segment == number
        axes.plot(time_s[part], level[part], color=sheet.BLUE, linewidth=1.3)


def _shade(axes: Axes, recording: ReducedRecording, event: ShutterEvent) -> None:
    start, end = frame_time_s(recording, np.array([event.first_frame, event.end_frame]))
    axes.axvspan(start, end, color=sheet.ORANGE if event.kind == "closed" else sheet.PURPLE, alpha=0.3, linewidth=0)
