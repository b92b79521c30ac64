r"""A camera's own noise filter, recursive in time: each frame that it gives holds a share of the one before.

.. math:: y_n = (1 - k)\,x_n + k\,y_{n-1}

What a pixel sees repeats with the wheel angle, and the wheel turns on by the same step :math:`\delta` from one frame to the next,
so harmonic m of what the camera gives is harmonic m of what its pixels saw times

.. math:: G_m = (1 - k) \sum_{j \ge 0} k^j e^{-i m j \delta} = \frac{1 - k}{1 - k\,e^{-i m \delta}},
          \qquad \frac{\partial G_m}{\partial k} = \frac{e^{-i m \delta} - 1}{(1 - k\,e^{-i m \delta})^2}

What a frame shows is on average :math:`k / (1 - k)` frames old. Where the step is small, or nearly a whole number of turns, that
is all that the filter does, a turn of all harmonics as by a delay: :math:`G_m \to e^{-i m \delta k / (1 - k)}`. Where it is
whole, the frames say nothing of the filter: :math:`G_m = 1` for every k.

A slope leaves echoes of itself one step, two steps, ... later. A lag leaves a tail that has gone after some time constants: the
two are distinguished where a frame lasts longer than the lag.

The recursion runs over frames that the camera made, whether or not they arrived. Of two frames that followed each other it can be
undone without knowing any other: :math:`x_n = (y_n - k\,y_{n-1}) / (1 - k)`.
"""

import numpy as np

from irtiming.records.arrays import Array, ComplexArray, Mask, Ticks

PARAMETER = "recursive_filter"

LOOKED_AT: tuple[float, ...] = (0.0, 0.25, 0.5)
"""Shares k from which a search begins; cameras offer up to about one half."""

U_SHARE = 0.5
"""Standard uncertainty of a share that nobody states: it is as somebody has set it, and cameras offer up to about one half."""

_MOST_PERIODS = 1.5  # between two triggers, the second of which follows the first


def transfer(step_rad: float, share: float, *, n_harmonics: int) -> ComplexArray:
    """What the filter leaves of each harmonic: (1 - k) / (1 - k exp(-i m step)), shape (M + 1,)."""
    return np.asarray((1 - share) / (1 - share * _one_frame(step_rad, n_harmonics)))


def transfer_slope(step_rad: float, share: float, *, n_harmonics: int) -> ComplexArray:
    """Derivative of `transfer` to k, shape (M + 1,)."""
    turn = _one_frame(step_rad, n_harmonics)
    return np.asarray((turn - 1) / (1 - share * turn) ** 2)


def mean_age(share: float) -> float:
    """By how many frames what a frame shows is older than it, on average: k / (1 - k), for a share k below 1."""
    return share / (1 - share)


def mean_age_slope(share: float) -> float:
    """Derivative of `mean_age` to k."""
    return (1 - share) ** -2


def undone(values: Array, share: float, *, follows: Mask) -> Array:
    """Values as the pixels saw them, of frames that follow the one before.

    Parameters
    ----------
    values
        Shape (n, ...), as the camera gave them, frames in the order of their triggers.
    share
        k.
    follows
        Shape (n,), true for frames whose predecessor is the camera's frame before; not for the first.

    Returns
    -------
    Shape (number of ``follows``, ...).
    """
    at = np.flatnonzero(follows)
    return np.asarray((values[at] - share * values[at - 1]) / (1 - share))


def follows(trigger_ticks: Ticks) -> Mask:
    """Which frames were triggered next after the one before, shape (n,); the first was not.

    Parameters
    ----------
    trigger_ticks
        Shape (n,), periodic but for triggers whose frames were lost.
    """
    period = np.diff(trigger_ticks)
    return np.concatenate([[False], period < _MOST_PERIODS * np.median(period)])


def _one_frame(step_rad: float, n_harmonics: int) -> ComplexArray:
    """Each harmonic one frame earlier: exp(-i m step), shape (M + 1,)."""
    return np.exp(-1j * np.arange(n_harmonics + 1) * step_rad)
