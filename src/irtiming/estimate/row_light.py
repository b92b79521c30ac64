"""How the opening's light lies over polar angle, row by row: the sector of the contrast image, and what it leaves over."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.inference import in_threads
from irtiming.physics import blurred_sector
from irtiming.physics.light import pixel_waves, sector_rows
from irtiming.physics.light.bent_rows import PixelPowers
from irtiming.physics.warp import WARP_NUMBERS
from irtiming.records.arrays import Array, ComplexArray, Mask, Ticks
from irtiming.records.row_timing import LensTerms, SectorFit, SectorShape

SHAPE_NUMBERS = tuple(field.name for field in fields(SectorShape) if field.type is float)
"""Numbers of a sector's shape."""

STEP_OF = dict.fromkeys(SHAPE_NUMBERS, 3e-3) | dict.fromkeys(WARP_NUMBERS, 0.02) | {
    "bisector_rad": 1e-4, "opening_angle_rad": 1e-4, "distortion": 1e-3, "keystone_row": 1e-4, "keystone_column": 1e-4,
    "log_focal_length": 0.01, "lens_row_px": 0.1, "lens_column_px": 0.1, "glare": 1e-3, "blur_growth": 1e-2,
    "glare_px": 3e-2,
}  # fmt: skip
"""By how much each is varied for a derivative."""

SHAPE_STEPS = tuple(STEP_OF[name] for name in SHAPE_NUMBERS)
"""The same in the order of SHAPE_NUMBERS."""

_LEAST_LIGHT_PX2 = 3.0
_FEWEST_ROWS = 6


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RowLight:
    """Fourier coefficients over polar angle of the light of each row, px^2.

    ``row_px`` (n_row,) are the rows with enough light and ``is_lit`` tells them among those that were summed;
    ``harmonics`` (n_row, M + 1) is the light behind the wheel, ``before`` (n_row, M + 1) that of all summed pixels over which the
    cutouts sweep; ``powers`` are of the light of single pixels.
    """

    row_px: Ticks
    is_lit: Mask
    harmonics: ComplexArray
    before: ComplexArray
    powers: PixelPowers

    @property
    def beside(self) -> ComplexArray | None:
        """Where cutouts sweep beside the opening, shape (n_row, M + 1); None where that is next to nothing."""
        beside = np.asarray(self.before - self.harmonics)
        return beside if np.abs(beside[:, 0]).sum() > _LEAST_LIGHT_PX2 else None


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Variations:
    """A fit, ``at``, and the same with one number of its shape after the other moved by ``steps``, ``beside`` it."""

    at: SectorFit
    beside: tuple[SectorFit, ...]
    steps: tuple[float, ...]


def row_light(
    row_px: Ticks, sector: SectorFit, *, n_harmonics: int, blade: float = 0.0, beside: float = 0.0
) -> RowLight:
    """Light of the rows.

    Parameters
    ----------
    row_px
        Rows that were summed, shape (n_row,).
    sector
        Fitted to the contrast image; its excess counts as points of light at their own angles.
    n_harmonics
        Highest order M that the camera's response needs.
    blade, beside
        By how much a warmer blade lessens the contrast of the opening, and what is seen of the cutouts beside it, as shares of
        the opening's: in an image, which knows one order of the wheel's angle, it looks like a mask plate.

    Raises
    ------
    EstimationError
        If too few rows hold the light of three pixels.
    """
    sector = _told_from_blade(sector, blade, beside)
    harmonics = _harmonics(sector, row_px, n_harmonics=n_harmonics)
    lit = harmonics[:, 0].real > _LEAST_LIGHT_PX2
    if lit.sum() < _FEWEST_ROWS:
        raise EstimationError(
            f"only {lit.sum()} image rows hold the light of {_LEAST_LIGHT_PX2:.0f} pixels or more, at least {_FEWEST_ROWS} must "
            "for a row delay; bring the camera nearer to the mask"
        )
    return RowLight(
        row_px=row_px[lit], is_lit=lit, harmonics=harmonics[lit],
        before=_of_ring(sector, row_px[lit], light=sector.swept, n_harmonics=n_harmonics),
        powers=_powers(sector, row_px[lit], n_harmonics=n_harmonics),
    )  # fmt: skip


def _told_from_blade(sector: SectorFit, blade: float, beside: float) -> SectorFit:
    """The sector as it would look were both blades alike: contrasts seen are 1 - b of the opening, p - b' of the plate."""
    field = sector.ring - sector.plate * sector.swept
    plate = sector.plate * (1 - blade) + beside
    return replace(sector, plate=plate, ring=plate * sector.swept + (1 - blade) * field)


def changes(light: RowLight, varied: Variations) -> ComplexArray:
    """Derivatives of the light's harmonics to the sector's numbers, shape (n_shape, n_row, M + 1).

    Parameters
    ----------
    light
        Of the rows.
    varied
        In the order of the covariance.
    """

    def harmonics(sector: SectorFit) -> ComplexArray:
        return _harmonics(sector, light.row_px, n_harmonics=light.harmonics.shape[1] - 1)

    at, *beside = in_threads.mapped(harmonics, [varied.at, *varied.beside])
    return np.array([(one - at) / step for one, step in zip(beside, varied.steps, strict=True)])


def slopes(of: Callable[[SectorShape], Array], sector: SectorFit) -> Array:
    """Derivatives of what a shape makes to the numbers of the sector that may be off, shape (n, ...).

    Parameters
    ----------
    of
        Makes an array of any shape.
    sector
        Tells the shape and those numbers, in the order of its covariance.
    """

    def moved(name: str, step: float) -> Array:
        return of(replace(sector.shape, **{name: getattr(sector.shape, name) + step}))

    return np.array([
        (moved(name, STEP_OF[name]) - moved(name, -STEP_OF[name])) / (2 * STEP_OF[name]) for name in sector.names
    ])  # fmt: skip


def shape_of(
    numbers: Mapping[str, float], mirrored: bool, *, image: tuple[int, ...], lens_terms: LensTerms | None = None
) -> SectorShape:
    """Sector with these numbers, among others, in an image of so many rows and columns."""
    return SectorShape(
        **{name: float(numbers[name]) for name in SHAPE_NUMBERS},
        mirrored=mirrored,
        image_rows=image[0],
        image_columns=image[1],
        lens_terms=lens_terms or LensTerms(),
    )


def _harmonics(sector: SectorFit, row_px: Ticks, *, n_harmonics: int) -> ComplexArray:
    """Light of the sector where it exceeds the plate's, and what the whole ring and single pixels add."""
    inside = sector_rows.harmonics(sector.shape, row_px, summed=sector.summed, roi=sector.roi, n_harmonics=n_harmonics)
    ring = _of_ring(sector, row_px, light=sector.ring, n_harmonics=n_harmonics)
    lights = [(sector.borrowed, sector.borrowed_angle_rad), (sector.excess, sector.excess_angle_rad)]
    return (1 - sector.plate) * inside + ring + _of_pixels(sector, row_px, lights=lights, n_harmonics=n_harmonics)


def _of_ring(sector: SectorFit, row_px: Ticks, *, light: Array, n_harmonics: int) -> ComplexArray:
    """Light over the ring, (roi rows, roi columns), by row, of which the glare's share comes from farther round the axle."""
    shape, lights = sector.shape, [(light, sector.ring_angle_rad)]
    stays = _of_pixels(sector, row_px, lights=lights, n_harmonics=n_harmonics)
    if shape.glare == 0:
        return stays
    astray = _of_pixels(sector, row_px, lights=lights, n_harmonics=n_harmonics, astray_px=shape.glare_px)
    return (1 - shape.glare) * stays + shape.glare * astray


def _of_pixels(
    sector: SectorFit, row_px: Ticks, *, lights: Sequence[tuple[Array, Array]], n_harmonics: int, astray_px: float = 0.0
) -> ComplexArray:
    """Such lights, (roi rows, roi columns), by row: in each pixel about its own angle, as wide as pixel, blur and glare."""
    rows = row_px - sector.roi[0]
    _, radius = blurred_sector.pixel_places(sector.shape, roi=sector.roi)
    blur_px = np.hypot(blurred_sector.blur_across_px(sector.shape, roi=sector.roi)[rows], astray_px)
    smear = blurred_sector.pixel_smear(radius[rows], blur_px=blur_px, order=1)
    waves = (pixel_waves.by_row(one[rows], angle[rows], smear=smear, n_harmonics=n_harmonics) for one, angle in lights)
    return np.asarray(sum(waves))


def _powers(sector: SectorFit, row_px: Ticks, *, n_harmonics: int) -> PixelPowers:
    """Squares and cubes of what pixels show of the light, each at its own angle, and how wide the pixels of a row are."""
    rows = row_px - sector.roi[0]
    light, angle = np.where(sector.summed, np.clip(sector.contrast, 0, None), 0.0)[rows], sector.excess_angle_rad[rows]
    width = blurred_sector.angular_reach(sector.shape, roi=sector.roi)[rows]
    spread = np.sum(light**2 * width**2, axis=1) / np.maximum(np.sum(light**2, axis=1), 1e-300)
    sharp = np.ones_like(light)
    whole = 1 + (sector.ring - sector.plate * sector.swept)[rows]  # what a pixel would show wholly in the light
    weights = (light**2, light**3, 3 * light**2 * (2 * whole - 1 - light))
    squares, cubes, askew = (pixel_waves.by_row(one, angle, smear=sharp, n_harmonics=n_harmonics) for one in weights)
    return PixelPowers(squares=squares, cubes=cubes, askew=askew, smear=np.exp(-spread / 2))
