"""Bands of rows of an image: what a shutter that is closed while a part of the rows is read shows in some of them alone."""

import numpy as np

from irtiming.records.arrays import Ticks

_N_BANDS = 16


def starts(n_rows: int) -> Ticks:
    """First row of each band, shape (n_band,): 16 of about the same height, or each row where there are fewer."""
    return np.unique(np.linspace(0, n_rows, _N_BANDS + 1).astype(np.int64)[:-1])
