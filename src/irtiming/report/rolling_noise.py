"""How the noise of the frames alone ties trigger delay, time constant and row delay together."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.records.arrays import Array
from irtiming.records.row_timing import RowTimingFit

NAMES = ("trigger_delay", "time_constant", "row_delay")
_FROM_SIX = np.array([[0.25, 0.25, 0.25, 0.25, 0, 0], [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1]])


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RollingNoise:
    """Covariance (3, 3) of trigger delay, time constant and row delay from noise alone, s^2."""

    covariance_s2: Array

    @property
    def u_s(self) -> Array:
        """Standard uncertainties, shape (3,), s."""
        return np.sqrt(np.diag(self.covariance_s2))

    @property
    def correlation(self) -> Array:
        """Shape (3, 3)."""
        return np.asarray(self.covariance_s2 / np.outer(self.u_s, self.u_s))

    @property
    def u_difference_s(self) -> float:
        """Standard uncertainty of trigger delay minus time constant, s."""
        return self._u_of(np.array([1.0, -1.0, 0.0]))

    @property
    def u_sum_s(self) -> float:
        """Standard uncertainty of trigger delay plus time constant, s."""
        return self._u_of(np.array([1.0, 1.0, 0.0]))

    def _u_of(self, weights: Array) -> float:
        return float(np.sqrt(max(float(weights @ self.covariance_s2 @ weights), 0.0)))


def noise(fits: Sequence[RowTimingFit]) -> RollingNoise:
    """Of the mean over all recordings and the four wheel edges, recordings being independent of each other."""
    six = np.sum([fit.estimate.covariance for fit in fits], axis=0) / len(fits) ** 2
    return RollingNoise(covariance_s2=_FROM_SIX @ six @ _FROM_SIX.T)
