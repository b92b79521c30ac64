"""Which trigger made which frame, and whether that is proven.

A camera counts its frames and, if it has a clock, says when it made each. From frame to frame the clock tells how many trigger
periods went by: more of them than frames are triggers that made none, fewer are frames that no trigger made. At the end as many
periods must lie between the first frame and the last as between the first trigger and the last; then no other assignment is
left. Where triggers are missing at one end, the time of arrival decides: a frame cannot come before its trigger.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple, final

import numpy as np

from irtiming.records.arrays import Array, Ticks
from irtiming.records.camera_frame import CameraFrame
from irtiming.records.finding import Finding
from irtiming.records.timestamps import Timestamps
from irtiming.units import counted, readable_time

_NEAR = 0.25
"""Frames must come within this part of a period of a whole number of periods."""

_CLOCK_TOLERANCE = 1e-3
_ON_THE_LINE, _TIMES_USUAL = 0.02, 10
"""So far, as part of a period, a frame may be from the line of camera's clock over triggers, or so many times the usual."""

_DRIFT, _HOST_S, _FEWEST_TO_DRIFT = 0.1, 5e-3, 64
"""By so much of a period, or of this computer's time, whichever is longer, frames may come later at the end of a run."""

_STEADY = 0.5
"""Part of a period within which nine latencies of ten must lie to be compared with those of another."""

_NO_CLOCK = 0.5
"""Without a clock of the camera: part of a period within which all frames must arrive after their triggers."""


class Place(NamedTuple):
    """Trigger ``number`` of a frame, and the numbers and identifiers of frames lost just before it."""

    number: int
    lost_numbers: tuple[int, ...]
    lost_ids: tuple[int, ...]


@final
@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Whether frames and triggers are paired beyond doubt: there are then no ``reasons`` against it.

    ``frames`` came, ``lost`` were made and did not come, ``missed`` triggers made none. ``latency_s`` is the usual time from a
    trigger to its frame's arrival, in the rig's time; None where that is not proven, or it differs from frame to frame.
    """

    reasons: tuple[str, ...]
    findings: tuple[Finding, ...]
    triggers: int
    frames: int
    lost: int
    missed: int
    latency_s: float | None

    @property
    def is_trusted(self) -> bool:
        """Whether nothing speaks against the pairing."""
        return not self.reasons


def lost_on_the_way(n_lost: int) -> Iterator[Finding]:
    """What is to be said of frames that were made and did not come."""
    if n_lost:
        what, cure = f"{counted(n_lost, 'frame')} lost on the way", "blank frames stand in their place"
        yield Finding(code="frames-lost-on-the-way", severity="warning", what=what, cure=cure)


@final
class Pairing:
    """Frames of one run, taken one by one as they come, and judged at the end.

    ``period_s`` is between two triggers, ``n_triggers`` how many were planned, ``device_frequency_hz`` that of the camera's
    clock, 0 where it has none.
    """

    def __init__(self, *, period_s: float, n_triggers: int, device_frequency_hz: float) -> None:
        self._period_s = period_s
        self._n_triggers = n_triggers
        self._device_hz = device_frequency_hz
        self._numbers: list[int] = []
        self._ids: list[int] = []
        self._device_ticks: list[int] = []
        self._host_s: list[float] = []
        self._timed: tuple[int, int] | None = None  # number and ticks of the last frame that said when it was made
        self._is_untimed = False
        self._lost = self._missed = 0
        self._reasons: list[str] = []

    @property
    def last_number(self) -> int:
        """Trigger of the last frame so far, -1 before the first."""
        return self._numbers[-1] if self._numbers else -1

    def take(self, frame: CameraFrame) -> Place | None:
        """Place of the next frame; None for one that has none, which `judge` then reports."""
        before = self._ids[-1] if self._ids else -1
        ids = frame.frame_id - before
        if ids < 1 or frame.frame_id >= 2 * self._n_triggers:
            self._against(f"frame {frame.frame_id} came after frame {before} of {self._n_triggers}")
            return None
        number = self._number(frame, ids)
        if number >= self._n_triggers:
            self._against(f"a frame more than the {self._n_triggers} triggers came")
        lost = range(ids - 1)
        place = Place(number, tuple(self.last_number + 1 + k for k in lost), tuple(before + 1 + k for k in lost))
        self._lost += ids - 1
        self._missed += number - self.last_number - ids
        self._numbers.append(number)
        self._ids.append(frame.frame_id)
        self._device_ticks.append(frame.device_timestamp_ticks)
        self._host_s.append(frame.host_time_s)
        if frame.device_timestamp_ticks:
            self._timed = number, frame.device_timestamp_ticks
        self._is_untimed |= frame.is_whole and not frame.device_timestamp_ticks
        return place

    def judge(
        self, timestamps: Timestamps, *, earliest_s: Callable[[int], float], speed: float, usual_latency_s: float | None
    ) -> Verdict:
        """What is known of the pairing when the run is over.

        Parameters
        ----------
        timestamps
            Of the run.
        earliest_s
            Gives the time of this computer before which a tick cannot have been.
        speed
            Seconds of the rig per second of this computer.
        usual_latency_s
            Usual time from trigger to arrival in an earlier run that was proven, rig's time; None if there is none.
        """
        made = timestamps.camera_trigger_delayed_ticks
        findings: list[Finding] = []
        latency_s: float | None = None
        if not self._numbers:
            self._against(
                f"no frame came for {counted(made.size, 'trigger')}; check the camera's trigger line and its TriggerSource"
            )
        elif not timestamps.is_whole:
            self._against(
                f"timestamps were lost at {counted(timestamps.lost_after_ticks.size, 'place')}; "
                "check the trigger generator's line"
            )
        else:
            findings += self._check_ends(made.size)
            latencies_s = speed * self._latencies_s(made, earliest_s)
            if self._has_clock:
                findings += self._check_clock(made, latencies_s, may_drift_s=self._may_drift_s(speed))
            else:
                self._check_arrivals(latencies_s)
                self._check_drift(latencies_s, may_drift_s=self._may_drift_s(speed))
            if latencies_s.size:
                self._check_first(made.size, latencies_s, usual_latency_s)
                latency_s = self._steady_s(latencies_s)
        return Verdict(
            reasons=tuple(self._reasons),
            findings=tuple(findings),
            triggers=int(made.size),
            frames=len(self._numbers),
            lost=self._lost,
            missed=self._missed,
            latency_s=None if self._reasons else latency_s,
        )

    @property
    def _has_clock(self) -> bool:
        """Whether the camera's clock stamped every frame; of one that came damaged the time may be missing."""
        ticks = [ticks for ticks in self._device_ticks if ticks]
        return self._device_hz > 0 and not self._is_untimed and all(a < b for a, b in pairwise(ticks))

    def _number(self, frame: CameraFrame, ids: int) -> int:
        """Trigger of a frame whose identifier is so many after the last one's: by the clock, at least so many further on."""
        next_number = self.last_number + ids
        if self._timed is None or not frame.device_timestamp_ticks or self._device_hz <= 0:
            return next_number
        number, ticks = self._timed
        passed = (frame.device_timestamp_ticks - ticks) / self._device_hz / self._period_s
        if passed <= 0:
            return next_number  # a clock that stands is none
        periods = round(passed)
        if abs(passed - periods) > _NEAR or number + periods < next_number:
            self._against(
                f"frame {frame.frame_id} was made {passed:.2f} trigger periods after the one {next_number - number} before it: "
                "the camera makes frames without triggers; check TriggerMode and TriggerSource"
            )
        return max(next_number, min(number + periods, next_number + self._n_triggers))

    def _check_ends(self, n_made: int) -> Iterator[Finding]:
        """More frames than triggers are refused; fewer are reported."""
        if self.last_number >= n_made:
            self._against(f"frames of {self.last_number + 1} triggers came, but only {n_made} were made")
        yield from lost_on_the_way(self._lost)
        if self._missed:
            what = f"{counted(self._missed, 'trigger')} made no frame"
            yield Finding(code="triggers-without-frame", severity="warning", what=what)
        if 0 <= self.last_number < n_made - 1:
            what = f"no frame came for the last {counted(n_made - 1 - self.last_number, 'trigger')}"
            yield Finding(code="last-triggers-without-frame", severity="warning", what=what)

    def _latencies_s(self, made: Ticks, earliest_s: Callable[[int], float]) -> Array:
        """At most so long, in this computer's time, each frame took from its trigger to arrival, shape (n_frame,)."""
        pairs = [(n, s) for n, s in zip(self._numbers, self._host_s, strict=True) if n < made.size]
        return np.array([host_s - earliest_s(int(made[number])) for number, host_s in pairs])

    def _check_first(self, n_made: int, latencies_s: Array, usual_latency_s: float | None) -> None:
        """Where triggers made no frame at one end, the first frame must not be able to belong to a later trigger.

        It would then have come before that, or much sooner than usual.
        """
        if self.last_number >= n_made - 1:
            return
        latency_s, steady_s = float(np.median(latencies_s)), self._steady_s(latencies_s)
        is_usual = (
            usual_latency_s is not None
            and steady_s is not None
            and abs(steady_s - usual_latency_s) < 2 * _NEAR * self._period_s
        )
        if not is_usual and not 0 <= latency_s < self._period_s:
            usual = readable_time(float(f"{latency_s:.3g}"))
            self._against(
                f"{counted(n_made - 1 - self.last_number, 'trigger')} at the beginning or the end made no frame, and the frames "
                f"came {usual} after their triggers: which were missed cannot be determined"
            )

    def _steady_s(self, latencies_s: Array) -> float | None:
        """The usual latency, None where there is none: a busy computer takes frames whenever it comes to it."""
        if float(np.ptp(np.quantile(latencies_s, (0.05, 0.95)))) > _STEADY * self._period_s:
            return None
        return float(np.median(latencies_s))

    def _check_clock(self, made: Ticks, latencies_s: Array, *, may_drift_s: float) -> Iterator[Finding]:
        """The camera's clock against the triggers over the whole run: one straight line.

        Where its slope is not 1, either the clock is a little wrong, or the camera does not wait for its triggers: the
        arrivals tell.
        """
        known = [
            (number, ticks)
            for number, ticks in zip(self._numbers, self._device_ticks, strict=True)
            if ticks and number < made.size
        ]
        if len(known) < 3:
            return
        numbers = np.array([number for number, _ in known], dtype=np.float64)
        made_s = (numbers - numbers[0]) * self._period_s
        said_s = np.array([ticks - known[0][1] for _, ticks in known]) / self._device_hz
        slope, offset = np.polyfit(made_s, said_s, 1)
        off_s = np.abs(said_s - slope * made_s - offset)
        if off_s.max() > max(_ON_THE_LINE * self._period_s, _TIMES_USUAL * float(np.median(off_s))):
            which = known[int(np.argmax(off_s))][0]
            self._against(
                f"by the camera's clock the frame of trigger {which} was made "
                f"{readable_time(float(f'{off_s.max():.3g}'))} from where the others say: no trigger made it"
            )
        if abs(slope - 1) * made_s[-1] > may_drift_s:
            self._check_drift(latencies_s, may_drift_s=may_drift_s)
        if abs(slope - 1) > _CLOCK_TOLERANCE and not self._reasons:
            what = f"the camera's clock runs {slope - 1:+.2%} against the trigger generator's"
            yield Finding(code="camera-clock-off", severity="warning", what=what, cure="one of the two is wrong")

    def _may_drift_s(self, speed: float) -> float:
        return max(_DRIFT * self._period_s, _HOST_S * speed)

    def _check_drift(self, latencies_s: Array, *, may_drift_s: float) -> None:
        """A camera that goes on by itself after its first trigger has nearly the right rate: its frames drift away."""
        if latencies_s.size < _FEWEST_TO_DRIFT:
            return
        first_s, *_, last_s = (float(np.median(part)) for part in np.array_split(latencies_s, 4))
        if abs(last_s - first_s) > may_drift_s:
            self._against(
                f"the frames came {readable_time(float(f'{first_s:.3g}'))} after their triggers at the beginning and "
                f"{readable_time(float(f'{last_s:.3g}'))} at the end: the camera does not wait for its triggers"
            )

    def _check_arrivals(self, latencies_s: Array) -> None:
        """Without a clock of the camera: a frame made by another trigger would arrive a period early or late."""
        if latencies_s.size and np.ptp(latencies_s) > _NO_CLOCK * self._period_s:
            least, most = (readable_time(float(f"{found:.3g}")) for found in (latencies_s.min(), latencies_s.max()))
            self._against(
                f"the frames came from {least} to {most} after their triggers: a trigger may have been missed or a "
                "frame made without, and the camera has no clock to tell"
            )

    def _against(self, reason: str) -> None:
        """Keep the first reason of each kind: thousands of frames may have the same."""
        if len(self._reasons) < 3:
            self._reasons.append(reason)
