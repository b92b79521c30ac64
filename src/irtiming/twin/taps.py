"""A readout that is more than one row clock: columns that leave by paths of their own, and rows that do not come evenly."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.records.arrays import Array


@final
@dataclass(frozen=True, kw_only=True)
class Taps:
    """By how much later than the row clock says pixels are read, s.

    ``odd_columns_later_s`` are columns 1, 3, 5 ..., ``right_half_later_s`` those of the right half of the image;
    ``middle_rows_later_s`` is how far the row in the middle stands above a straight clock, of which the others are a parabola.
    """

    odd_columns_later_s: float = 0.0
    right_half_later_s: float = 0.0
    middle_rows_later_s: float = 0.0

    def rows_later_s(self, rows: int) -> Array:
        """Of each row, shape (row,), s."""
        place = np.linspace(-1, 1, rows)
        return np.asarray(self.middle_rows_later_s * (1 - place**2))

    def columns_later_s(self, columns: int) -> Array:
        """Of each column, shape (column,), s."""
        column = np.arange(columns)
        return np.asarray(
            self.odd_columns_later_s * (column % 2) + self.right_half_later_s * (column >= columns / 2), dtype=float
        )
