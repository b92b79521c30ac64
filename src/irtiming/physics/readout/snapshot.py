"""All rows are read at once: a snapshot has one delay and no parameter of its own (Schatz 2023, 3.1.1)."""

import numpy as np

from irtiming.records.arrays import Array

PARAMETERS: tuple[str, ...] = ()


def read_later(row_px: Array) -> Array:
    """By how much later each row is read than row 0, per unit of each parameter: there is none; shape (0, n_row)."""
    return np.zeros((0, np.size(row_px)))
