r"""A microbolometer pixel follows what it sees with a first-order lag (Schatz 2023, eq. 2).

.. math:: \tau \dot T_{pixel} = T_{asympt} - T_{pixel}

Once the run-in has died away, harmonic m of the pixel is harmonic m of the scene times

.. math:: R_m = \frac{1}{1 + i m \omega \tau}

In the time domain this is the exponential that each passing edge leaves behind.
"""

import numpy as np

from irtiming.records.arrays import Array, ComplexArray

PARAMETER = "time_constant"

HARMONICS = 256
"""Highest order that rolling rows need: in frames at a hundred angles of the wheel, what a model leaves out looks like lower
orders. With 64, a time constant of 2.4 ms from two and a half turns was 11 standard uncertainties off."""


def transfer(angular_frequency_rad_per_s: float, time_constant_s: float | Array, *, n_harmonics: int) -> ComplexArray:
    """What the lag leaves of each harmonic: 1 / (1 + i m omega tau), shape (M + 1,); with tau of shape (p, 1), (p, M + 1)."""
    return np.asarray(1 / (1 + 1j * np.arange(n_harmonics + 1) * angular_frequency_rad_per_s * time_constant_s))


def transfer_slope(
    angular_frequency_rad_per_s: float, time_constant_s: float | Array, *, n_harmonics: int
) -> ComplexArray:
    """Derivative of `transfer` to tau: -i m omega times its square, shape (M + 1,) or (p, M + 1), per second."""
    turning = 1j * np.arange(n_harmonics + 1) * angular_frequency_rad_per_s
    return np.asarray(-turning * transfer(angular_frequency_rad_per_s, time_constant_s, n_harmonics=n_harmonics) ** 2)
