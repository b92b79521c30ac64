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
    seen = _Seen(contrast, inside, beside)
    least, most = _MIRRORS
    best = float(minimize_scalar(seen.misfit, bounds=_MIRRORS, method="bounded", options={"xatol": 1e-3}).x)
    middle = float(np.clip(best, least + _TELLING, most - _TELLING))
    low, centre, high = (seen.misfit(middle + step) for step in (-_TELLING, 0.0, _TELLING))
    bend = max((high - 2 * centre + low) / _TELLING**2, 0.0)
    u = 1 / np.sqrt(bend / 2 / seen.noise_variance(centre) + 1)
    share = seen.share(best)
    other = best + u if best + u <= most else best - u
    return share, seen.share(max(other, least)) - share


@final
class _Seen:
    """Pixels that tell, and the hills over all pixels, counted from their mean inside the opening."""

    def __init__(self, contrast: Array, inside: Mask, beside: Mask) -> None:
        rows, columns = (np.arange(n, dtype=float) for n in contrast.shape)
        hills = smooth_field.hills(rows, columns, steps=_STEPS)
        self._hills = hills - hills[:, inside].mean(axis=1)[:, None, None]
        self._contrast = contrast
        self._known = inside | beside
        self._inside = inside[self._known].astype(float)
        self._firm = np.append(np.full(len(hills), _FLATNESS), [0.0, _FIRMNESS])

    def misfit(self, mirroring: float) -> float:
        """Sum of squares that is left, prior knowledge included."""
        found, terms = self._fit(mirroring)
        left = self._contrast[self._known] - found @ terms
        beyond = np.append(found[:-1], found[-1] - 1)
        return float(left @ left + self._firm @ beyond**2 + self.noise_variance(float(left @ left)) * mirroring**2)

    def noise_variance(self, squares: float) -> float:
        """Of a pixel, from the sum of squares of all."""
        return float(max(squares / self._inside.size, np.finfo(float).tiny))

    def share(self, mirroring: float) -> Array:
        """Of each pixel."""
        found, _ = self._fit(mirroring)
        field = np.einsum("k,kij->ij", found[:-2], self._hills)
        plate = found[-2] + (1 - mirroring) * field
        return np.asarray((self._contrast - plate) / (found[-1] + mirroring * field))

    def _fit(self, mirroring: float) -> tuple[Array, Array]:
        """Heights of the hills, plate and step; and what each makes of the pixels that tell."""
        mirrored = self._inside + (1 - mirroring) * (1 - self._inside)
        terms = np.vstack([self._hills[:, self._known] * mirrored, np.ones(self._inside.size), self._inside])
        target = terms @ self._contrast[self._known]
        target[-1] += self._firm[-1]
        return np.linalg.solve(terms @ terms.T + np.diag(self._firm), target), terms
