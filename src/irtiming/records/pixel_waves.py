"""Sums over frames that tell the timing of every pixel."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.records.arrays import Array, Ticks
from irtiming.records.short_repr import short_repr


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PixelWaves:
    """Sums over the kept frames of one recording of waves over the wheel angle times the value of each pixel.

    Parameters
    ----------
    signal_orders, quiet_orders
        Shapes (s,) and (q,); orders m of `physics.wheel_waves` that show the wheel, and those that show noise alone.
    wheel_angle_rad, segment
        Shape (n,); angle of each kept frame with which the waves were made, and number of its stretch.
    row_px, column_px
        Shape (p,); places of the pixels.
    sums_dn
        Shape (2 (s + q), p); cosines of the signal and the quiet orders, then sines, times the value, drift removed, DN.
    """

    __repr__ = short_repr

    signal_orders: Ticks
    quiet_orders: Ticks
    wheel_angle_rad: Array
    segment: Ticks
    row_px: Ticks
    column_px: Ticks
    sums_dn: Array

    @property
    def orders(self) -> Ticks:
        """Signal orders, then quiet ones, shape (s + q,)."""
        return np.concatenate([self.signal_orders, self.quiet_orders])
