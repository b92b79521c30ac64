"""Rays from pixels through blur and lens to the rig plane, and what each of them can ever see."""

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from os import cpu_count
from typing import Any, TypeAlias, final

import numpy as np
import numpy.typing as npt
from numba import njit

from irtiming.records.arrays import Array
from irtiming.twin.kernels import View, grade, kind_of_pixel, to_rig, trace_pixel, undistorted, variant
from irtiming.twin.optics import Optics
from irtiming.twin.scene import ChopperWheel, MaskPlate, Scene
from irtiming.twin.spread import VARIANTS, Offsets, edge_rays, graded_spread, reach_px

Indices: TypeAlias = npt.NDArray[np.int32]
Counts: TypeAlias = npt.NDArray[np.int64]

_RAY_BUDGET = 5e7
_MOST_EVEN_RAYS = 256


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RayTable:
    """The pixels that ever change, with the wheel-frame angles of their rays.

    Shapes (n_live,): pixel, flat index; reference_rad, angle of the pixel's centre; n_ray, how many rays it has, and
    n_opening, how many of them meet the mask's opening. first_ray (n_live + 1,): what pixel i's rays see is kept from
    first_ray[i] to first_ray[i + 1], in offset_rad (n_kept,), the angle of each ray minus the reference: first those to the
    opening, in order, then those to its plate behind a cutout, in order. The rest always meets solid wheel.
    """

    pixel: Indices
    reference_rad: Array
    n_ray: Indices
    n_opening: Indices
    first_ray: Counts
    offset_rad: Offsets


def even_rays(optics: Optics, n_pixels: int) -> int:
    """Rays of a pixel that no edge of the opening comes near: the optics' number, or one that keeps the table small."""
    return optics.rays_along_pixel**2 or max(4, min(_MOST_EVEN_RAYS, round(_RAY_BUDGET / n_pixels)))


def trace(scene: Scene) -> RayTable:
    """Follow every ray of every pixel once; the wheel turns later.

    The table is kept for the next run of the same rig.
    """
    return _trace(scene.wheel, scene.mask, scene.optics, scene.detector.rows, scene.detector.columns)


@lru_cache(maxsize=2)
def _trace(wheel: ChopperWheel, mask: MaskPlate, optics: Optics, rows: int, columns: int) -> RayTable:
    view = view_of(wheel, mask, optics=optics, shape=(rows, columns))
    even, edge = (
        graded_spread(n, optics, variants=VARIANTS)
        for n in (even_rays(optics, rows * columns), edge_rays(rows, columns) // 2)
    )
    reach = reach_px(optics)

    def one_row(row: int) -> Any:
        return _trace_row(row, columns, view, (even, edge), reach)

    pixel, reference, n_ray, n_opening, n_plate, offset = in_parallel(one_row, rows)
    return RayTable(
        pixel=pixel,
        reference_rad=reference,
        n_ray=n_ray,
        n_opening=n_opening,
        first_ray=np.concatenate([[0], np.cumsum(n_opening + n_plate, dtype=np.int64)]),
        offset_rad=offset,
    )


def in_parallel(one_row: Callable[[int], Any], rows: int) -> list[Any]:
    """Results of all rows, each kind in one array."""
    with ThreadPoolExecutor(cpu_count()) as pool:
        parts = list(pool.map(one_row, range(rows)))
    return [np.concatenate(part) for part in zip(*parts, strict=True)]


def view_of(wheel: ChopperWheel, mask: MaskPlate, *, optics: Optics, shape: tuple[int, int]) -> View:
    """Numbers of the scene in the form that the kernel reads."""
    middle_row = (shape[0] - 1) / 2 + optics.lens_centre_row_px
    middle_column = (shape[1] - 1) / 2 + optics.lens_centre_column_px
    half_diagonal = math.hypot(*shape) / 2
    axle_row, axle_column = undistorted(
        optics.wheel_centre_row_px - middle_row,
        optics.wheel_centre_column_px - middle_column,
        half_diagonal,
        optics.distortion,
    )
    below, beside = optics.tilt_about_row_rad, optics.tilt_about_column_rad
    return View(
        frame_row=(shape[0] - 1) / 2,
        frame_column=(shape[1] - 1) / 2,
        middle_row=middle_row,
        middle_column=middle_column,
        half_diagonal=half_diagonal,
        distortion=optics.distortion,
        axle_row=axle_row,
        axle_column=axle_column,
        cos_roll=math.cos(optics.roll_rad),
        sin_roll=math.sin(optics.roll_rad),
        pitch=optics.pixel_pitch_m,
        mirror=1.0 if wheel.rotation == "clockwise" else -1.0,
        ring_inner=wheel.inner_radius_m,
        ring_outer=wheel.outer_radius_m,
        mask_x=mask.centre_x_m,
        mask_y=mask.centre_y_m,
        mask_inner=mask.inner_radius_m,
        mask_outer=mask.outer_radius_m,
        mask_right=math.cos(mask.centre_angle_rad),
        mask_up=math.sin(mask.centre_angle_rad),
        mask_half_cosine=math.cos(mask.opening_angle_rad / 2),
        tilted=optics.is_tilted,
        focal=optics.focal_length_px,
        right_of_right=math.cos(beside),
        down_of_right=0.0,
        away_of_right=-math.sin(beside),
        right_of_down=math.sin(beside) * math.sin(below),
        down_of_down=math.cos(below),
        away_of_down=math.cos(beside) * math.sin(below),
    )


@njit(cache=True, nogil=True)
def _trace_row(row: int, columns: int, view: View, spreads: tuple[Offsets, Offsets], reach: float) -> Any:
    """Live pixels of one row: flat index, reference angle, numbers of rays, of those to opening and plate; offsets of these."""
    pixel, reference = np.empty(columns, np.int32), np.empty(columns, np.float64)
    counts = np.zeros((3, columns), np.int32)
    behind = np.empty((2, max(spreads[0].shape[2], spreads[1].shape[2])), np.float32)
    offsets, used, live = np.empty(columns * spreads[0].shape[2], np.float32), 0, 0
    for column in range(columns):
        kind = kind_of_pixel(row, column, view, reach)
        if kind == 2:  # nothing but solid wheel
            continue
        copies = spreads[1] if kind == 3 else spreads[0]
        spread = copies[grade(row, column, view, copies.shape[0]), variant(row, column, copies.shape[1])]
        x, y = to_rig(float(row), float(column), view)
        centre = math.atan2(y, view.mirror * x)
        found = trace_pixel(behind, (row, column, centre), view, spread)
        n = found[0] + found[1]
        if n == 0:
            continue
        if used + n > offsets.size:
            offsets = np.concatenate((offsets, np.empty(offsets.size + n, np.float32)))
        offsets[used : used + found[0]] = np.sort(behind[0, : found[0]])
        offsets[used + found[0] : used + n] = np.sort(behind[1, : found[1]])
        pixel[live], reference[live] = row * columns + column, centre
        counts[0, live], counts[1, live], counts[2, live] = spread.shape[0], found[0], found[1]
        used, live = used + n, live + 1
    return (
        pixel[:live].copy(),
        reference[:live].copy(),
        counts[0, :live].copy(),
        counts[1, :live].copy(),
        counts[2, :live].copy(),
        offsets[:used].copy(),
    )
