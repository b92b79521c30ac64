r"""Lens and tilt weighed: not the best of them, but all that an image and prior knowledge allow.

Distortion, its centre, the focal length and two tilts act on the image by their products, so that quite unlike sets of them look
nearly alike, and the best one, on the floor of a bent valley, says little of where the truth lies. But all of them do no more
than displace places a little (`physics.warp`), and in its nine numbers w the image is linear. So the contrast image says, with
the sector's other numbers y free to follow,

.. math:: -2 \log L = (w - \hat w)^T N (w - \hat w),

lens and tilt give w in closed form but for what is uneven in a lens, and draws of them by prior and L give the mean of w and its
covariance, with which y follows.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.inference import tempered
from irtiming.inference.lens_knowledge import CAMERA_NUMBERS, LensKnowledge
from irtiming.physics import lens, sector_points
from irtiming.physics.covariance import generalised_inverse
from irtiming.physics.lens import Lens
from irtiming.physics.projection import Projection, projection_of
from irtiming.physics.warp import displacements
from irtiming.records.arrays import Array
from irtiming.records.estimate import Estimate
from irtiming.records.row_timing import SectorShape

SLIGHT = ("distortion", "keystone_row", "keystone_column", "log_focal_length", "lens_row_px", "lens_column_px")
"""Numbers of a sector's shape that lens and tilt make, and that are found once the rest is."""

_RADIAL, _AROUND = 5, 7  # places in the sector: a cubic needs no more
_UNEVEN = 3e-4  # of half a diagonal: what no such lens keeps to; OpenCV's tangential terms are as large


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class WeighedLens:
    """Mean of the warp's numbers, shape (n_warp,), their covariance (n_warp, n_warp), lens and tilt themselves."""

    warp_px: Array
    covariance: Array
    camera: Estimate


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class OwnNumbers:
    """What an image says of a sector's own numbers beside those of a warp.

    How they ``follow`` the warp, shape (n_own, n_warp), their ``covariance`` (n_own, n_own) once it is known, and the normal
    matrix of the warp ``beside`` them (n_warp, n_warp).
    """

    follow: Array
    covariance: Array
    beside: Array

    def with_warp(self, covariance: Array) -> Array:
        """Covariance of own numbers and then the warp's, shape (n_own + n_warp, n_own + n_warp), from the warp's."""
        n_own, n_warp = self.follow.shape
        through = np.concatenate([self.follow, np.eye(n_warp)])
        both = through @ covariance @ through.T
        both[:n_own, :n_own] += self.covariance
        return np.asarray(both)


def weighed(best: Array, beside: Array, *, shape: SectorShape, known: LensKnowledge) -> WeighedLens:
    """All lenses and tilts that an image and what is known of them allow.

    Parameters
    ----------
    best
        Numbers of the warp against ``shape`` that the image would have alone, px, shape (n_warp,).
    beside
        Its normal matrix of them, with its other numbers free, px^-2, shape (n_warp, n_warp).
    shape
        The sector, with the lens and tilt that the warp is added to.
    known
        Of the lens beforehand.
    """
    cameras, n_warp = _Cameras(shape, known=known), best.size
    uneven = np.linalg.inv(beside + np.eye(n_warp) / (_UNEVEN * cameras.unit_px) ** 2)
    smoothed = (np.eye(n_warp) - beside @ uneven) @ beside

    def log_likelihood(units: Array) -> Array:
        off = cameras.warp(units) - best
        return np.where(cameras.is_possible(units), -0.5 * np.einsum("ni,ij,nj->n", off, smoothed, off), -np.inf)

    units = tempered.draws(log_likelihood, n_numbers=cameras.n_free)
    warp = cameras.warp(units)
    warp = warp + (best - warp) @ beside @ uneven  # what the image says of each lens's unevenness
    return WeighedLens(warp_px=warp.mean(axis=0), covariance=np.cov(warp.T) + uneven, camera=cameras.estimate(units))


def with_own_following(normal: Array, *, n_own: int) -> OwnNumbers:
    """A normal matrix, shape (n_own + n_warp, n_own + n_warp), parted; along some axes of the first it may say nothing."""
    covariance = generalised_inverse(normal[:n_own, :n_own])
    follow = -covariance @ normal[:n_own, n_own:]
    return OwnNumbers(
        follow=follow, covariance=covariance, beside=normal[n_own:, n_own:] + normal[n_own:, :n_own] @ follow
    )


@final
class _Cameras:
    """Lenses and tilts in units of what is known of them, shape (n, n_free), and how they warp the image against ``shape``."""

    def __init__(self, shape: SectorShape, *, known: LensKnowledge) -> None:
        self._shape, self._known = shape, known
        self._free = [name for name in CAMERA_NUMBERS if known.prior(name).standard_uncertainty > 0]
        now = projection_of(shape)
        self.unit_px = now.lens.half_diagonal_px
        *self._places, area = sector_points.places(shape, n_radial=_RADIAL, n_around=_AROUND)
        self._taken_off = _taken_off(*self._places, area_px2=area, unit_px=self.unit_px)
        self._image, self._before = now.seen(*self._places), np.concatenate(self._places)

    @property
    def n_free(self) -> int:
        """Numbers that are not known exactly."""
        return len(self._free)

    def is_possible(self, units: Array) -> Array:
        """Whether each lens shows every point of the image once, shape (n,)."""
        distortion = self._stated("distortion", units)
        return np.asarray((distortion >= lens.LOWEST) & (distortion <= lens.HIGHEST))

    def warp(self, units: Array) -> Array:
        """Numbers of the warp, shape (n, n_warp)."""
        numbers = {name: one[:, None] for name, one in self._numbers(units).items()}
        projection = self._projection(numbers)
        (row, column), middle = self._image, projection.lens.middle_px
        below, beside = row - middle[0], column - middle[1]
        further = numbers["quartic"] * ((below**2 + beside**2) / self.unit_px**2) ** 2
        places = projection.flat(row - below * further, column - beside * further)
        return np.asarray((np.concatenate(np.broadcast_arrays(*places), axis=1) - self._before) @ self._taken_off.T)

    def estimate(self, units: Array) -> Estimate:
        """Mean and covariance of the draws; tilts as the keystones that they make."""
        numbers = self._numbers(units)
        drawn = np.array([numbers[name] for name in SLIGHT]).T
        return Estimate(
            names=SLIGHT,
            units=tuple("px" if name.endswith("_px") else "1" for name in SLIGHT),
            values=drawn.mean(axis=0),
            covariance=np.cov(drawn.T),
        )

    def _stated(self, name: str, units: Array) -> Array:
        """One of CAMERA_NUMBERS, shape (n,)."""
        prior = self._known.prior(name)
        unit = units[:, self._free.index(name)] if name in self._free else np.zeros(len(units))
        return np.asarray(prior.value + prior.standard_uncertainty * unit)

    def _numbers(self, units: Array) -> dict[str, Array]:
        """Those of a sector's shape, those of lenses that there cannot be at their limit."""
        found = {name: self._stated(name, units) for name in CAMERA_NUMBERS}
        found["distortion"] = np.clip(found["distortion"], lens.LOWEST, lens.HIGHEST)
        length = np.exp(found["log_focal_length"])
        return found | {"keystone_row": found["tilt_row"] / length, "keystone_column": found["tilt_column"] / length}

    def _projection(self, numbers: dict[str, Array]) -> Projection:
        shape = self._shape
        optics = Lens(
            distortion=numbers["distortion"],
            rows=shape.image_rows,
            columns=shape.image_columns,
            off_row_px=numbers["lens_row_px"],
            off_column_px=numbers["lens_column_px"],
            terms=shape.lens_terms,
        )
        unit = self.unit_px
        return Projection(
            axle_px=(shape.axle_row_px, shape.axle_column_px),
            keystone_per_px=(numbers["keystone_row"] / unit, numbers["keystone_column"] / unit),
            focal_length_px=unit * np.exp(numbers["log_focal_length"]),
            lens=optics,
            axis_px=(numbers["axis_row_px"], numbers["axis_column_px"]),
        )


def _taken_off(down_px: Array, right_px: Array, *, area_px2: Array, unit_px: float) -> Array:
    """What takes the warp's numbers off displacements at places (p,), down and then right; shape (n_warp, 2 p).

    A shift, a turn and a scale are fitted beside them and left out.
    """
    none, one = np.zeros(down_px.size), np.ones(down_px.size)
    down, right = down_px / unit_px, right_px / unit_px
    trivial = [(one, none), (none, one), (down, right), (-right, down)]
    warps = displacements(down_px, right_px, unit_px=unit_px)
    fields = np.array([np.concatenate(field) for field in (*trivial, *warps)])
    light = np.sqrt(np.tile(area_px2, 2))
    return np.asarray((np.linalg.pinv((fields * light).T) * light)[len(trivial) :])
