"""Time stamps and arrivals of frames as events: a regular grid through them, in counter time.

A camera that runs free makes its frames regularly, by its own clock; what scatters is the stamp. So the events are a grid of one
period, the median line of `inference.stamp_line`: half of the stamps are late, half early, and the tail of late arrivals does not
move it. For arrivals the event is thus the median arrival, and how they scatter about it is reported beside the delay.
"""

import numpy as np

from irtiming.errors import EstimationError, ReductionError
from irtiming.inference import stamp_line
from irtiming.inference.stamp_line import StampLine
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
_BENT = 4.0
"""By so much the medians of parts of the recording may scatter more than independent stamps."""


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
    by_own = _grid(counted.number, own_s, name=recording.name)
    on_grid_s = by_own.stamp_s(np.arange(counted.number[-1] + 1.0))
    links = _links(recording, own_middle_s=float(on_grid_s[0] + on_grid_s[-1]) / 2)
    counter_s = _in_counter(links, on_grid_s)
    ticks = clocks.counter_ticks(recording, counter_s)
    period_s = float(counter_s[-1] - counter_s[0]) / max(1, int(counted.number[-1]))
    return Placed(
        ticks=ticks,
        frame_number=counted.number,
        events=FrameEvents(
            kind=recording.frame_event,
            period_s=period_s,
            deviation_s=by_own.deviation_s,
            relative_rate=by_own.rate / period_s - 1,
            u_relative_rate=float(np.hypot.reduce([one.u_rate for one in links.values()])),
            offset_s=float(_in_counter(links, np.zeros(1))[0]),
            u_grid_s=by_own.u_at_middle_s,
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


def _grid(number: Ticks, time_s: Array, *, name: str) -> StampLine:
    """Median line of times over counts; both shape (n,), time in s."""
    if time_s.size < _FEWEST:
        raise ReductionError(f"{name}: {time_s.size} stamps, at least {_FEWEST} are needed for a grid; record longer")
    try:
        return stamp_line.grid(number, time_s)
    except EstimationError as error:
        raise ReductionError(f"{name}: {error}") from error


def _findings(recording: Recording, found: StampLine, links: dict[str, Relation], *, source: str) -> list[Finding]:
    late_s, wide_s = (float(np.quantile(found.deviation_s, share)) for share in (0.99, 0.95))
    clocks_known = ", ".join(
        f"the {one} within {readable_time(float(f'{link.u_offset_s:.2g}'))}" for one, link in links.items()
    )
    kind = "arrivals" if recording.frame_event == "arrival" else "stamps"
    what = (
        f"the event of a frame is its place on the grid of the {kind} (frames counted by {source}): 5 of 100 come more than "
        f"{readable_time(float(f'{wide_s:.2g}'))} later, 1 of 100 more than {readable_time(float(f'{late_s:.2g}'))}; the "
        f"computer's clock is known (u) against {clocks_known}"
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
