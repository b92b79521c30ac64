"""Frames of a camera that runs free, counted as they come, and whether that can be trusted."""

from collections.abc import Iterator
from dataclasses import replace
from typing import final

import numpy as np

from irtiming.acquire.pairing import Place, Verdict, lost_on_the_way
from irtiming.records.camera_frame import CameraFrame
from irtiming.records.finding import Finding
from irtiming.records.frame_events import FrameEvent
from irtiming.records.timestamps import Timestamps
from irtiming.units import counted, readable_time

_SAME_RATE = 1e-3
"""By so much, relative, the camera's period may differ from the one that was planned before it is reported."""


@final
class FreeCount:
    """Frames of one run in place of `Pairing`: the camera's own count is the number of a frame, and no trigger is looked for.

    ``event`` is what their delay counts from, ``period_s`` between two frames as planned, ``n_frames`` how many are wanted.
    """

    def __init__(self, *, event: FrameEvent, period_s: float, n_frames: int) -> None:
        self._event, self._period_s, self._n_frames = event, period_s, n_frames
        self._last, self._frames, self._lost, self._untimed = -1, 0, 0, 0
        self._reasons: list[str] = []

    @property
    def last_number(self) -> int:
        """Count of the last frame so far, -1 before the first."""
        return self._last

    @property
    def has_all(self) -> bool:
        """Whether as many frames were made as are wanted."""
        return self._last >= self._n_frames - 1

    def take(self, frame: CameraFrame) -> Place | None:
        """Place of the next frame; None for one whose count does not rise, which `judge` then reports."""
        if frame.frame_id <= self._last:
            self._reasons = self._reasons or [f"frame {frame.frame_id} came after frame {self._last}"]
            return None
        lost = tuple(range(self._last + 1, frame.frame_id))
        self._last, self._frames, self._lost = frame.frame_id, self._frames + 1, self._lost + len(lost)
        self._untimed += frame.is_whole and not frame.device_timestamp_ticks
        return Place(frame.frame_id, lost, lost)

    def judge(self, timestamps: Timestamps, *, before_start: int) -> Verdict:
        """What is known when the run is over.

        Parameters
        ----------
        timestamps
            Of the run, all of them.
        before_start
            Strobe edges that came before the camera was started.
        """
        if not self._frames:
            self._reasons.append("no frame came; check the camera's cable and its AcquisitionMode")
        elif not timestamps.is_whole:
            self._reasons.append(
                f"timestamps were lost at {counted(timestamps.lost_after_ticks.size, 'place')}; "
                "check the trigger generator's line"
            )
        findings = [*lost_on_the_way(self._lost)]
        if self._event == "strobe" and self._frames:
            findings += self._of_strobe(timestamps, before_start)
        if self._event == "stamp" and self._untimed:
            self._reasons.append(
                f"{counted(self._untimed, 'frame')} without a stamp of the camera; count from strobe or arrival"
            )
        return Verdict(
            reasons=tuple(self._reasons),
            findings=tuple(findings),
            triggers=self._last + 1,
            frames=self._frames,
            lost=self._lost,
            missed=0,
            latency_s=None,
        )

    def own(self, timestamps: Timestamps) -> Timestamps:
        """The same with strobe edges of the counted frames alone: the camera made more until it stopped."""
        return replace(timestamps, camera_input_ticks=timestamps.camera_input_ticks[: self._last + 1])

    def _of_strobe(self, timestamps: Timestamps, before_start: int) -> Iterator[Finding]:
        """Each frame must have its edge, the first frame the first: the camera was started after the generator."""
        edges = timestamps.camera_input_ticks
        if before_start:
            self._reasons.append(
                f"{counted(before_start, 'edge')} came at camera_input before the camera was started; "
                "see what else drives that line"
            )
        if edges.size < self._last + 1:
            self._reasons.append(
                f"camera_input has {counted(edges.size, 'edge')} for {self._last + 1} frames; "
                "check the strobe output, LineSource and cable"
            )
            return
        period_s = (
            float(np.median(np.diff(edges))) / timestamps.clock_frequency_hz if edges.size > 1 else self._period_s
        )
        if abs(period_s / self._period_s - 1) > _SAME_RATE:
            what = (
                f"the strobe comes every {readable_time(float(f'{period_s:.6g}'))}, planned was "
                f"{readable_time(float(f'{self._period_s:.6g}'))}"
            )
            cure = "wheel angles may be visited unevenly; set the camera's frame rate, or plan for the one that it has"
            yield Finding(code="frame-rate-not-planned", severity="warning", what=what, cure=cure)
