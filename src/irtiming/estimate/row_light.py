"""How the opening's light lies over polar angle, row by row: the sector of the contrast image, and what it leaves over."""

from dataclasses import dataclass, fields, replace
from typing import final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.estimate.row_timing import HARMONICS
from irtiming.physics import blurred_sector
from irtiming.records.arrays import Array, Mask, Ticks
from irtiming.records.rolling import ComplexArray
from irtiming.records.row_timing import SectorFit, SectorShape

SHAPE_NUMBERS = tuple(field.name for field in fields(SectorShape) if field.type is float)
"""Numbers of the sector in the order of its covariance."""

_LEAST_LIGHT_PX2 = 3.0
_FEWEST_ROWS = 6
_ANGLES = ("bisector_rad", "opening_angle_rad")
_STEP_RAD, _STEP_PX, _STEP_DISTORTION = 1e-4, 3e-3, 1e-3


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RowLight:
    """Fourier coefficients over polar angle of the light of each row, px^2.

    ``row_px`` (n_row,) are the rows with enough light and ``is_lit`` tells them among those that were summed;
    ``harmonics`` (n_row, M + 1), and ``changes`` (10, n_row, M + 1), their derivatives to the sector's numbers.
    """

    row_px: Ticks
    is_lit: Mask
    harmonics: ComplexArray
    changes: ComplexArray


def row_light(row_px: Ticks, sector: SectorFit) -> RowLight:
    """Light of the rows.

    Parameters
    ----------
    row_px
        Rows that were summed, shape (n_row,).
    sector
        Fitted to the contrast image; its excess counts as points of light at their own angles.

    Raises
    ------
    EstimationError
        If too few rows hold the light of three pixels.
    """
    harmonics = _sector_harmonics(sector.shape, row_px) + _beyond_harmonics(sector, row_px)
    lit = harmonics[:, 0].real > _LEAST_LIGHT_PX2
    if lit.sum() < _FEWEST_ROWS:
        raise EstimationError(
            f"only {lit.sum()} image rows hold the light of {_LEAST_LIGHT_PX2:.0f} pixels or more, at least {_FEWEST_ROWS} must "
            "for a row delay; bring the camera nearer to the mask"
        )
    changes = []
    for name in SHAPE_NUMBERS:
        step = _STEP_RAD if name in _ANGLES else _STEP_DISTORTION if name == "distortion" else _STEP_PX
        value = getattr(sector.shape, name)
        ahead = _sector_harmonics(replace(sector.shape, **{name: value + step}), row_px[lit])
        behind = _sector_harmonics(replace(sector.shape, **{name: value - step}), row_px[lit])
        changes.append((ahead - behind) / (2 * step))
    return RowLight(row_px=row_px[lit], is_lit=lit, harmonics=harmonics[lit], changes=np.array(changes))


def shape_of(numbers: Array, mirrored: bool, *, image: tuple[int, ...]) -> SectorShape:
    """Sector with these ten numbers, in the order of SHAPE_NUMBERS, in an image of so many rows and columns."""
    named = dict(zip(SHAPE_NUMBERS, map(float, numbers[: len(SHAPE_NUMBERS)]), strict=True))
    return SectorShape(**named, mirrored=mirrored, image_rows=image[0], image_columns=image[1])


def _sector_harmonics(shape: SectorShape, row_px: Ticks) -> ComplexArray:
    points = blurred_sector.light_points(shape)
    return blurred_sector.row_harmonics(points, row_px, blur_px=shape.blur_px, n_harmonics=HARMONICS)


def _beyond_harmonics(sector: SectorFit, row_px: Ticks) -> ComplexArray:
    """Plate, excess and uneven brightness as points of light at their own angles, by row."""
    rows = row_px - sector.roi[0]
    out = np.zeros((row_px.size, HARMONICS + 1), complex)
    for light, angle in (
        (sector.plate, sector.plate_angle_rad),
        (sector.uneven, sector.uneven_angle_rad),
        (sector.excess, sector.excess_angle_rad),
    ):
        turn, wave = np.exp(-1j * angle[rows]), light[rows].astype(complex)
        for order in range(HARMONICS + 1):
            out[:, order] += wave.sum(axis=1)
            wave = wave * turn
    return out
