"""What the pixels of image rows add to the harmonics of their rows, each about its own polar angle."""

import numpy as np
from numba import njit

from irtiming.records.arrays import Array, ComplexArray


def by_row(light: Array, angle_rad: Array, *, smear: Array, n_harmonics: int) -> ComplexArray:
    """Waves exp(-i m phi) of each row's pixels, added up, shape (n_row, M + 1).

    Parameters
    ----------
    light
        Of each pixel, px^2, shape (n_row, n_column).
    angle_rad
        Polar angle of each, the same shape.
    smear
        What its width and the blur leave of the first order (`blurred_sector.pixel_smear`), the same shape; of order m they
        leave the m^2th power.
    n_harmonics
        Highest order M.
    """
    out = np.zeros((len(light), n_harmonics + 1), complex)
    _add_by_row(light, np.exp(-1j * angle_rad), smear, out)
    return out


@njit(cache=True, nogil=True)
def _add_by_row(light: Array, turn: ComplexArray, smear: Array, out: ComplexArray) -> None:
    """See by_row; added to ``out`` (n_row, M + 1)."""
    for row in range(light.shape[0]):
        for column in range(light.shape[1]):
            if light[row, column] == 0.0:
                continue
            wave, once = complex(light[row, column]), smear[row, column]
            step = turn[row, column] * once
            for order in range(out.shape[1]):
                out[row, order] += wave
                wave *= step
                step *= once * once
