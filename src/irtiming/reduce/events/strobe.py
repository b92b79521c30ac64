"""Frames paired with the edges of the camera's strobe, one by one, and how sure that is.

The edges are numbered along their own rhythm, the frames by the camera's count; what is left is one whole number, the edge of the
first frame. Where as many edges were stamped as frames made, there is only one. Else the camera's own time stamps may tell: both
clocks see by how much one frame comes later or earlier than regular, and they agree at the right place alone. Where neither
tells, the delay is known but for whole frame periods: the wheel says when each frame was exposed whatever edge it is counted
from.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import ReductionError
from irtiming.physics import robust
from irtiming.records.arrays import Array, Ticks
from irtiming.records.finding import Finding
from irtiming.records.frame_events import FrameEvents
from irtiming.records.recording import Recording
from irtiming.reduce.events import clocks
from irtiming.reduce.events.numbering import Counts, counts, stamps_s
from irtiming.reduce.wheel.edge_train import EdgeTrain, number_edges
from irtiming.units import counted, readable_time

_FEWEST = 8
_SURE = 10.0
"""By so much the logarithm of the likelihood of the best pairing must be above that of the second best."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Placed:
    """Events in counter time, shape (n_event,), and which of them is each frame's, shape (n_frame,)."""

    ticks: Ticks
    frame_number: Ticks
    events: FrameEvents


def place(recording: Recording) -> Placed:
    """Strobe edge of each frame.

    Parameters
    ----------
    recording
        With ``camera_input_ticks``.

    Raises
    ------
    ReductionError
        If there are fewer edges than frames, the edges are not regular, or lost frames cannot be recognised.
    """
    edges = recording.camera_input_ticks
    n_frames = recording.frames.shape[0]
    if edges is None or edges.size < _FEWEST:
        raise ReductionError(
            f"{recording.name}: camera_input holds {0 if edges is None else edges.size} edges for {n_frames} frames, at least "
            f"{_FEWEST} are needed; connect the camera's strobe output and record again"
        )
    train = _numbered(edges, recording)
    numbered = counts(recording)
    spare = int(train.number[-1]) - int(numbered.number[-1])
    if spare < 0:
        raise ReductionError(
            f"{recording.name}: camera_input has edges of {int(train.number[-1]) + 1} frames, but the camera made "
            f"{int(numbered.number[-1]) + 1} ({numbered.source}); stamp the strobe from before the first frame to after the last"
        )
    if spare and numbered.source == "none":
        raise ReductionError(
            f"{recording.name}: camera_input has {counted(spare, 'edge')} more than there are frames, and nothing shows which "
            "frames were lost; record frame_id or frame_timestamp with each frame"
        )
    every = np.interp(np.arange(train.number[-1] + 1), train.number, train.ticks - train.ticks[0])
    first, findings = _first_edge(recording, numbered, every / recording.clock_frequency_hz, spare=spare)
    ticks = np.rint(every[first : first + numbered.number[-1] + 1]).astype(np.int64) + train.ticks[0]
    return Placed(
        ticks=ticks, frame_number=numbered.number,
        events=_events(recording, numbered, ticks, findings=(*_of_train(train, recording), *findings)),
    )  # fmt: skip


def _numbered(edges: Ticks, recording: Recording) -> EdgeTrain:
    """The edges along their own rhythm; what is said of a wheel's edges would not help with those of a strobe."""
    try:
        return number_edges(edges, period_ticks=max(float(np.median(np.diff(edges))), 1.0), name="camera_input")
    except ReductionError as error:
        raise ReductionError(
            f"{recording.name}: the {edges.size} edges of camera_input have no steady rhythm, a camera that runs free must have "
            "one period; fix its frame rate (no automatic exposure), and see that none of them bounces"
        ) from error


def _of_train(train: EdgeTrain, recording: Recording) -> tuple[Finding, ...]:
    return train.findings("camera_input", recording=recording.name)


def _events(recording: Recording, numbered: Counts, ticks: Ticks, *, findings: tuple[Finding, ...]) -> FrameEvents:
    time_s = (ticks[numbered.number] - ticks[0]) / recording.clock_frequency_hz
    slope, offset = np.polyfit(numbered.number, time_s, 1)
    return FrameEvents(
        kind="strobe",
        period_s=float(slope),
        deviation_s=time_s - slope * numbered.number - offset,
        findings=findings,
    )


def _first_edge(
    recording: Recording, numbered: Counts, edge_s: Array, *, spare: int
) -> tuple[int, tuple[Finding, ...]]:
    """Edge of the first frame, and how sure that is."""
    if spare == 0:
        return 0, _paired(
            f"each of {numbered.number.size} frames has its strobe edge: as many as the camera made, by {numbered.source}"
        )
    stamps, period_s = stamps_s(recording), float(np.median(np.diff(edge_s)))
    paired = None if stamps is None else _by_pattern(stamps, edge_s, numbered.number, spare=spare)
    latency_s = clocks.arrival_after_s(recording, edge_s[numbered.number])
    last = spare if latency_s is None else int(np.clip(np.floor(latency_s / period_s), 0, spare))
    if paired is not None and paired.ahead > _SURE:
        what = (
            f"of {spare + 1} ways to pair frames and strobe edges the camera's stamps single out one: they scatter by "
            f"{readable_time(float(f'{paired.scatter_s:.2g}'))} from its edges, by "
            f"{readable_time(float(f'{paired.second_s:.2g}'))} from those of the second best"
        )
        return paired.first, _paired(what)
    first = 0 if latency_s is None else last
    chosen = "the first edge is taken for the first frame" if latency_s is None else (
        "the last edge before the frames' arrival is taken"
    )  # fmt: skip
    what = (
        f"camera_input has {counted(spare, 'edge')} more than frames, and nothing shows which belong to frames: {chosen}, and "
        f"the delay may be whole frame periods of {1e3 * period_s:.6g} ms off"
    )
    cure = "stamp the strobe from before the camera starts to after it stops, or let it leave out a frame on purpose"
    return first, (Finding(code="strobe-pairing-ambiguous", severity="doubt", what=what, cure=cure),)


def _paired(what: str) -> tuple[Finding, ...]:
    return (Finding(code="strobe-pairing", severity="info", what=what),)


@final
@dataclass(frozen=True, kw_only=True)
class _Pattern:
    """Best edge of the first frame, scatter of stamps about edges there and at the second best, log likelihood between."""

    first: int
    scatter_s: float
    second_s: float
    ahead: float


def _by_pattern(stamp_s: Array, edge_s: Array, number: Ticks, *, spare: int) -> _Pattern:
    """What the camera's stamps say: the pairing at which they follow the edges most closely.

    A median deviation is not moved by single wrong stamps; the likelihood is that of normal scatter, for half of the frames,
    since neighbours may be correlated.
    """
    x = number - number.mean()
    scatter = np.empty(spare + 1)
    for first in range(spare + 1):
        beside = stamp_s - edge_s[number + first]
        beside = beside - beside.mean()
        beside = beside - x * float(x @ beside) / float(x @ x)
        scatter[first] = robust.spread(beside - np.median(beside))
    order = np.argsort(scatter)
    best, second = (max(float(scatter[k]), 1e-12) for k in order[:2])
    return _Pattern(
        first=int(order[0]), scatter_s=best, second_s=second, ahead=number.size / 2 * float(np.log(second / best))
    )
