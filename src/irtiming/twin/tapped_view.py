"""What pixels see whose columns are read at moments of their own."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.records.arrays import Array, Mask
from irtiming.twin.noise import Values
from irtiming.twin.taps import Taps
from irtiming.twin.views import View


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TappedView:
    """A view whose columns are shown at as many moments as there are taps; ``later_s`` has shape (column,)."""

    view: View
    later_s: Array

    def show(self, row_time_s: Array, *, out: Values) -> None:
        """Signal, DN, shape (row, column), of rows whose turn begins at these times, shape (row,), s."""
        whole = np.empty_like(out)
        for later_s in np.unique(self.later_s):
            self.view.show(row_time_s + later_s, out=whole)
            these: Mask = self.later_s == later_s
            out[:, these] = whole[:, these]


def tapped(view: View, taps: Taps, *, columns: int) -> View:
    """The view through the taps of an image of so many columns; itself where they keep step."""
    later_s = taps.columns_later_s(columns)
    return TappedView(view=view, later_s=later_s) if later_s.any() else view
