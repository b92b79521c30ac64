r"""What a detector whose response is not a straight line adds to the sum over an image row, and its derivatives.

A pixel that would show the share w of its contrast, 0 covered and 1 open, shows

.. math:: w + b\, e + c\, d, \qquad e = w (1 - w), \quad d = w (1 - w) (1 - 2 w)

which is any smooth response up to its third order, its ends kept. A pixel of another contrast a goes along a part of the curve:
one on the border of the opening from the covered end on, as the wheel is as warm everywhere, one that the wheel mirrors otherwise
up to the open end. With g the contrast that it would have wholly in the light, it goes from 1 - g to 1 - g + a. Then there are
left :math:`a^2 e` of the one, :math:`a^3 d + 3 a^2 (2 g - 1 - a) e` of the other, and more or less gain, which the contrast image
shows as light. Added up over the pixels of row y at their polar angles :math:`\phi`, harmonic m grows by

.. math:: b\, P_2 e_m + c\, (P_3 d_m + Q\, e_m), \qquad P_n = \sum a^n e^{-i m \phi}, \quad
    Q = 3 \sum a^2 (2 g - 1 - a) e^{-i m \phi}

What smears a pixel's wave before it is bent, its width and the blur, is taken as one for each row.

A pixel that is either covered or open shows nothing of b and c: a photon camera's, but for the moment in which an edge crosses
it. One that lags is nearly always in between. With cutouts a quarter of a turn wide a lag leaves w - 1/2 odd about half a turn of
its second order: e is even, and looks like edges that uncover late and cover early; d is odd, and looks like another lag.
"""

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy import fft

from irtiming.records.arrays import Array, ComplexArray

QUADRATIC, CUBIC = "quadratic_nonlinearity", "cubic_nonlinearity"
NONLINEARITIES = (QUADRATIC, CUBIC)
"""b and c."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PixelPowers:
    """Powers of what each row's pixels show: P_2, P_3 and Q, shape (n_row, M + 1); what smears a pixel, (n_row,).

    ``smear`` is what is left of the first order, as of `blurred_sector.pixel_smear`; of order m it leaves the m^2th power.
    """

    squares: ComplexArray
    cubes: ComplexArray
    askew: ComplexArray
    smear: Array

    def some(self, rows: slice | None = None, *, n_harmonics: int | None = None) -> "PixelPowers":
        """The same with fewer rows, or fewer harmonics."""
        rows, keep = rows or slice(None), slice(None if n_harmonics is None else n_harmonics + 1)
        squares, cubes, askew = (one[rows, keep] for one in (self.squares, self.cubes, self.askew))
        return PixelPowers(squares=squares, cubes=cubes, askew=askew, smear=self.smear[rows])


def bends(pixels: PixelPowers, wave: ComplexArray) -> ComplexArray:
    """Harmonics that a row gains per unit of `NONLINEARITIES`, shape (2, n_row, M + 1).

    Parameters
    ----------
    pixels
        Of the rows.
    wave
        Harmonics of w, shape (M + 1,).
    """
    seen = _in_time(wave, pixels)
    return _of_rows(pixels, seen - seen**2, seen - 3 * seen**2 + 2 * seen**3)


def bends_slopes(pixels: PixelPowers, wave: ComplexArray, *, slopes: ComplexArray) -> ComplexArray:
    """Derivatives of `bends` to what w depends on, shape (2, k, n_row, M + 1).

    Parameters
    ----------
    pixels, wave
        As for `bends`.
    slopes
        Derivatives of the wave's harmonics, shape (k, M + 1).
    """
    seen, change = _in_time(wave, pixels), _in_time(slopes[:, None], pixels)
    return _of_rows(pixels, (1 - 2 * seen) * change, (1 - 6 * seen + 6 * seen**2) * change)


def _in_time(wave: ComplexArray, pixels: PixelPowers) -> Array:
    """A wave over a turn as a pixel of each row sees it, (..., n_row, n), so often that no order of a cube looks like a lower."""
    orders = wave.shape[-1]
    n = int(fft.next_fast_len(4 * orders, real=True))
    half = wave * pixels.smear[:, None] ** np.arange(orders) ** 2 / 2
    half[..., 0] *= 2
    return np.asarray(fft.irfft(half, n=n) * n)


def _of_rows(pixels: PixelPowers, even: Array, odd: Array) -> ComplexArray:
    """What rows gain of a pixel's e and d over a turn, (..., n_row, n) each."""
    e, d = (fft.rfft(one)[..., : pixels.squares.shape[1]] * (2 / one.shape[-1]) for one in (even, odd))
    e[..., 0], d[..., 0] = e[..., 0] / 2, d[..., 0] / 2
    return np.array([pixels.squares * e, pixels.cubes * d + pixels.askew * e])
