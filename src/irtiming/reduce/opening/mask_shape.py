"""The shape of a mask opening in an image: its one part, its blurred border, the box around it."""

import numpy as np
from scipy import ndimage

from irtiming.errors import ReductionError
from irtiming.records.arrays import Array, Mask
from irtiming.records.reduced import Region

_LARGEST_BORDER_PX = 16
_PLATE = 0.1  # of the contrast: more than the mask plate around the opening should show
_FLAT = 0.003  # of the contrast per pixel: less is no blur any more
_MOST_PLATE = 0.02  # per pixel that is laid on the plate rather than on the blur


def largest_part(mask: Mask) -> Mask:
    """The largest connected part of a mask, same shape."""
    labels, n = ndimage.label(mask)
    if n == 0:
        return mask
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    return np.asarray(labels == sizes.argmax())


def is_in_place(mask: Mask, before: Mask) -> bool:
    """Whether two masks, shape (row, column), differ by no more than single pixels of their border."""
    if mask.shape != before.shape:
        return False
    union = mask | before
    border = union & ~ndimage.binary_erosion(union)
    return bool(np.sum(mask ^ before) <= 0.25 * border.sum())


def border_px(contrast: Array, mask: Mask, *, plate: float = 0.0) -> int:
    """Width of the blurred border, px: where the mean contrast of a ring no longer falls.

    It may level off above zero: where the mask plate is not as warm as the wheel, it shows around the opening.

    Parameters
    ----------
    contrast
        Shape (row, column); 1 within the opening, about 0 outside.
    mask
        Pixels at more than half of the contrast, same shape.
    plate
        What the mask plate shows around the opening; the edges of that are no blur of the opening.
    """
    distance = ndimage.distance_transform_edt(~mask)
    n_rings = min(_LARGEST_BORDER_PX + 4, int(distance.max()))
    rings = [float(contrast[(distance > k) & (distance <= k + 1)].mean()) for k in range(n_rings)]
    steps = np.abs(np.diff(rings))
    flat = max(_FLAT, 2 * float(np.median(steps[-6:])), min(plate, _MOST_PLATE))
    for k in range(min(_LARGEST_BORDER_PX, n_rings - 2)):
        if abs(rings[k]) < _PLATE and steps[k] < flat and steps[k + 1] < flat:
            return k + 2
    return _LARGEST_BORDER_PX


def box(mask: Mask, *, margin: int, name: str) -> Region:
    """The box around a mask, shape (row, column), with a margin, as far as the image has room.

    Raises
    ------
    ReductionError
        If the mask comes within 2 pixels of the image's border.
    """
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    n_rows, n_columns = mask.shape
    if rows[0] < 2 or columns[0] < 2 or rows[-1] > n_rows - 3 or columns[-1] > n_columns - 3:
        raise ReductionError(
            f"{name}: the opening spans rows {rows[0]}..{rows[-1]} and columns {columns[0]}..{columns[-1]} of a "
            f"{n_rows} x {n_columns} image and is cut by its border; the whole opening with 2 pixels around it must be in view"
        )
    return (
        max(0, int(rows[0]) - margin), min(n_rows, int(rows[-1]) + margin + 1),
        max(0, int(columns[0]) - margin), min(n_columns, int(columns[-1]) + margin + 1),
    )  # fmt: skip


def check_roi(roi: Region, mask: Mask, *, name: str) -> None:
    """Refuse a region of interest outside the image, or one that leaves out part of the mask, shape (row, column).

    Raises
    ------
    ReductionError
        Saying which.
    """
    n_rows, n_columns = mask.shape
    if not (0 <= roi[0] < roi[1] <= n_rows and 0 <= roi[2] < roi[3] <= n_columns):
        raise ReductionError(
            f"{name}: region of interest {roi} lies outside the image of {n_rows} rows and {n_columns} columns; "
            "give first row, end row, first column, end column"
        )
    outside = int(mask.sum() - mask[roi[0] : roi[1], roi[2] : roi[3]].sum())
    if outside:
        raise ReductionError(
            f"{name}: region of interest {roi} leaves out {outside} of {mask.sum()} pixels of the opening; "
            "it must hold the whole opening"
        )
