r"""Rows are read one after the other (Schatz 2023, eq. 3).

.. math:: t_y = t + t_{delay} + y\,t_{row}
"""

import numpy as np

from irtiming.records.arrays import Array

PARAMETERS: tuple[str, ...] = ("row_delay",)


def read_later(row_px: Array) -> Array:
    """By how much later each row is read than row 0, per unit of row delay: y; shape (1, n_row)."""
    return np.asarray(row_px, float)[None]
