r"""A photon detector integrates what it sees over a window and is blind outside it (Schatz 2023, eq. 1).

.. math:: P(t) - P_0 \propto \int_{t + t_{delay}}^{t + t_{delay} + T} I(s)\,ds

Of the mean over the window, counted from its middle :math:`t + t_{delay} + T/2`, harmonic m is that of the scene times

.. math:: R_m = \frac{1}{T} \int_{-T/2}^{T/2} e^{i m \omega s}\,ds = \frac{\sin x}{x}, \qquad x = \frac{m \omega T}{2}

So a delay beside this response is that of the middle; :math:`t_{delay}`, of the start, is half a window earlier. A window that
is short against the slopes shows by :math:`x^2 / 6` alone: frames then say little of its length.

A detector that is slow to forget takes some in after the end: a share s, fading with the time constant :math:`\tau`. What counts
then has its centre later than the middle, and is wider,

.. math:: \Delta = s (T/2 + \tau), \qquad \Delta\sigma^2 = s \left((T/2 + \tau)^2 + \tau^2 - T^2/12\right)

Delays are counted to the centre. Corners of a pixel sum show the width, by what it adds to the variance :math:`T^2/12` of an even
window; of what is beyond (the third moment) the sums of a usual camera tell nothing. By how much the centre is later for so much
width depends on the time constant, which is never known well: so half of the share is a fast tail and half a slow one, each with
an uncertainty of its own.
"""

import numpy as np

from irtiming.records.arrays import Array, ComplexArray
from irtiming.records.rig import Measured, WindowTail

PARAMETER = "integration_time"

HARMONICS = 256
"""Highest order that rolling rows need: no lag dampens them, only blur; with 128 corners stay visible in the residuals."""

_PARTS = {"window_tail_fast": 1 / 3, "window_tail_slow": 5 / 3}  # of the whole tail's time constant
TAILS = tuple(_PARTS)
"""Names of the shares that come after the window's end: each is half of the whole tail."""

_SMALL = 1e-3  # of x, below which the series is exact to rounding


def transfer(
    angular_frequency_rad_per_s: float, integration_time_s: float | Array, *, n_harmonics: int
) -> ComplexArray:
    """What the window leaves of each harmonic about its middle: sin(x) / x, shape (M + 1,); (p, M + 1) of T of (p, 1)."""
    half = np.arange(n_harmonics + 1) * angular_frequency_rad_per_s / 2
    return np.sinc(half * integration_time_s / np.pi).astype(complex)


def transfer_slope(
    angular_frequency_rad_per_s: float, integration_time_s: float | Array, *, n_harmonics: int
) -> ComplexArray:
    """Derivative of `transfer` to T: (cos x - sin(x) / x) / T, shape (M + 1,), per second; 0 for a window of no length."""
    half = np.arange(n_harmonics + 1) * angular_frequency_rad_per_s / 2
    x = half * integration_time_s
    large = np.where(np.abs(x) < _SMALL, 1.0, x)
    slope = np.where(np.abs(x) < _SMALL, -x / 3, (np.cos(large) - np.sinc(large / np.pi)) / large)
    return (half * slope).astype(complex)


def tails(tail: WindowTail) -> dict[str, WindowTail]:
    """The parts of a tail by name, each with a share and a time constant of its own.

    Parameters
    ----------
    tail
        The whole; errors of the parts are independent, and together those of the whole.
    """
    share, n = tail.share, len(_PARTS)
    half = Measured(share.value / n, share.standard_uncertainty / n**0.5)
    return {name: WindowTail(share=half, time_constant_s=part * tail.time_constant_s) for name, part in _PARTS.items()}


def tail_delay_s(integration_time_s: float, time_constant_s: float) -> float:
    """By how much the centre is later than the middle of the window, per share that comes after its end: Delta / s."""
    return integration_time_s / 2 + time_constant_s


def tail_variance_s2(integration_time_s: float, time_constant_s: float) -> float:
    """By how much the variance of what counts grows per share that comes after the window's end, s^2."""
    late_s = tail_delay_s(integration_time_s, time_constant_s)
    return late_s**2 + time_constant_s**2 - integration_time_s**2 / 12
