"""The blur of an image, as a Gaussian whose axes may lie in any direction."""

import math
from typing import NamedTuple, final


@final
class Blur(NamedTuple):
    """Standard deviations from row to row and from column to column, px, and the correlation of both.

    A positive correlation smears light from the upper left to the lower right.
    """

    rows_px: float
    columns_px: float
    correlation: float = 0.0

    @property
    def covariance_px2(self) -> float:
        """Of rows with columns."""
        return self.correlation * self.rows_px * self.columns_px

    @property
    def widest_px(self) -> float:
        """Standard deviation along the direction in which it is largest."""
        if self.correlation == 0:
            return max(self.rows_px, self.columns_px)
        rows, columns = self.rows_px**2, self.columns_px**2
        return math.sqrt((rows + columns) / 2 + math.hypot((rows - columns) / 2, self.covariance_px2))
