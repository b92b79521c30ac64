"""Which way the wheel's edges move across an image, against what rig.toml states of its rotation and its mask."""

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.records.arrays import ComplexArray
from irtiming.records.rig import Rig

_ALONG = 0.5


@final
@dataclass(frozen=True, kw_only=True)
class Contradiction:
    """The ``way`` that edges move, such as ``"to the right"``, and what is ``stated`` that means the other one."""

    way: str
    stated: str


def contradiction(harmonic: ComplexArray, rig: Rig, *, least_turn_rad: float) -> Contradiction | None:
    """Whether edges move against the stated rotation, which they also do in a mirrored image; None where they do not, or hardly.

    Parameters
    ----------
    harmonic
        Shape (n_row, n_column): harmonic of each pixel over the half turn, 0 where the wheel does not show. A pixel further along
        the edges' way sees them later: its harmonic is turned back. The mean turn from pixel to pixel, weighted by the light
        in both, is the direction in which they move, downwards and to the right positive.
    rig
        With the stated rotation and place of the opening.
    least_turn_rad
        By how much it must turn from pixel to pixel, rad: 2 over the axle's distance in pixels is what it does.
    """
    right = complex(np.sum(np.conj(harmonic[:, :-1]) * harmonic[:, 1:]))
    down = complex(np.sum(np.conj(harmonic[:-1]) * harmonic[1:]))
    across, downwards = -np.angle(right), -np.angle(down)
    length = math.hypot(across, downwards)
    if length < least_turn_rad:
        return None
    phi = rig.mask_opening.centre_angle_rad.value
    sign = 1.0 if rig.wheel.rotation == "clockwise" else -1.0
    if sign * (math.cos(phi) * downwards - math.sin(phi) * across) / length > -_ALONG:
        return None
    sideways = "to the right" if across > 0 else "to the left"
    return Contradiction(
        way=sideways if abs(across) > abs(downwards) else "down" if downwards > 0 else "up",
        stated=f"[wheel] rotation = '{rig.wheel.rotation}' with [mask] centre_angle_deg = {math.degrees(phi):.4g}",
    )
