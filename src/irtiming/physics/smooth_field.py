"""A smooth field over a part of the image, made of broad Gaussian hills: what a solid wheel mirrors of the camera, say."""

import numpy as np

from irtiming.records.arrays import Array


def hills(rows: Array, columns: Array) -> Array:
    """Gaussian hills on a grid, as wide as its steps; without those a step beyond the region its ends could not be met.

    Parameters
    ----------
    rows, columns
        Places of the region's pixels along each axis, ascending, shape (r,) and (c,).

    Returns
    -------
    Shape (n, r, c); each hill is 1 at its top.
    """
    product = along(rows)[:, None, :, None] * along(columns)[:, None, :]
    return np.asarray(product.reshape(-1, rows.size, columns.size))


def along(places: Array, *, steps: int = 4) -> Array:
    """The hills along one axis.

    Parameters
    ----------
    places
        Ascending, shape (p,).
    steps
        From end to end.

    Returns
    -------
    Shape (steps + 3, p): a product of one along the rows with one along the columns is a hill.
    """
    step = (places[-1] - places[0]) / steps
    tops = places[0] + step * np.arange(-1, steps + 2)
    return np.asarray(np.exp(-0.5 * ((places - tops[:, None]) / step) ** 2))
