"""From a place in the image to the rig plane and what lies there: the steps that rays of both cameras take."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from irtiming.twin.spread import Offsets

_NEWTON_STEPS = 6
_SMALLEST_STEP = 1e-9
_SMALL = 0.13  # of the ratio of an angle's sides


class View(NamedTuple):
    """What the kernel needs to follow a ray; lengths in m in the rig plane, places in px of the image.

    ``frame_*`` is the middle of the image, ``middle_*`` the lens's axis, ``mask_right`` and ``mask_up`` the direction of the
    mask's opening. In a tilted view, one step to the right in the plane is ``*_of_right`` to the right, down and away from the
    camera, and so one step down.
    """

    frame_row: float
    frame_column: float
    middle_row: float
    middle_column: float
    half_diagonal: float
    distortion: float
    axle_row: float
    axle_column: float
    cos_roll: float
    sin_roll: float
    pitch: float
    mirror: float
    ring_inner: float
    ring_outer: float
    mask_x: float
    mask_y: float
    mask_inner: float
    mask_outer: float
    mask_right: float
    mask_up: float
    mask_half_cosine: float
    tilted: bool
    focal: float
    right_of_right: float
    down_of_right: float
    away_of_right: float
    right_of_down: float
    down_of_down: float
    away_of_down: float


@njit(cache=True, nogil=True)
def undistorted(row: float, column: float, half_diagonal: float, distortion: float) -> tuple[float, float]:
    """Where a point that appears at (row, column) from the image centre would be without distortion, px.

    Newton's method for r_u in r_d = r_u (1 + k r_u^2), radii in half diagonals.
    """
    if distortion == 0.0:
        return row, column
    seen = math.sqrt(row * row + column * column) / half_diagonal
    if seen == 0.0:
        return row, column
    radius = seen
    for _ in range(_NEWTON_STEPS):
        square = radius * radius
        step = (radius * (1 + distortion * square) - seen) / (1 + 3 * distortion * square)
        radius -= step
        if abs(step) < _SMALLEST_STEP * seen:  # the next one would be far below rounding
            break
    return row * radius / seen, column * radius / seen


@njit(cache=True, nogil=True)
def met(row: float, column: float, view: View) -> tuple[float, float]:
    """Where a ray meets the tilted plane: steps down and to the right from the axle, in it.

    The ray goes from the pupil through (column, row, focal); the axle is at (axle_column, axle_row, focal).
    """
    ax, ay, az = view.right_of_right, view.down_of_right, view.away_of_right
    bx, by, bz = view.right_of_down, view.down_of_down, view.away_of_down
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx  # the plane's normal
    to_axle = nx * view.axle_column + ny * view.axle_row + nz * view.focal
    stretch = to_axle / (nx * column + ny * row + nz * view.focal)
    x = stretch * column - view.axle_column
    y = stretch * row - view.axle_row
    z = (stretch - 1) * view.focal
    return x * bx + y * by + z * bz, x * ax + y * ay + z * az


@njit(cache=True, nogil=True)
def to_rig(row: float, column: float, view: View) -> tuple[float, float]:
    """Point of the rig plane, m from the axle, that appears at this place of the image."""
    flat_row, flat_column = undistorted(
        row - view.middle_row, column - view.middle_column, view.half_diagonal, view.distortion
    )
    if view.tilted:
        flat_row, flat_column = met(flat_row, flat_column, view)
    else:
        flat_row, flat_column = flat_row - view.axle_row, flat_column - view.axle_column
    down, right = flat_row * view.pitch, flat_column * view.pitch
    return right * view.cos_roll + down * view.sin_roll, down * view.cos_roll - right * view.sin_roll


@njit(cache=True, nogil=True)
def wrapped(angle: float) -> float:
    """Angle within half a turn of zero."""
    return angle - 2 * math.pi * math.floor(angle / (2 * math.pi) + 0.5)


@njit(cache=True, nogil=True)
def in_opening(x: float, y: float, view: View) -> bool:
    """Whether a point of the rig plane lies in the mask's annular sector."""
    x, y = x - view.mask_x, y - view.mask_y
    radius = math.sqrt(x * x + y * y)
    if radius < view.mask_inner or radius > view.mask_outer:
        return False
    return x * view.mask_right + y * view.mask_up >= radius * view.mask_half_cosine


@njit(cache=True, nogil=True)
def in_ring(x: float, y: float, view: View) -> bool:
    """Whether the wheel's cutouts sweep over a point of the rig plane."""
    radius = math.sqrt(x * x + y * y)
    return view.ring_inner <= radius <= view.ring_outer


@njit(cache=True, nogil=True)
def turned(x: float, y: float, direction: tuple[float, float]) -> float:
    """Angle from a direction, of the length 1, to that of a point; a series where it is small, to 1e-13."""
    along, across = x * direction[0] + y * direction[1], y * direction[0] - x * direction[1]
    if abs(across) > _SMALL * along:
        return math.atan2(across, along)
    ratio = across / along
    square = ratio * ratio
    series = 1 / 9 - square * (1 / 11 - square / 13)
    return ratio * (1 - square * (1 / 3 - square * (1 / 5 - square * (1 / 7 - square * series))))


@njit(cache=True, nogil=True)
def grade(row: int, column: int, view: View, grades: int) -> int:
    """Which step from the middle of the image to its corners a pixel lies in; steps are equal in the square of the distance."""
    square = ((row - view.frame_row) ** 2 + (column - view.frame_column) ** 2) / view.half_diagonal**2
    return min(int(square * grades), grades - 1)


@njit(cache=True, nogil=True)
def variant(row: int, column: int, variants: int) -> int:
    """Which copy of the spread a pixel takes, as if by chance."""
    mixed = np.uint64(row + 1024) * np.uint64(0x9E3779B97F4A7C15)
    mixed ^= np.uint64(column + 1024) * np.uint64(0xC2B2AE3D27D4EB4F)
    mixed ^= np.uint64(0x165667B19E3779F9)
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    mixed ^= mixed >> np.uint64(31)
    return int(np.float64(mixed & np.uint64(0xFFFFFFFF)) / 4294967296.0 * variants)


@njit(cache=True, nogil=True)
def _kind_of_place(row: float, column: float, view: View) -> int:
    """What a cutout shows at a place of the image: 0 the opening, 1 the plate; 2 where there is no cutout."""
    x, y = to_rig(row, column, view)
    if not in_ring(x, y, view):
        return 2
    return 0 if in_opening(x, y, view) else 1


@njit(cache=True, nogil=True)
def kind_of_pixel(row: int, column: int, view: View, reach: float) -> int:
    """What a cutout shows to a pixel: 0 the opening, 1 the plate or its border, 2 nothing, 3 the opening's edge."""
    first = _kind_of_place(float(row), float(column), view)
    same = True
    for ring in range(1, 4):
        for step in range(16):
            angle = step * math.pi / 8
            away = reach * ring / 3
            kind = _kind_of_place(row + away * math.sin(angle), column + away * math.cos(angle), view)
            if (kind == 0) != (first == 0):
                return 3
            same = same and kind == first
    return first if same else 1


@njit(cache=True, nogil=True)
def trace_pixel(rays: Offsets, place: tuple[int, int, float], view: View, spread: Offsets) -> tuple[int, int]:
    """Angles of a pixel's rays minus that of its centre, those to the opening and those to the plate; how many.

    ``place`` is the pixel's row and column and the angle of its centre, ``spread`` (n_ray, 2) the places of its rays from there;
    ``rays`` (2, n_ray or more) is written.
    """
    row, column, centre = place
    direction = (math.cos(centre), math.sin(centre))
    opening, plate = 0, 0
    for ray in range(spread.shape[0]):
        x, y = to_rig(row + spread[ray, 0], column + spread[ray, 1], view)
        if not in_ring(x, y, view):
            continue
        angle = turned(view.mirror * x, y, direction)
        if in_opening(x, y, view):
            rays[0, opening] = angle
            opening += 1
        else:
            rays[1, plate] = angle
            plate += 1
    return opening, plate
