"""What share of each pixel is in the mask opening, where the wheel mirrors the camera and the plate is not as warm as the wheel.

A pixel swings with the wheel by what it sees when the wheel is open, less the solid wheel. Inside the opening that is

    step + plate + field(x),

on the plate beside it

    plate + (1 - mirroring) field(x).

The field is what the solid wheel mirrors of the camera: smooth, made of broad hills. The plate mirrors it too, ``mirroring``
times as well. The field counts from its mean inside, so that step and plate are numbers.
"""

from typing import final

import numpy as np
from scipy.optimize import minimize_scalar

from irtiming.physics import smooth_field
from irtiming.records.arrays import Array, Mask

_STEPS = 10  # of the hills from end to end: the mirror image of a small aperture is a narrow one
_FLATNESS = 1e-2  # squared noise of a pixel over squared height of a hill
_FIRMNESS = 1e-4  # the step is about all of the contrast, should no pixel of the plate tell
_MIRRORS = (0.0, 1.0)  # a plate as black as can be, and one as bright as the wheel
_ODD = 10  # times the median deviation: a screw beside the opening, a pixel whose gain is not what it was
_TELLING = 0.05  # change of the mirroring over which its likelihood is taken for a parabola


def of_pixels(contrast: Array, *, inside: Mask, beside: Mask) -> tuple[Array, Array]:
    """Share of each pixel that is in the opening, 0 on the plate beside it and 1 within, and how sure the plate's part in it is.

    Parameters
    ----------
    contrast
        By how much each pixel swings, shape (roi rows, roi columns); about 1 inside the opening.
    inside, beside
        Pixels within the opening and on the plate, none of them blurred over the border; same shape.

    Returns
    -------
    The shares, and by how much they change with one standard uncertainty of the mirroring; both of the shape of ``contrast``.
    """
    seen, best = _fitted(contrast, inside, beside)
    off = np.abs(seen.share(best) - inside)
    usual = off <= _ODD * np.median(off[inside | beside])
    seen, best = _fitted(contrast, inside & usual, beside & usual)
    least, most = _MIRRORS
    middle = float(np.clip(best, least + _TELLING, most - _TELLING))
    low, centre, high = (seen.misfit(middle + step) for step in (-_TELLING, 0.0, _TELLING))
    u = np.sqrt(2 * centre / seen.n_pixels / max((high - 2 * centre + low) / _TELLING**2, np.finfo(float).tiny))
    share = seen.share(best)
    other = best + u if best + u <= most else best - u
    return share, seen.share(float(np.clip(other, least, most))) - share


@final
class _Seen:
    """Sums over the pixels that tell: their products with the hills, which count from their mean inside the opening."""

    def __init__(self, contrast: Array, inside: Mask, beside: Mask) -> None:
        self._contrast = contrast
        self._along = tuple(smooth_field.along(np.arange(n, dtype=float), steps=_STEPS) for n in contrast.shape)
        hills = self._hills(inside)
        self._mean = hills.mean(axis=1, keepdims=True)
        within = np.vstack([hills - self._mean, np.ones((2, inside.sum()))])
        plate = np.vstack([self._hills(beside) - self._mean, np.ones(beside.sum()), np.zeros(beside.sum())])
        self._within, self._plate = within @ within.T, plate @ plate.T
        self._seen_within, self._seen_on_plate = within @ contrast[inside], plate @ contrast[beside]
        self._squares = float(contrast[inside] @ contrast[inside] + contrast[beside] @ contrast[beside])
        self._firm = np.append(np.full(len(self._mean), _FLATNESS), [0.0, _FIRMNESS])
        self.n_pixels = int(inside.sum() + beside.sum())

    def misfit(self, mirroring: float) -> float:
        """Sum of squares that is left; a mirroring of 1 is as unlikely beforehand as one u."""
        found, target = self._fit(mirroring)
        left = self._squares + self._firm[-1] - found @ target
        return float(left * (1 + mirroring**2 / self.n_pixels))

    def share(self, mirroring: float) -> Array:
        """Of each pixel."""
        found, _ = self._fit(mirroring)
        along_rows, along_columns = self._along
        heights = found[:-2].reshape(len(along_rows), len(along_columns))
        field = along_rows.T @ heights @ along_columns - found[:-2] @ self._mean
        plate = found[-2] + (1 - mirroring) * field
        return np.asarray((self._contrast - plate) / (found[-1] + mirroring * field))

    def _hills(self, pixels: Mask) -> Array:
        """Shape (n_hill, n_pixel)."""
        along_rows, along_columns = (along[:, at] for along, at in zip(self._along, np.nonzero(pixels), strict=True))
        hills = along_rows[:, None] * along_columns
        return np.asarray(hills.reshape(len(along_rows) * len(along_columns), hills.shape[-1]))

    def _fit(self, mirroring: float) -> tuple[Array, Array]:
        """Heights of the hills, plate and step; and the right-hand side of the normal equations."""
        fainter = np.append(np.full(len(self._mean), 1 - mirroring), [1.0, 1.0])
        normal = self._within + fainter[:, None] * self._plate * fainter + np.diag(self._firm)
        target = self._seen_within + fainter * self._seen_on_plate
        target[-1] += self._firm[-1]
        return np.linalg.solve(normal, target), target


def _fitted(contrast: Array, inside: Mask, beside: Mask) -> tuple[_Seen, float]:
    """The pixels that tell, and the mirroring of the plate with which the least is left."""
    seen = _Seen(contrast, inside, beside)
    return seen, float(minimize_scalar(seen.misfit, bounds=_MIRRORS, method="bounded", options={"xatol": 1e-3}).x)
