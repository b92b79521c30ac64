r"""A small displacement of places beside what lens and tilt make: what their errors do together, in nine numbers.

A point of the image that lens and tilt have at p in the wheel's plane, (d, r) half diagonals of the image down and right from the
axle, lies further down and right by

.. math::
    \begin{pmatrix} a d + s r + q_1 d^2 + q_2 d r + q_3 r^2 + c d |p|^2 \\
    s d - a r + q_4 d^2 + q_5 d r + q_6 r^2 + c r |p|^2 \end{pmatrix}

px. A lens that is a little off and a camera that is tilted move places by just such cubics: tilt squeezes them along one
direction (a, s) and makes the near side larger (q), distortion about a centre beside the axle has all of them. A shift, a turn
and a scale are left out: those are the axle's place, the bisector and the radii. In the plane, not in the image, an arc that a
larger warp puts elsewhere takes another radius, and all else stays: the sector's numbers follow a warp along straight lines.
"""

from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numba.extending import register_jitable

from irtiming.physics.lens import Place
from irtiming.records.arrays import Array

WARP_NUMBERS = (
    "warp_aspect_px", "warp_shear_px", "warp_down_by_down_px", "warp_down_by_both_px", "warp_down_by_right_px",
    "warp_right_by_down_px", "warp_right_by_both_px", "warp_right_by_right_px", "warp_radial_px",
)  # fmt: skip
"""Numbers of a `SectorShape` that displace places in the wheel's plane: a, s, q_1 to q_6, c."""


@final
@dataclass(frozen=True, kw_only=True)
class Warp:
    """Displacements ``amounts_px`` in the order of `WARP_NUMBERS`, at places counted in units of ``unit_px``."""

    amounts_px: tuple[float, ...]
    unit_px: float

    @property
    def is_none(self) -> bool:
        """Whether nothing moves."""
        return not any(self.amounts_px)

    def moved(self, down_px: Any, right_px: Any) -> tuple[Any, Any]:
        """By how much places from the axle lie further down and right, px; numbers or arrays that broadcast."""
        return displaced((down_px / self.unit_px, right_px / self.unit_px), self.amounts_px)


@register_jitable
def displaced(place: Place, amounts: tuple[float, ...]) -> Place:
    """By how much a place (d, r), half diagonals, lies further down and right, in the unit of the amounts."""
    (d, r), (aspect, shear, down_dd, down_dr, down_rr, right_dd, right_dr, right_rr, radial) = place, amounts
    ring = radial * (d * d + r * r)
    return (
        (aspect + ring + down_dd * d) * d + (shear + down_dr * d + down_rr * r) * r,
        (shear + right_dd * d + right_dr * r) * d + (ring - aspect + right_rr * r) * r,
    )


@register_jitable
def enlarged(place: Place, shares: tuple[float, ...]) -> Any:
    """How much larger an area about a place (d, r) becomes, from amounts in half diagonals, too."""
    (d, r), (aspect, shear, down_dd, down_dr, down_rr, right_dd, right_dr, right_rr, radial) = place, shares
    square, both = radial * (d * d + r * r), 2 * radial * d * r
    by_down = aspect + square + 2 * radial * d * d + 2 * down_dd * d + down_dr * r
    across = shear + both + down_dr * d + 2 * down_rr * r
    along = shear + both + 2 * right_dd * d + right_dr * r
    by_right = -aspect + square + 2 * radial * r * r + right_dr * d + 2 * right_rr * r
    return (1 + by_down) * (1 + by_right) - across * along


def displacements(down_px: Array, right_px: Array, *, unit_px: float) -> Array:
    """What 1 px of each number does, down and right, at n places, shape (n_warp, 2, n); see `Warp`."""
    alone = np.eye(len(WARP_NUMBERS)).tolist()
    return np.array([Warp(amounts_px=tuple(one), unit_px=unit_px).moved(down_px, right_px) for one in alone])
