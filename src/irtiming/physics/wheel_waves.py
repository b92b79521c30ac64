r"""Waves over the wheel angle on which the frames of each pixel are projected.

Wave m of a recording is the pair :math:`\cos m\theta_n, \sin m\theta_n`, each less its mean over the frames of a stretch between
two shutter events: offsets of pixels and stretches then drop out of any sum of wave times value. What the wheel shows has its
strongest orders at m = 2, 6, 10, ..., since two cutouts pass in a turn and each is as wide as a blade. High orders that are not
among these hold next to nothing of the wheel: they tell the noise of a pixel.
"""

import numpy as np

from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array, Ticks

_FIRST, _APART = 2, 4
_HIGHEST_SIGNAL = 62
_MOST_QUIET = 16


def signal_orders(n_angles: int) -> Ticks:
    """Orders that determine a pixel's timing: 2, 6, 10, ... 62, or as far as so many angles in a turn carry; shape (k,)."""
    return np.arange(_FIRST, min(_HIGHEST_SIGNAL, n_angles // 4) + 1, _APART)


def quiet_orders(n_angles: int) -> Ticks:
    """The highest orders that so many angles tell apart and that hold least of the wheel, at most 16, ascending; shape (k,)."""
    lowest = int(signal_orders(n_angles)[-1]) + 1
    quiet = [m for m in range((n_angles - 1) // 2, lowest, -1) if m % _APART != _FIRST]
    return np.array(sorted(quiet[:_MOST_QUIET]), int)


def waves(wheel_angle_rad: Array, orders: Ticks, *, segment: Ticks) -> Array:
    """Cosines, then sines, less their mean in each stretch; shape (2 k, n).

    Parameters
    ----------
    wheel_angle_rad
        Shape (n,).
    orders
        Shape (k,).
    segment
        Shape (n,); number of the stretch of each frame, from 0.
    """
    phase = np.multiply.outer(orders, np.mod(wheel_angle_rad, TURN))
    made = np.concatenate([np.cos(phase), np.sin(phase)])
    for stretch in range(int(segment.max()) + 1):
        within = segment == stretch
        made[:, within] -= made[:, within].mean(axis=1, keepdims=True)
    return np.asarray(made)
