"""When each row of each frame was exposed or read: the timing of a result put onto the stamps of frames."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.apply.camera_timing import CameraTiming, Moment, MomentName
from irtiming.apply.stamps import EventTimes
from irtiming.errors import EstimationError
from irtiming.records.arrays import Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class FrameTimes:
    """Times of all frames and rows, in the scale of the stamps; made when asked for, since a row is late alike in each frame.

    ``rows_px`` has the rows, shape (row,): one, 0, where all are read at once.
    """

    camera: CameraTiming
    events: EventTimes
    moments: tuple[Moment, ...]
    rows_px: Array

    def moment(self, name: MomentName) -> Moment:
        """The moment of that name.

        Raises
        ------
        EstimationError
            If the camera has no such moment.
        """
        for one in self.moments:
            if one.name == name:
                return one
        has = ", ".join(one.name for one in self.moments)
        raise EstimationError(f"this camera has no moment '{name}'; it has {has}")

    def offset_s(self, name: MomentName) -> Array:
        """How much later than its event the moment is in each row, in seconds of the stamps; shape (row,)."""
        return self.camera.offset_s(self.moment(name), self.rows_px) * (1 + self.events.relative_rate)

    def time_s(self, name: MomentName) -> Array:
        """Of each frame and row, since ``events.origin_s``; shape (n_frame, row)."""
        return self.events.time_s[:, None] + self.offset_s(name)[None, :]

    def u_common_s(self, name: MomentName) -> Array:
        """Standard uncertainty that a row's times have in common over all frames, shape (row,)."""
        moment = self.moment(name)
        seconds = self.events.u_rate * self.camera.offset_s(moment, self.rows_px)
        power = self.camera.u_s(moment, self.rows_px) ** 2 + seconds**2 + self._common_s2
        return np.sqrt(np.maximum(power, 0))

    def u_s(self, name: MomentName) -> Array:
        """Standard uncertainty of each row's time in any frame, shape (row,)."""
        return np.sqrt(self.u_common_s(name) ** 2 + self._own_s2)

    def correlation(self, name: MomentName) -> Array:
        """Correlation coefficient of the times of one row in two frames, shape (row,)."""
        u = self.u_s(name)
        return np.where(u > 0, (self.u_common_s(name) / np.where(u > 0, u, 1)) ** 2, 1.0)

    @property
    def _own_s2(self) -> float:
        """Variance of every time that its frame has alone: its stamp's, and the camera's from frame to frame."""
        return self.events.u_own_s**2 + self.camera.frame_scatter_s**2

    @property
    def _common_s2(self) -> float:
        """What the stamps add to the variance of every time, beside each one's own."""
        return self.events.u_common_s**2 - self.events.u_cancelled_s**2

    def correlation_of_rows(self, name: MomentName) -> Array:
        """Correlation coefficient of the times of each row with those of the first row in the same frame, shape (row,)."""
        moment = self.moment(name)
        first = np.broadcast_to(self.rows_px[:1], self.rows_px.shape)
        both = self.camera.covariance_s2(moment, moment, one_row_px=self.rows_px, other_row_px=first)
        late = self.camera.offset_s(moment, self.rows_px) * self.events.u_rate
        both = both + late * late[0] + self._common_s2 + self._own_s2
        scale = self.u_s(name) * self.u_s(name)[0]
        return np.where(scale > 0, both / np.where(scale > 0, scale, 1), 1.0)


def apply(camera: CameraTiming, events: EventTimes, *, rows_px: Array | None = None) -> FrameTimes:
    """Times of the frames whose events are given.

    Parameters
    ----------
    camera
        As its result states it.
    events
        Of the frames, by the same event as the result's.
    rows_px
        Shape (row,): rows that are wanted; None: all of a rolling camera.

    Raises
    ------
    EstimationError
        If all rows are wanted of a rolling camera whose result does not say how many it has, or one is beyond the image.
    """
    is_rolling = camera.conditions.readout_mode == "rolling"
    n_rows = camera.conditions.rows
    if not is_rolling:
        rows_px = np.zeros(1)
    elif rows_px is None:
        if n_rows is None:
            raise EstimationError("the result does not say how many rows the image has; name the rows that are wanted")
        rows_px = np.arange(n_rows, dtype=np.float64)
    rows_px = np.asarray(rows_px, dtype=np.float64)
    if rows_px.size == 0 or rows_px.min() < 0 or (n_rows is not None and rows_px.max() > n_rows - 1):
        most = "the last row" if n_rows is None else f"{n_rows - 1}"
        raise EstimationError(f"rows must be from 0 to {most}; {rows_px.tolist()} are asked for")
    period_s = events.frame_period_s or camera.conditions.frame_period_s
    return FrameTimes(camera=camera, events=events, moments=camera.moments(period_s), rows_px=rows_px)
