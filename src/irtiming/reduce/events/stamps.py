"""Time stamps and arrivals of frames as events: a regular grid through them, in counter time.

A camera that runs free makes its frames regularly, by its own clock; what scatters is the stamp. So the events are a grid of one
period, laid through the stamps so that half of them are late and half early: the median (least absolute deviations; Koenker and
Bassett, Econometrica 46 (1978) 33), which the tail of late arrivals does not move. For arrivals the event is thus the median
arrival, and how they scatter about it is told beside the delay.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import ReductionError
from irtiming.records.arrays import Array, Ticks
from irtiming.records.finding import Finding
from irtiming.records.frame_events import FrameEvents
from irtiming.records.recording import Recording
from irtiming.reduce.events import clocks
from irtiming.reduce.events.clocks import Relation
from irtiming.reduce.events.numbering import counts
from irtiming.reduce.events.strobe import Placed
from irtiming.units import readable_time

_FEWEST = 30
_STEPS = 60
_BLOCKS = 16
_NO_GRID = 0.25
"""Part of a period within which most stamps must lie of the grid."""

_BENT = 4.0
"""By so much the medians of parts of the recording may scatter more than independent stamps."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Grid:
    """Median line of times over counts: ``start_s`` and ``period_s``, deviations shape (n,), u of its place, its bend."""

    start_s: float
    period_s: float
    deviation_s: Array
    u_s: float
    bend: float


def place(recording: Recording) -> Placed:
    """Event of each frame on the grid of its stamps, or of its arrivals.

    Parameters
    ----------
    recording
        With exchanges that relate the stamps' clock to the counter.

    Raises
    ------
    ReductionError
        If nothing relates the two, there are too few frames, or the stamps are no grid.
    """
    own_s = _own_s(recording)
    if not np.all(np.isfinite(own_s)):
        raise ReductionError(
            f"{recording.name}: the time of frame {int(np.argmin(np.isfinite(own_s)))} is no number; write one for each "
            "frame, and frame_status for those that did not come"
        )
    counted = counts(recording)
    by_own = grid(counted.number, own_s, name=recording.name)
    middle = by_own.start_s + by_own.period_s * float(counted.number[-1]) / 2
    links = _links(recording, own_middle_s=middle)
    counter_s = _in_counter(links, by_own.start_s + by_own.period_s * np.arange(counted.number[-1] + 1.0))
    ticks = clocks.counter_ticks(recording, counter_s)
    period_s = float(counter_s[-1] - counter_s[0]) / max(1, int(counted.number[-1]))
    return Placed(
        ticks=ticks,
        frame_number=counted.number,
        events=FrameEvents(
            kind=recording.frame_event,
            period_s=period_s,
            deviation_s=by_own.deviation_s,
            relative_rate=by_own.period_s / period_s - 1,
            u_relative_rate=float(np.hypot.reduce([one.u_rate for one in links.values()])),
            offset_s=float(_in_counter(links, np.zeros(1))[0]),
            u_grid_s=by_own.u_s,
            u_clock_s=float(np.hypot.reduce([one.u_offset_s for one in links.values()])),
            findings=tuple(_findings(recording, by_own, links, source=counted.source)),
        ),
    )


def _own_s(recording: Recording) -> Array:
    """Stamps or arrivals by their own clock, from its zero, s, shape (n_frame,)."""
    zero = clocks.zeros(recording)
    if recording.frame_event == "arrival":
        if recording.frame_host_time_s is None:
            raise ReductionError(f"{recording.name}: frame_host_time is missing; record when each frame arrived")
        return np.asarray(recording.frame_host_time_s - zero.computer_s)
    ticks, frequency_hz = recording.frame_timestamp_ticks, recording.timestamp_frequency_hz
    if ticks is None or frequency_hz is None:
        raise ReductionError(
            f"{recording.name}: frame_timestamp or timestamp_frequency is missing; record the stamp of each frame with its clock"
        )
    if np.any(ticks == 0):
        raise ReductionError(
            f"{recording.name}: frame_timestamp of frame {int(np.argmax(ticks == 0))} is 0, unknown; every frame needs its stamp"
        )
    if recording.timestamp_clock == "camera" or frequency_hz % 1:
        origin_s = 0.0 if recording.timestamp_clock == "camera" else zero.computer_s - zero.camera_ticks / frequency_hz
        return np.asarray((ticks - zero.camera_ticks) / frequency_hz - origin_s)
    seconds, rest = np.divmod(ticks, round(frequency_hz))
    whole = np.floor(zero.computer_s)
    return np.asarray((seconds - int(whole)) + rest / frequency_hz - (zero.computer_s - whole))


def _links(recording: Recording, *, own_middle_s: float) -> dict[str, Relation]:
    """Relation of the computer's clock to the counter, and to the camera's where stamps are of that."""
    links = {}
    is_of_camera = recording.frame_event == "stamp" and recording.timestamp_clock == "camera"
    computer_s = own_middle_s
    if is_of_camera:
        camera = clocks.of_camera(recording, middle_s=own_middle_s)
        if camera is None:
            raise ReductionError(
                f"{recording.name}: the stamps are of the camera's own clock, and nothing relates that to the computer's; record "
                "exchange_before, exchange_timestamp and exchange_after of the camera, or timestamp_clock 'computer' where it "
                "keeps the computer's time (PTP)"
            )
        links["camera"] = camera
        computer_s = float(camera.computer_s(np.array(own_middle_s)))
    rough = clocks.of_counter(recording)
    if rough is None:
        raise ReductionError(
            f"{recording.name}: nothing relates the computer's clock to the counter; record exchange_before, exchange_counter "
            "and exchange_after of the trigger generator"
        )
    counter = clocks.of_counter(recording, middle_s=float(rough.reading_s(np.array(computer_s))))
    return links | {"counter": counter or rough}


def _in_counter(links: dict[str, Relation], own_s: Array) -> Array:
    """Times of the stamps' clock in counter time, s from its zero, any shape."""
    computer_s = links["camera"].computer_s(own_s) if "camera" in links else own_s
    return links["counter"].reading_s(computer_s)


def grid(number: Ticks, time_s: Array, *, name: str) -> Grid:
    """Median line of times over counts.

    Parameters
    ----------
    number, time_s
        Shape (n,): count and time of each frame, s.
    name
        Of the recording, for messages.

    Raises
    ------
    ReductionError
        If there are too few, or half of them lie further than a quarter of a period from any grid.

    Notes
    -----
    The place of a median of n independent values has the standard uncertainty 1 / (2 f sqrt(n)), f being their density there. The
    medians of sixteen parts of the recording say the same without independence; the larger of the two is taken.
    """
    n = time_s.size
    if n < _FEWEST:
        raise ReductionError(f"{name}: {n} stamps, at least {_FEWEST} are needed for a grid; record longer")
    x, middle = number - number.mean(), float(np.median(time_s))
    of_s = time_s - middle
    slope, offset = np.polyfit(x, of_s, 1)
    for _ in range(_STEPS):
        beside = of_s - offset - slope * x
        weight = 1 / np.maximum(np.abs(beside), 1e-3 * np.median(np.abs(beside)) + 1e-12)
        mean = float(weight @ x) / weight.sum()
        slope = float((weight * (x - mean)) @ of_s) / float(weight @ (x - mean) ** 2)
        offset = float(np.median(of_s - slope * x))
    beside = of_s - offset - slope * x
    if not np.median(np.abs(beside)) < _NO_GRID * slope:
        raise ReductionError(
            f"{name}: half of the stamps are further than {readable_time(float(f'{np.median(np.abs(beside)):.2g}'))} from a grid "
            f"of {1e3 * slope:.4g} ms; check its frame rate, and which frames were lost"
        )
    parts = np.array([np.median(part) for part in np.array_split(beside, min(_BLOCKS, n // 5))])
    u_alone = 0.5 / (_density(beside) * np.sqrt(n))
    u_parts = float(parts.std(ddof=1)) / np.sqrt(parts.size)
    start = float(offset - slope * number.mean()) + middle
    return Grid(
        start_s=start, period_s=float(slope), deviation_s=beside, u_s=max(u_alone, u_parts), bend=u_parts / u_alone
    )


def _density(beside: Array) -> float:
    """Density at zero, 1/s, by a box of the width that normal scatter of the middle half asks for."""
    middle_half = float(np.subtract(*np.quantile(beside, (0.75, 0.25)))) / 1.349
    half = max(1.06 * middle_half * beside.size**-0.2, 1e-12)
    return max(1, int(np.count_nonzero(np.abs(beside) <= half))) / (2 * half * beside.size)


def _findings(recording: Recording, found: Grid, links: dict[str, Relation], *, source: str) -> list[Finding]:
    late_s, wide_s = (float(np.quantile(found.deviation_s, share)) for share in (0.99, 0.95))
    told = ", ".join(
        f"the {one} within {readable_time(float(f'{link.u_offset_s:.2g}'))}" for one, link in links.items()
    )
    kind = "arrivals" if recording.frame_event == "arrival" else "stamps"
    what = (
        f"the event of a frame is its place on the grid of the {kind} (frames counted by {source}): 5 of 100 come more than "
        f"{readable_time(float(f'{wide_s:.2g}'))} later, 1 of 100 more than {readable_time(float(f'{late_s:.2g}'))}; the "
        f"computer's clock is known (u) against {told}"
    )
    findings = [Finding(code="event-grid", severity="info", what=what)]
    if found.bend > _BENT:
        what = f"the {kind} are no regular grid: parts of the recording scatter {found.bend:.2g} times what single ones tell"
        cure = "see that neither clock is set while recording, and that the frame rate is fixed"
        findings.append(Finding(code="event-grid-bent", severity="doubt", what=what, cure=cure))
    slack_s = max(link.slack_s for link in links.values())
    if slack_s > 0:
        what = (
            f"no straight line of one clock over the other lies within all exchanges: they had to be widened by "
            f"{readable_time(float(f'{slack_s:.2g}'))}, which is in u"
        )
        cure = "a clock was set, or wanders; use the computer's monotonic clock, record for a shorter time"
        findings.append(Finding(code="exchanges-disagree", severity="doubt", what=what, cure=cure))
    return findings
