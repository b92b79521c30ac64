"""The sector with lens and tilt weighed: what the images say of a warp, and where that takes all numbers (`lens_and_tilt`)."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.estimate import lens_and_tilt, sector_limits
from irtiming.estimate.lens_and_tilt import ImageWord
from irtiming.estimate.sector_best import Best
from irtiming.estimate.sector_image import Sharp
from irtiming.estimate.sector_images import N_PRIORS, Images
from irtiming.estimate.sector_search import LIMITS
from irtiming.inference.lens_knowledge import N_KNOWN
from irtiming.inference.weighed_lens import SLIGHT
from irtiming.physics.blur_shape import EXCHANGES, U_EXCHANGED, exchanged
from irtiming.physics.warp import WARP_NUMBERS
from irtiming.records.arrays import Array
from irtiming.records.estimate import Estimate

_OF_BLUR = ("blur_px", "blur_ellipticity", "glare", "glare_px")  # stay those of a Gaussian; `_reshaped` has the rest
_WARP_STEP_PX = 0.02  # over which what a warp does is taken


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Weighed:
    """All numbers with lens and tilt weighed, the covariance of those that go by ``names``, and lens and tilt themselves.

    ``beside_linear`` is by how much the image there differs from what its slopes foretold, a sum of squares.
    """

    numbers: dict[str, float]
    names: list[str]
    covariance: Array
    camera: Estimate
    beside_linear: float


def weighed(images: Images, best: Best) -> Weighed:
    """Mean and covariance of all that images and what is known allow near the best.

    Parameters
    ----------
    images
        Of one camera in one place.
    best
        Where a search for their numbers ended, with lens and tilt free or near what they are.
    """
    word = _without_camera(images, best)
    last = lens_and_tilt.settled(word, images.view.shape(best.numbers), known=images.lens)
    names = [*(name for name in best.free if name not in SLIGHT), *WARP_NUMBERS]
    n_own = len(names) - len(WARP_NUMBERS)
    at = np.delete(np.arange(last.moved.size), slice(n_own, n_own + len(EXCHANGES)))
    before = np.array([best.numbers[name] for name in names])
    low, high = np.array([LIMITS.get(name, (-np.inf, np.inf)) for name in names]).T
    moved = np.where([name in _OF_BLUR for name in names], 0.0, np.clip(before + last.moved[at], low, high) - before)
    numbers = best.numbers | dict(zip(names, (before + moved).tolist(), strict=True))
    there = np.concatenate([sector_limits.off_usual(numbers), *images.misfit(numbers, images.sharp(numbers))])
    foretold = word.residual[: there.size] + word.jacobian[: there.size, at] @ moved
    return Weighed(
        numbers=numbers,
        names=names,
        covariance=last.covariance[np.ix_(at, at)],
        camera=last.camera,
        beside_linear=float(np.sum((there - foretold) ** 2)),
    )


def _reshaped(images: Images, best: Best) -> list[Array]:
    """What a blur of another shape does to the residual, per standard uncertainty of what is known of it, shape (m,) each."""
    sharp = images.sharp(best.numbers)
    others = (
        [replace(one, sector=exchanged(one.sector, U_EXCHANGED, axis=axis, away=away)) for one in sharp]
        for axis, away in EXCHANGES
    )
    return [_changed(images, best, numbers=best.numbers, sharp=there) for there in others]


def _changed(images: Images, best: Best, *, numbers: dict[str, float], sharp: list[Sharp]) -> Array:
    """By how much images that are known to be sharp so, at these numbers, change the residual, shape (m,)."""
    here = np.concatenate(images.misfit(numbers, sharp))
    return np.concatenate([np.zeros(N_PRIORS), here - best.residual[N_PRIORS:]])


def _without_camera(images: Images, best: Best) -> ImageWord:
    """What the images say of the other numbers and of a warp, with what is known of lens and tilt left out."""
    numbers, residual = best.numbers, best.residual
    kept = np.ones(residual.size, bool)
    kept[N_PRIORS - N_KNOWN : N_PRIORS] = False

    def warped(name: str) -> Array:
        moved = {**numbers, name: numbers[name] + _WARP_STEP_PX}
        return _changed(images, best, numbers=moved, sharp=images.sharp(moved)) / _WARP_STEP_PX

    own = [one for name, one in zip(best.free, best.slopes.T, strict=True) if name not in SLIGHT]
    jacobian = np.stack([*own, *_reshaped(images, best), *(warped(name) for name in WARP_NUMBERS)], axis=1)[kept]
    prior = np.eye(jacobian.shape[1])[len(own) : len(own) + len(EXCHANGES)]
    return ImageWord(
        residual=np.append(residual[kept], np.zeros(len(prior))),
        jacobian=np.concatenate([jacobian, prior]),
        clusters=np.append(best.clusters[kept], np.full(len(prior), -1)),
        n_warp=len(WARP_NUMBERS),
    )
