r"""Lens and tilt settled: not the best of them, but all that image and prior knowledge allow, weighed (`inference.weighed_lens`).

The contrast image says what the nine numbers of a warp of the image may be, with the sector's other numbers free to follow; the
mean of the warps that lens and tilt allow moves those others, and its covariance goes into theirs.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.inference import clustered, weighed_lens
from irtiming.inference.lens_knowledge import LensKnowledge
from irtiming.inference.weighed_lens import with_own_following
from irtiming.physics.covariance import generalised_inverse
from irtiming.records.arrays import Array, Ticks
from irtiming.records.estimate import Estimate
from irtiming.records.row_timing import SectorShape


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Settled:
    """By how much the sector's numbers and then those of the warp move, shape (n,), their covariance (n, n), lens and tilt."""

    moved: Array
    covariance: Array
    camera: Estimate


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ImageWord:
    """What the contrast image says near a sector, with nothing known of lens and tilt.

    ``residual`` (m,) with derivatives ``jacobian`` (m, n) by the sector's numbers and then, ``n_warp`` of them, by those of the
    warp; ``clusters`` (m,) number residuals that err alike, -1 for what is known beforehand.
    """

    residual: Array
    jacobian: Array
    clusters: Ticks
    n_warp: int


def settled(word: ImageWord, shape: SectorShape, *, known: LensKnowledge) -> Settled:
    """Mean and covariance of all that lens, tilt and image allow.

    Parameters
    ----------
    word
        Of the image near ``shape``.
    shape
        The sector with the best lens and tilt.
    known
        Of the lens beforehand.
    """
    n_own = word.jacobian.shape[1] - word.n_warp
    plain, gradient = word.jacobian.T @ word.jacobian, -word.jacobian.T @ word.residual
    own = with_own_following(plain, n_own=n_own)
    best = generalised_inverse(own.beside) @ (gradient[n_own:] + own.follow.T @ gradient[:n_own])
    at_best = np.concatenate([own.covariance @ gradient[:n_own] + own.follow @ best, best])
    held = clustered.normal_matrix(word.jacobian, word.residual + word.jacobian @ at_best, clusters=word.clusters)
    clustered_own = with_own_following(held, n_own=n_own)
    lens = weighed_lens.weighed(best, clustered_own.beside, shape=shape, known=known)
    moved = own.covariance @ gradient[:n_own] + own.follow @ lens.warp_px
    return Settled(
        moved=np.concatenate([moved, lens.warp_px]),
        covariance=clustered_own.with_warp(lens.covariance),
        camera=lens.camera,
    )
