"""Pixels of the opening that do not follow the wheel, and who stands in for them."""

import numpy as np
from scipy import ndimage

from irtiming.records.arrays import Array, Mask, Pixels

_LEAST_CONTRAST = 0.5  # of that around
_MOST_CONTRAST = 2.0
_NOISY = 4.0  # times the usual scatter against the neighbours
_FELT = 0.03  # of the contrast: less scatter does no harm
_MOST_BAD = 0.25  # of a row
_RING = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], bool)


def find(live: Pixels | Array, contrast: Array, *, mask: Mask, summed: Mask) -> Mask:
    """Dead, stuck and blinking pixels among those that are summed.

    Parameters
    ----------
    live
        Frames that show the scene, shape (frame, row, column).
    contrast
        Shape (row, column); how much each pixel follows the wheel, about 1 within the opening.
    mask, summed
        The opening, and the opening with its blurred border.
    """
    rows, columns = np.flatnonzero(summed.any(axis=1)), np.flatnonzero(summed.any(axis=0))
    box = np.s_[max(rows[0] - 2, 0) : rows[-1] + 3, max(columns[0] - 2, 0) : columns[-1] + 3]
    inside, near = mask[box], contrast[box]
    bad = ndimage.binary_erosion(inside, iterations=2) & ((near < _LEAST_CONTRAST) | (near > _MOST_CONTRAST))
    bad |= inside & _stands_out(near)
    beside_bad = ndimage.binary_dilation(bad, np.ones((1, 3), bool))
    bad |= _noisy(live[:, *box], ndimage.binary_erosion(inside, iterations=3) & ~beside_bad)
    found = np.zeros_like(summed)
    found[box] = bad & summed[box]
    return found


def mended(contrast: Array) -> Array:
    """Contrast, shape (row, column), with the pixels that stand out from all neighbours replaced by their median."""
    return np.where(_stands_out(contrast), ndimage.median_filter(contrast, footprint=_RING), contrast)


def weights(wanted: Mask, bad: Mask) -> Array:
    """Weights of 1 for the wanted pixels; that of a bad one goes to its good neighbours, all being read at the same time.

    Where it has none, as among dead rows, it goes to the nearest good ones above and below.

    Parameters
    ----------
    wanted, bad
        Shape (row, column), as the result.
    """
    weight: Array = wanted.astype(float)
    for row, column in np.argwhere(wanted & bad):
        weight[row, column] = 0
        near = (slice(max(0, row - 1), row + 2), slice(max(0, column - 1), column + 2))
        good = ~bad[near]
        if good.any():
            weight[near] += good / good.sum()
        else:
            _lend(weight[:, column], ~bad[:, column], row)
    return weight


def row_weights(wanted: Mask, bad: Mask) -> Array:
    """The same where rows are read at different times: the nearest good ones left and right in its row stand in for a bad one.

    Parameters
    ----------
    wanted, bad
        Shape (row, column), as the result.
    """
    weight: Array = (wanted & ~bad).astype(float)
    for row, column in np.argwhere(wanted & bad):
        _lend(weight[row], ~bad[row], column)
    return weight


def _lend(weight: Array, good: Mask, place: int) -> None:
    """Give a weight of 1 to the nearest good ones on either side of a place along a line, shape (n,) as ``weight``."""
    known = np.flatnonzero(good)
    beside = np.concatenate([known[known < place][-1:], known[known > place][:1]])
    weight[beside] += 1 / max(beside.size, 1)


def hopeless_rows(wanted: Mask, bad: Mask) -> Mask:
    """Rows in which more than a quarter of the wanted pixels are bad, shape (row,): they cannot be summed.

    Parameters
    ----------
    wanted, bad
        Shape (row, column).
    """
    return np.asarray(np.sum(bad & wanted, axis=1) > _MOST_BAD * wanted.sum(axis=1))


def _stands_out(contrast: Array) -> Mask:
    """Pixels far below, or far above, all but two of their neighbours: no blurred image has such."""
    low = ndimage.rank_filter(contrast, 2, footprint=_RING)
    high = ndimage.rank_filter(contrast, -3, footprint=_RING)
    return np.asarray((contrast < low - 0.35) | (contrast > high + 0.5))


def _noisy(live: Pixels | Array, deep: Mask) -> Mask:
    """Pixels deep in the opening that scatter far more against their left and right neighbours than others do.

    The median of the distances: in few frames an edge of the wheel lies between neighbours, or the trail that the lag leaves.
    """
    noisy = np.zeros_like(deep)
    if not deep.any():
        return noisy
    rows, columns = np.flatnonzero(deep.any(axis=1)), np.flatnonzero(deep.any(axis=0))
    box = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    scatter = np.zeros(deep[box].shape)
    for place, row in enumerate(range(rows[0], rows[-1] + 1)):
        values = live[:, row, columns[0] - 1 : columns[-1] + 2].astype(np.float32)
        beside = values[:, 1:-1] - 0.5 * (values[:, :-2] + values[:, 2:])
        scatter[place] = np.median(np.abs(beside - np.median(beside, axis=0)), axis=0)
    usual = float(np.median(scatter[deep[box]]))
    swing = float(np.ptp(live[:, deep].mean(axis=1)))
    loudest = scatter >= ndimage.maximum_filter(scatter, size=(1, 3))
    noisy[box] = loudest & (scatter > max(_NOISY * usual, _FELT * swing)) & deep[box]
    return noisy
