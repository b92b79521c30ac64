"""Where the search for the opening in a contrast image begins: what its brightest region and the phases there say at once."""

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy import ndimage
from scipy.optimize import least_squares

from irtiming.estimate import contrast_look
from irtiming.estimate.contrast_look import Look
from irtiming.estimate.sector_image import GLARE_PX, NUMBERS, View
from irtiming.records.arrays import Array, ComplexArray, Mask

_CENTRE_STEPS = 9
_MOST_TRIED = 4000  # pixels, of which the place is guessed
_FIRST_BLUR_PX = 0.7
_CUTOUT_MARGIN_PX = 1.5


@final
@dataclass(frozen=True, kw_only=True)
class _Place:
    """Of the axle, as the phases have it, and by how much they advance from row to row."""

    row_px: float
    column_px: float
    row_turn_rad: float


def first_guess(look: Look, view: View, *, is_rolling: bool = False) -> dict[str, float]:
    """Sector about the centre that makes the phases twice the polar angles, as large as the pixels of more than half contrast.

    Of several such regions the largest is the opening: a wheel that mirrors the camera may swing as much beside it. Only of a
    camera that ``is_rolling`` may the phases advance from row to row too.
    """
    told = view.good | ~view.good.any(axis=1, keepdims=True)  # dead rows show what those beside them do
    size = ndimage.median_filter(np.where(told, np.abs(look.projection), 0.0), 3)
    mask = _largest(contrast_look.is_bright(size) & view.summed & told)
    row, column = (np.broadcast_to(place, mask.shape)[mask] for place in (view.rows, view.columns))
    sense = -1.0 if view.mirrored else 1.0
    phase = np.asarray(-np.angle(look.projection[mask]), dtype=float)
    place = _phase_place(row, sense * column, phase, is_rolling=is_rolling)
    down, across = row - place.row_px, sense * column - place.column_px
    middle = float(np.arctan2(down.mean(), across.mean()))
    radius = np.hypot(down, across)
    inner, outer = (float(r) for r in np.quantile(radius, [0.005, 0.995]))
    angle = min(2 * mask.sum() / max(outer**2 - inner**2, 1.0), 3.0)
    turned = (
        np.exp(1j * place.row_turn_rad * row)
        * look.projection[mask]
        * look.point.values(np.arctan2(down, across) - middle).conj()
    )
    return dict.fromkeys(NUMBERS, 0.0) | {
        "axle_row_px": place.row_px,
        "axle_column_px": sense * place.column_px,
        "inner_radius_px": inner,
        "outer_radius_px": outer,
        "bisector_rad": middle,
        "opening_angle_rad": angle,
        "blur_px": _FIRST_BLUR_PX,
        "glare_px": GLARE_PX,
        "row_delay_s": -place.row_turn_rad / (2 * look.omega),
        "turn_rad": float(np.angle(np.sum(turned))) / 2,
        "ring_inner_px": max(0.0, inner - _CUTOUT_MARGIN_PX),
        "ring_outer_px": outer + _CUTOUT_MARGIN_PX,
        "plate_reflection": 0.5,
    }


def _largest(mask: Mask) -> Mask:
    """The largest of its connected regions."""
    numbers, n = ndimage.label(mask, np.ones((3, 3)))
    return np.asarray(numbers == 1 + np.argmax(np.bincount(numbers.ravel(), minlength=n + 1)[1:])) if n else mask


def _phase_place(row: Array, column: Array, phase: Array, *, is_rolling: bool) -> _Place:
    """The place about which the phases are twice the polar angles: the best of a grid, finer and finer, then least squares."""
    some = slice(None, None, -(-row.size // _MOST_TRIED))
    row, column, seen = row[some], column[some], np.exp(1j * phase[some])
    middle, reach = np.array([row.mean(), column.mean()]), float(np.ptp(row) + np.ptp(column))
    down, extent = row - middle[0], max(float(np.ptp(row)), 1.0)

    def off(centre: Array) -> ComplexArray:
        return np.asarray(seen * np.exp(-2j * np.arctan2(row - centre[0], column - centre[1])))

    def misfit(at: Array) -> Array:
        left = off(at[:2]) * np.exp(-1j * (at[2] + at[3] * down / extent)) - 1
        return np.concatenate([left.real, left.imag, at[3:]])  # no more of the last than phases ask for

    centre = middle
    while reach > 0.1:
        steps = np.linspace(-reach, reach, _CENTRE_STEPS)
        trials = [centre + np.array([a, b]) for a in steps for b in steps]
        match = [abs(np.mean(off(one))) for one in trials]
        centre, reach = trials[int(np.argmax(match))], reach * 0.4
    if not is_rolling:
        return _Place(row_px=float(centre[0]), column_px=float(centre[1]), row_turn_rad=0.0)
    found = least_squares(misfit, [*centre, np.angle(np.mean(off(centre))), 0.0], x_scale=[1.0, 1.0, 0.01, 0.01]).x
    return _Place(row_px=float(found[0]), column_px=float(found[1]), row_turn_rad=float(found[3]) / extent)
