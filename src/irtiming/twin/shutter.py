"""A shutter before lagging pixels: what they show while it is closed, and what they still remember of it."""

from dataclasses import dataclass, replace
from typing import Self, final

import numpy as np
import numpy.typing as npt

from irtiming.records.arrays import Array
from irtiming.twin.lag import Fading
from irtiming.twin.noise import Values
from irtiming.twin.upkeep import ShutterEvent
from irtiming.twin.views import View


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Closure:
    """A closed shutter from ``begin_s`` to ``end_s``.

    Shape (row, column), DN: closing_dn, by how much the pixels are above the shutter when it closes;
    opening_dn, by how much they are above what the scene would have made of them when it opens.
    """

    begin_s: float
    end_s: float
    closing_dn: Values
    opening_dn: Values


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Shutter:
    """All closures of a run, in order, before a surface that gives ``surface_dn``."""

    surface_dn: float
    fading: Fading
    closures: tuple[Closure, ...] = ()

    def cover(self, row_time_s: Array, *, signal_dn: Values) -> None:
        """Put the shutter, or what the pixels still remember of it, over a frame, shape (row, column)."""
        for index, closure in enumerate(self.closures):
            later = self.closures[index + 1].begin_s if index + 1 < len(self.closures) else np.inf
            closed = (row_time_s >= closure.begin_s) & (row_time_s < closure.end_s)
            opened = (row_time_s >= closure.end_s) & (row_time_s < later)
            if closed.any():
                left = self.fading.left_after(row_time_s[closed] - closure.begin_s)[:, None]
                signal_dn[closed] = self.surface_dn + left * closure.closing_dn[closed]
            if opened.any():
                left = self.fading.left_after(row_time_s[opened] - closure.end_s)[:, None]
                signal_dn[opened] += (left * closure.opening_dn[opened]).astype(np.float32)

    def closed_by(self, event: ShutterEvent, view: View, *, rows_columns: tuple[int, int]) -> Self:
        """With one more closure, and what pixels that see ``view`` carry into it and out of it."""
        begin_s, end_s = event.start_s, event.start_s + event.duration_s
        closing, opening = np.empty(rows_columns, np.float32), np.empty(rows_columns, np.float32)
        view.show(np.full(rows_columns[0], begin_s), out=closing)
        self.cover(np.full(rows_columns[0], begin_s), signal_dn=closing)
        closing -= self.surface_dn
        view.show(np.full(rows_columns[0], end_s), out=opening)
        left = float(self.fading.left_after(np.array(event.duration_s)))
        opening = (self.surface_dn + left * closing - opening).astype(np.float32)
        closure = Closure(begin_s=begin_s, end_s=end_s, closing_dn=closing, opening_dn=opening)
        return replace(self, closures=(*self.closures, closure))


def covers(event: ShutterEvent, time_s: Array) -> npt.NDArray[np.bool_]:
    """Whether the event is under way at these times, any shape."""
    return (time_s >= event.start_s) & (time_s < event.start_s + event.duration_s)
