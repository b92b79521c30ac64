"""Where the search for the opening in a contrast image begins: what its brightest region and the phases there say at once."""

import numpy as np
from scipy import ndimage

from irtiming.estimate import contrast_look
from irtiming.estimate.contrast_look import Look
from irtiming.estimate.sector_image import GLARE_PX, NUMBERS, View
from irtiming.records.arrays import Array, Mask

_CENTRE_STEPS = 9
_FIRST_BLUR_PX = 0.7
_CUTOUT_MARGIN_PX = 1.5


def first_guess(look: Look, view: View) -> dict[str, float]:
    """Sector about the centre that makes the phases twice the polar angles, as large as the pixels of more than half contrast.

    Of several such regions the largest is the opening: a wheel that mirrors the camera may swing as much beside it.
    """
    told = view.good | ~view.good.any(axis=1, keepdims=True)  # dead rows show what those beside them do
    size = ndimage.median_filter(np.where(told, np.abs(look.projection), 0.0), 3)
    mask = _largest(contrast_look.is_bright(size) & view.summed & told)
    row, column = (np.broadcast_to(place, mask.shape)[mask] for place in (view.rows, view.columns))
    sense = -1.0 if view.mirrored else 1.0
    centre = _phase_centre(row, sense * column, np.asarray(-np.angle(look.projection[mask]), dtype=float))
    down, across = row - centre[0], sense * column - centre[1]
    middle = float(np.arctan2(down.mean(), across.mean()))
    radius = np.hypot(down, across)
    inner, outer = (float(r) for r in np.quantile(radius, [0.005, 0.995]))
    angle = min(2 * mask.sum() / max(outer**2 - inner**2, 1.0), 3.0)
    turned = look.projection[mask] * look.point.values(np.arctan2(down, across) - middle).conj()
    return dict.fromkeys(NUMBERS, 0.0) | {
        "axle_row_px": float(centre[0]),
        "axle_column_px": sense * float(centre[1]),
        "inner_radius_px": inner,
        "outer_radius_px": outer,
        "bisector_rad": middle,
        "opening_angle_rad": angle,
        "blur_px": _FIRST_BLUR_PX,
        "glare_px": GLARE_PX,
        "turn_rad": float(np.angle(np.sum(turned))) / 2,
        "ring_inner_px": max(0.0, inner - _CUTOUT_MARGIN_PX),
        "ring_outer_px": outer + _CUTOUT_MARGIN_PX,
        "plate_reflection": 0.5,
    }


def _largest(mask: Mask) -> Mask:
    """The largest of its connected regions."""
    numbers, n = ndimage.label(mask, np.ones((3, 3)))
    return np.asarray(numbers == 1 + np.argmax(np.bincount(numbers.ravel(), minlength=n + 1)[1:])) if n else mask


def _phase_centre(row: Array, column: Array, phase: Array) -> Array:
    """Row and column of the point about which the phases are twice the polar angles, searched finer and finer."""
    centre, reach = np.array([row.mean(), column.mean()]), float(np.ptp(row) + np.ptp(column))
    while reach > 0.1:
        steps = np.linspace(-reach, reach, _CENTRE_STEPS)
        trials = [centre + np.array([a, b]) for a in steps for b in steps]
        match = [abs(np.mean(np.exp(1j * (phase - 2 * np.arctan2(row - r, column - c))))) for r, c in trials]
        centre, reach = trials[int(np.argmax(match))], reach * 0.4
    return centre
