"""The sector with lens and tilt weighed: what the images say of a warp, and where that takes all numbers (`lens_and_tilt`)."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.estimate import lens_and_tilt, sector_limits
from irtiming.estimate.lens_and_tilt import ImageWord
from irtiming.estimate.sector_best import Best
from irtiming.estimate.sector_image import APART, Sharp
from irtiming.estimate.sector_images import N_PRIORS, Images
from irtiming.estimate.sector_search import LIMITS, scale
from irtiming.inference import in_threads
from irtiming.inference.lens_knowledge import N_KNOWN
from irtiming.inference.weighed_lens import SLIGHT
from irtiming.physics.blur_shape import EXCHANGES, U_EXCHANGED, exchanged
from irtiming.physics.warp import WARP_NUMBERS
from irtiming.records.arrays import Array
from irtiming.records.estimate import Estimate

_OF_BLUR = ("blur_px", "blur_ellipticity", "blur_correlation", "blur_growth", "glare", "glare_px")  # see `_reshaped`
_STEP = 1e-2  # of a number's scale, to either side, over which its slope is taken: those that a search ends with are too rough
_WARP_STEP_PX = 0.02  # the same of a warp's


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


def _slope(images: Images, best: Best, name: str, *, sharp: list[Sharp]) -> Array:
    """What a number does to the residual, per unit, shape (m,), from either side of it where it is not at a limit."""
    step = _WARP_STEP_PX if name in WARP_NUMBERS else _STEP * scale(name)
    low, high = LIMITS.get(name, (-np.inf, np.inf))
    ends = [best.numbers | {name: min(max(best.numbers[name] + way * step, low), high)} for way in (-1, 1)]
    behind, ahead = (images.residuals(one, sharp if name in APART else images.sharp(one)) for one in ends)
    return np.asarray((ahead - behind) / (ends[1][name] - ends[0][name]))


def _reshaped(images: Images, best: Best, *, sharp: list[Sharp]) -> list[Array]:
    """What a blur of another shape does to the residual, per standard uncertainty of what is known of it, shape (m,) each."""
    others = (
        [replace(one, sector=exchanged(one.sector, U_EXCHANGED, axis=axis, away=away)) for one in sharp]
        for axis, away in EXCHANGES
    )
    return [images.residuals(best.numbers, one) - best.residual for one in others]


def _without_camera(images: Images, best: Best) -> ImageWord:
    """What the images say of the other numbers and of a warp, with what is known of lens and tilt left out."""
    residual, sharp = best.residual, images.sharp(best.numbers)
    kept = np.ones(residual.size, bool)
    kept[N_PRIORS - N_KNOWN : N_PRIORS] = False
    own = [name for name in best.free if name not in SLIGHT]
    slopes = in_threads.mapped(lambda name: _slope(images, best, name, sharp=sharp), [*own, *WARP_NUMBERS])
    n_own = len(own)
    jacobian = np.stack([*slopes[:n_own], *_reshaped(images, best, sharp=sharp), *slopes[n_own:]], axis=1)[kept]
    prior = np.eye(jacobian.shape[1])[n_own : n_own + len(EXCHANGES)]
    return ImageWord(
        residual=np.append(residual[kept], np.zeros(len(prior))),
        jacobian=np.concatenate([jacobian, prior]),
        clusters=np.append(best.clusters[kept], np.full(len(prior), -1)),
        n_warp=len(WARP_NUMBERS),
    )
