r"""A photon detector's pixel may keep a share of the charge of the frame before (suspected in Schatz 2023, 3.1.5).

.. math:: f_n = (1 - s)\,F_n + s\,F_{n-1}, \qquad G_m = 1 - s\,(1 - e^{-i m \delta}), \qquad
          \frac{\partial G_m}{\partial s} = e^{-i m \delta} - 1

with :math:`F_n` what the pixel saw in frame n, and :math:`\delta` the step of the wheel from frame to frame: one echo of each
slope, a frame later. To first order in s it is the recursive filter of `physics.response.in_camera_filter`; a mean of two frames
is s = 1/2.
"""

import numpy as np

from irtiming.records.arrays import ComplexArray

PARAMETER = "pixel_memory"

LOOKED_AT: tuple[float, ...] = (0.0,)
"""Shares s from which a search begins."""

U_SHARE = 0.05
"""Standard uncertainty of a share that nobody states: such detectors keep a hundredth at most.

It decides only where the frames hardly tell a memory, as where the wheel turns by a quarter from one to the next: each slope then
stands on the echo of the one before it, and a search that knows nothing may end at any share.
"""


def transfer(step_rad: float, share: float, *, n_harmonics: int) -> ComplexArray:
    """What the memory leaves of each harmonic: 1 - s (1 - exp(-i m step)), shape (M + 1,)."""
    return np.asarray(1 + share * transfer_slope(step_rad, share, n_harmonics=n_harmonics))


def transfer_slope(step_rad: float, share: float, *, n_harmonics: int) -> ComplexArray:
    """Derivative of `transfer` to s, whatever ``share``: exp(-i m step) - 1, shape (M + 1,)."""
    del share
    return np.asarray(np.exp(-1j * np.arange(n_harmonics + 1) * step_rad) - 1)
