"""Where the search for the sector ends: its numbers, what they leave over, and which of that errs together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.estimate import sector_limits, sector_search
from irtiming.estimate.sector_image import NUMBERS
from irtiming.estimate.sector_images import N_PRIORS, Images
from irtiming.estimate.sector_search import Misfit, Slopes
from irtiming.physics import blurred_sector
from irtiming.physics.warp import WARP_NUMBERS
from irtiming.records.arrays import Array, Ticks

_CLUSTER_PX = 3.0
_SURE = 1.1  # of the noise: what a pixel's uncertainty across its phase is at most


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Best:
    """End of a search: all numbers, names of the free ones, residual (m,), its slopes (m, n_free) and clusters (m,).

    ``gained`` is by how much it lessened the sum of squares that it began with, for each image.
    """

    numbers: dict[str, float]
    free: list[str]
    residual: Array
    slopes: Array
    clusters: Ticks
    chi_square: float
    gained: float


def searched(
    images: Images, *, begin: Mapping[str, float], held: Sequence[str], gain: float, slopes: Slopes | None = None
) -> Best:
    """The numbers that fit the images best.

    Parameters
    ----------
    images
        Of one camera in one place.
    begin
        Where to begin, all numbers; those that are ``held`` stay there, as do those that are known exactly, and a warp's.
    gain
        Below which the search ends; see `sector_search.searched`.
    slopes
        Of the fits before of the same images, where they are known well enough to begin with.

    Raises
    ------
    EstimationError
        If the image shows no sector.
    """
    stays = (*images.lens.held, *WARP_NUMBERS, *held)
    free = [name for name in (*NUMBERS, *(look.turn for look in images.seen[1:])) if name not in stays]
    found = sector_search.searched(Misfit(at=images.at, sharp=images.sharp), begin, free=free, gain=gain, slopes=slopes)
    numbers, residual = {**begin, **dict(zip(free, map(float, found.x), strict=True))}, np.asarray(found.fun)
    sector_limits.check(numbers, images.name, sense=images.sense)
    clusters = _clusters(images, numbers, residual.size)
    return Best(
        numbers=numbers,
        free=free,
        residual=residual,
        slopes=np.asarray(found.jac),
        clusters=clusters,
        chi_square=_chi_square(images, residual[clusters >= 0]),
        gained=float(found.gained) / len(images.seen),
    )


def _chi_square(images: Images, residual: Array) -> float:
    """Mean square of the pixels' residuals, without those across the phase where the blur's shape is not known."""
    good = images.view.good
    parts = [
        np.concatenate([good[good], (u.imag < _SURE * look.u_dn)[good]])
        for look, u in zip(images.seen, images.u_dn, strict=True)
    ]
    return float(np.mean(residual[np.concatenate(parts)] ** 2))


def _clusters(images: Images, numbers: Mapping[str, float], n_residual: int) -> Ticks:
    """Number of the cluster of each residual, -1 for priors, shape (n_residual,).

    Along its phase a pixel has gain and light of its own, but on the border its light is off by what the mask's border is off
    there, as is that of its neighbours; across it, the errors of the wheel's angle in the frames in which an edge passes, which
    it shares with all pixels of its sector of a few pixels' width. All of that is taken to be the same at every speed.
    """
    view, shape = images.view, images.view.shape(numbers)
    angle, radius = blurred_sector.pixel_places(shape, roi=view.roi)
    width = _CLUSTER_PX / float(radius[view.good].mean())
    sector = np.unique(np.floor(angle[view.good] / width), return_inverse=True)[1]
    n_good = sector.size
    row, column = np.indices(view.good.shape) // round(_CLUSTER_PX)
    cell = n_good + sector.max() + 1 + row * (column.max() + 1) + column
    alone = np.where(blurred_sector.near_border(shape, roi=view.roi)[view.good], cell[view.good], np.arange(n_good))
    own = np.concatenate([alone, n_good + sector])
    n_swayed = [len(look.swayed) for look in images.seen]
    n_field = (n_residual - N_PRIORS - sum(n_swayed)) // len(images.seen) - own.size
    of_images = [np.concatenate([own, np.full(n + n_field, -1)]) for n in n_swayed]
    return np.concatenate([np.full(N_PRIORS, -1), *of_images])
