"""Rays from sub-pixels through the lens to the rig plane, and what each of them can ever see.

Each pixel owns the same number of rays. A ray belongs to a sub-pixel of the image, one for each, and is
handed to the pixel to which the blur carries its light: blur moves light between pixels and keeps its sum
exactly. Inside its sub-pixel a ray lies at random, so that no edge runs along a row of rays.
"""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from os import cpu_count
from typing import Any, TypeAlias, final

import numpy as np
import numpy.typing as npt
from numba import njit
from scipy.special import ndtri

from irtiming.records.arrays import Array
from irtiming.twin.kernels import View, in_opening, in_ring, scatter, to_rig, turned, undistorted
from irtiming.twin.optics import Optics
from irtiming.twin.scene import ChopperWheel, MaskPlate, Scene

Offsets: TypeAlias = npt.NDArray[np.float32]
Indices: TypeAlias = npt.NDArray[np.int32]

_RAY_BUDGET = 3.4e7
_MOST_ALONG_PIXEL = 32
_SCALES = np.linspace(0.8, 1.2, 81)
"""Smears are tried longer and shorter: so few of them spread a little more or less than what they are drawn from."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RayTable:
    """The pixels that ever change, with the wheel-frame angles of their rays.

    Shapes (n_live,): pixel, flat index; reference_rad, angle of the pixel's centre; n_opening and n_plate,
    how many rays meet the mask's opening or its plate behind a cutout. offset_rad (n_live, n_ray): angle of
    each ray minus the reference; the first n_opening in order, then the next n_plate in order, the rest
    always meets solid wheel.
    """

    pixel: Indices
    reference_rad: Array
    n_opening: Indices
    n_plate: Indices
    offset_rad: Offsets
    rays_per_pixel: int


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RayPattern:
    """Sub-pixels in their order and where blur carries their light; shapes (n_ray,).

    Ray k of pixel (row, column) lies in sub-pixel (sub_row, sub_column)[k] of the pixel that is row_step and
    column_step further on.
    """

    row_step: Indices
    column_step: Indices
    sub_row: Indices
    sub_column: Indices
    along_pixel: int


def rays_along_pixel(optics: Optics, n_pixels: int) -> int:
    """Rays per side of a pixel: the optics' number, or an even one that keeps the table small."""
    if optics.rays_along_pixel > 0:
        return optics.rays_along_pixel
    return max(2, min(_MOST_ALONG_PIXEL, 2 * round(math.sqrt(_RAY_BUDGET / n_pixels) / 2)))


def ray_pattern(along_pixel: int, blur_rows_px: float, *, blur_columns_px: float | None = None) -> RayPattern:
    """Rays of one pixel, the same in a mirror along either axis: blur shifts and tilts no image.

    Parameters
    ----------
    along_pixel
        Sub-pixels per side of a pixel.
    blur_rows_px, blur_columns_px
        Standard deviation of the Gaussian blur from row to row and from column to column, px; the same if one is given. Then
        the rays are the same in a mirror along the diagonal, too.
    """
    sub_row, sub_column = np.divmod(np.arange(along_pixel * along_pixel, dtype=np.int32), along_pixel)
    place = (np.stack([sub_row, sub_column], axis=1) + 0.5) / along_pixel
    # A ray smeared into sub-pixel `place` came from `place - smear`: the pixel that owns it lies that much back.
    deviates = _gaussian_pairs(along_pixel)
    if blur_columns_px in (None, blur_rows_px):
        steps = _steps(place, deviates, blur_rows_px)
    else:
        down = _steps(place[:, :1], deviates[:, :1], blur_rows_px)
        steps = np.concatenate([down, _steps(place[:, 1:], deviates[:, 1:], blur_columns_px)], axis=1)
    return RayPattern(
        row_step=steps[:, 0],
        column_step=steps[:, 1],
        sub_row=sub_row,
        sub_column=sub_column,
        along_pixel=along_pixel,
    )


def _steps(place: Array, deviates: Array, blur_px: float) -> Indices:
    """How many pixels further on the light of each ray lies, shape (n_ray, n_axis)."""
    wanted = 1 / 12 + blur_px**2
    trials = [-np.floor(place - scale * blur_px * deviates).astype(np.int32) for scale in _SCALES]
    return min(trials, key=lambda steps: abs(float(np.var(steps + place)) - wanted))


def _gaussian_pairs(along_pixel: int) -> Array:
    """Normal deviates of variance exactly 1 along rows and columns for each sub-pixel in order, shape (n_ray, 2).

    Those of an eighth of the pixel are mirrored into the others. Its middle lines are mirrors of themselves: there none is
    moved across.
    """
    half = (along_pixel + 1) // 2
    plastic = 1.3247179572447460  # its powers fill the square evenly
    even = np.mod(0.5 + np.arange(1, half * half + 1)[:, None] / np.array([plastic, plastic**2]), 1.0)
    corner = ndtri(np.random.Generator(np.random.SFC64(0)).permutation(even)).reshape(half, half, 2)
    low, high = np.tril_indices(half)
    corner[low, high] = corner[high, low, ::-1]  # from the other side of the diagonal, rows and columns exchanged
    corner[np.arange(half), np.arange(half), 1] = corner[np.arange(half), np.arange(half), 0]
    place = np.arange(along_pixel)
    mirror = np.minimum(place, along_pixel - 1 - place)
    side = np.sign(2 * place - (along_pixel - 1)).astype(np.float64)  # 0 in the middle line
    pairs = corner[mirror[:, None], mirror[None, :]].copy()
    pairs[..., 0] *= side[:, None]
    pairs[..., 1] *= side[None, :]
    spread = float(np.sqrt(np.mean(pairs**2)))
    return np.asarray(pairs.reshape(-1, 2) / spread if spread > 0 else pairs.reshape(-1, 2))


def trace(scene: Scene) -> RayTable:
    """Follow every ray of every pixel once; the wheel turns later.

    The table is kept for the next run of the same rig.
    """
    return _trace(scene.wheel, scene.mask, scene.optics, scene.detector.rows, scene.detector.columns)


@lru_cache(maxsize=2)
def _trace(wheel: ChopperWheel, mask: MaskPlate, optics: Optics, rows: int, columns: int) -> RayTable:
    along = rays_along_pixel(optics, rows * columns)
    blur_rows_px, blur_columns_px = optics.blur_rows_columns_px
    pattern = ray_pattern(along, blur_rows_px, blur_columns_px=blur_columns_px)
    view = view_of(wheel, mask, optics=optics, shape=(rows, columns))
    steps = (pattern.row_step, pattern.column_step, pattern.sub_row, pattern.sub_column)
    reach = float(max(abs(pattern.row_step).max(), abs(pattern.column_step).max()) + 2) * 2

    def one_row(row: int) -> Any:
        return _trace_row(row, columns, view, steps, (along, reach))

    with ThreadPoolExecutor(cpu_count()) as pool:
        parts = list(pool.map(one_row, range(rows)))
    pixel, reference, n_opening, n_plate, offset = (np.concatenate(part) for part in zip(*parts, strict=True))
    return RayTable(
        pixel=pixel,
        reference_rad=reference,
        n_opening=n_opening,
        n_plate=n_plate,
        offset_rad=offset,
        rays_per_pixel=along * along,
    )


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
def _trace_row(row: int, columns: int, view: View, steps: Any, reach: tuple[int, float]) -> Any:
    """Live pixels of one row: flat index, reference angle, counts of opening and plate rays, offsets."""
    row_step, column_step, sub_row, sub_column = steps
    n_ray, along = row_step.size, reach[0]
    pixel = np.empty(columns, np.int32)
    reference = np.empty(columns, np.float64)
    counts = np.zeros((2, columns), np.int32)
    offsets = np.zeros((columns, n_ray), np.float32)
    behind = np.empty((2, n_ray), np.float32)
    live = 0
    for column in range(columns):
        x, y = to_rig(float(row), float(column), view)
        radius, margin = math.hypot(x, y), reach[1] * view.pitch
        if radius < view.ring_inner - margin or radius > view.ring_outer + margin:
            continue
        centre = math.atan2(y, view.mirror * x)
        direction = (math.cos(centre), math.sin(centre))
        found = np.zeros(2, np.int32)
        for ray in range(n_ray):
            cell_row, cell_column = row + row_step[ray], column + column_step[ray]
            jitter_row, jitter_column = scatter(cell_row, cell_column, ray)
            place_row = cell_row - 0.5 + (sub_row[ray] + 0.5 + jitter_row) / along
            place_column = cell_column - 0.5 + (sub_column[ray] + 0.5 + jitter_column) / along
            x, y = to_rig(place_row, place_column, view)
            if not in_ring(x, y, view):
                continue
            kind = 0 if in_opening(x, y, view) else 1
            behind[kind, found[kind]] = turned(view.mirror * x, y, direction)
            found[kind] += 1
        if found[0] + found[1] > 0:
            pixel[live], reference[live] = row * columns + column, centre
            counts[0, live], counts[1, live] = found[0], found[1]
            offsets[live, : found[0]] = np.sort(behind[0, : found[0]])
            offsets[live, found[0] : found[0] + found[1]] = np.sort(behind[1, : found[1]])
            live += 1
    return (
        pixel[:live].copy(),
        reference[:live].copy(),
        counts[0, :live].copy(),
        counts[1, :live].copy(),
        offsets[:live].copy(),
    )
