"""What a point of light anywhere on the wheel would show in a contrast image, as a table over its polar angle."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np
from numba import njit

from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array, ComplexArray, Mask

SIZE = 16384
"""Places in a turn, at which a table stands."""
HARMONICS = 1024
"""Highest order in a table: beyond, the wheel turns by less than a pixel that is as many pixels from the axle."""
_NARROWEST_RAD, _WIDEST_RAD, _N_WIDTHS = 1e-3, 1.0, 70  # of the Gaussians by which the table is smoothed
_WIDTH_STEP = math.log(_WIDEST_RAD / _NARROWEST_RAD) / (_N_WIDTHS - 1)
_WIDTHS = np.geomspace(_NARROWEST_RAD, _WIDEST_RAD, _N_WIDTHS)
_ORDERS = np.arange(-HARMONICS, HARMONICS + 1)  # of the table's spectrum: there are no others
_MOST_GAPS = 8  # of which tables are kept
_SHORTEST_WAVE = 2.0  # in gaps of a quadrature: what it resolves
_SHARPNESS = 8  # with which what is shorter ends
_POWERS = _ORDERS.astype(float) ** _SHARPNESS


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PointTable:
    """Projection of a point of light over its polar angle from the bisector, shape (16384,).

    What is made of it is kept: a search asks for the same again and again.
    """

    table: ComplexArray

    def values(self, angle_rad: Array) -> ComplexArray:
        """What a point of light shows at any angle, by linear interpolation; same shape."""
        return between(self.table, angle_rad)

    def at_nodes(self, angle_rad: Array, *, gap_rad: float) -> ComplexArray:
        """The same for a quadrature whose nodes are that far apart: without waves that it would take for longer ones.

        A blur leaves next to nothing of such waves, since the nodes are as close as it asks.
        """
        table = self._without_waves.get(gap_rad)
        if table is None:
            highest = TURN / (_SHORTEST_WAVE * gap_rad)
            table = self._weakened(np.exp(_POWERS / -(highest**_SHARPNESS)))
            if len(self._without_waves) >= _MOST_GAPS:
                self._without_waves.clear()
            self._without_waves[gap_rad] = table
        return between(table, angle_rad)

    def smeared(self, angle_rad: Array, *, width_rad: Array) -> ComplexArray:
        """Mean of the table over a Gaussian about any angle, with its standard deviation; all of one shape.

        Frames are few, so that the table is rough: a handful of its values would not tell its mean.
        """
        angles, smooth = np.ascontiguousarray(angle_rad), self._smoothed(width_rad.min(), width_rad.max())
        return np.asarray(_means(smooth, angles.ravel(), width_rad.ravel()).reshape(angles.shape))

    def _smoothed(self, narrowest_rad: float, widest_rad: float) -> ComplexArray:
        """The table smoothed by Gaussians from the narrowest to the widest, shape (70, 16384); those between both are made."""
        table, is_made = self._smooth
        first, last = int(_place_of_width(narrowest_rad)), int(_place_of_width(widest_rad)) + 1
        for k in first + np.flatnonzero(~is_made[first : last + 1]):
            table[k] = self._weakened(np.exp(-0.5 * (_ORDERS * _WIDTHS[k]) ** 2))
            is_made[k] = True
        return table

    @cached_property
    def _smooth(self) -> tuple[ComplexArray, Mask]:
        """Room for the smoothed tables, and which of them are made: an image asks for a few neighbours."""
        return np.empty((_N_WIDTHS, SIZE), complex), np.zeros(_N_WIDTHS, bool)

    @cached_property
    def _without_waves(self) -> dict[float, ComplexArray]:
        """The last tables of `at_nodes` by their gap: most steps of a search keep the gap."""
        return {}

    def _weakened(self, part: Array) -> ComplexArray:
        """The table of which that part of each order is left, shape (16384,)."""
        spectrum = np.zeros(SIZE, complex)
        spectrum[_ORDERS] = self._spectrum * part
        return np.asarray(np.fft.ifft(spectrum))

    @cached_property
    def _spectrum(self) -> ComplexArray:
        """Of each order."""
        return np.asarray(np.fft.fft(self.table)[_ORDERS])


def between(table: ComplexArray, angle_rad: Array) -> ComplexArray:
    """Table at any angle, by linear interpolation; of the angles' shape."""
    angles = np.ascontiguousarray(angle_rad)
    return np.asarray(_interpolated(table, angles.ravel()).reshape(angles.shape))


@njit(cache=True, nogil=True)
def _interpolated(table: ComplexArray, angle: Array) -> Any:
    """Table over one turn at each angle, shape (n,)."""
    out = np.empty(angle.size, np.complex128)
    for k in range(angle.size):
        place = angle[k] % TURN * (SIZE / TURN)
        below = int(place)
        part = place - below
        out[k] = (1 - part) * table[below % SIZE] + part * table[(below + 1) % SIZE]
    return out


@njit(cache=True, nogil=True)
def _place_of_width(width: float) -> float:
    """Where a width stands among those of the smoothed tables."""
    return min(max(math.log(width / _NARROWEST_RAD) / _WIDTH_STEP, 0.0), _N_WIDTHS - 1.001)


@njit(cache=True, nogil=True)
def _means(smooth: ComplexArray, angle: Array, width: Array) -> Any:
    """Smoothed tables (70, 16384) at each angle, between the two of the nearest widths, shape (n,)."""
    out = np.empty(angle.size, np.complex128)
    for k in range(angle.size):
        place = angle[k] % TURN * (SIZE / TURN)
        below = int(place)
        part, above, below = place - below, (below + 1) % SIZE, below % SIZE
        wide = _place_of_width(width[k])
        narrower = int(wide)
        first = (1 - part) * smooth[narrower, below] + part * smooth[narrower, above]
        second = (1 - part) * smooth[narrower + 1, below] + part * smooth[narrower + 1, above]
        out[k] = first + (wide - narrower) * (second - first)
    return out
