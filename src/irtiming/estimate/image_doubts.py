r"""What is left of the contrast image where a blurred sector does not explain it.

Along a straight border a blur of the variance sigma^2 leaves, beyond a model of variance sigma_0^2, light r at the depth d with

.. math:: -2 \int r(d)\, d\, \mathrm{d}d = \sigma^2 - \sigma_0^2

whatever the shape of the blur. Burrs of the mask and gains of pixels leave as much of either sign, a blur that is of another kind
than the model's leaves the same all along a side: then the light of the rows does not lie where the model has it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy import special

from irtiming.estimate.sector_limits import FARTHEST_CENTRE
from irtiming.inference import lens_knowledge
from irtiming.inference.weighed_lens import SLIGHT
from irtiming.physics import blurred_sector
from irtiming.records.arrays import Array
from irtiming.records.finding import Finding
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import CameraOptics, Measured
from irtiming.records.row_timing import RowTimingFit, SectorFit

_CELL_PX = 3  # pixels that share a burr
_SIGNIFICANCE = 1e-5  # a side is off as much as this by chance once in the life of a laboratory
_ROWS_APART = 6.0  # standard uncertainties of a row delay where there is none: by chance never
_ROW_DELAYS_APART = 4.0  # standard uncertainties between rows and pixels: by chance once in the life of a laboratory
_OPENING_APART = 4.0  # standard uncertainties: by chance once in the life of a laboratory
_LENS_APART = 4.0  # standard uncertainties of what is known beforehand: by chance once in the life of a laboratory
_LENS_WORDS = (
    "its distortion", "its focal length", "its centre, from row to row,", "its centre, from column to column,",
    "the camera's tilt along rows", "the camera's tilt along columns",
)  # fmt: skip
"""In the order of `LensKnowledge.off`."""
_PROTRACTOR_RAD = np.radians(0.5)  # the angle was not measured better: its bisector is off by half of that then
_MOST_CHI_SQUARE = 1.5  # structure of half the variance of the noise


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LeftOver:
    """Variance of the blur beyond the model's along each side of the border, and its standard uncertainty, shapes (4,), px^2.

    ``u_model_px2`` is that of the model's own, whose shape is not known: it is alike along all sides, and the result has it.
    """

    variance_px2: Array
    u_px2: Array
    u_model_px2: float

    @property
    def pulls(self) -> Array:
        """By how many uncertainties each side is off, shape (4,); 0 where nothing is known."""
        u, known = np.hypot(self.u_px2, self.u_model_px2), self.u_px2 > 0
        return np.divide(self.variance_px2, u, out=np.zeros(u.shape), where=known)

    @property
    def p_value(self) -> float:
        """Of sides that are as far off, or further, where the model holds."""
        known = self.u_px2 > 0
        off = self.variance_px2[known]
        covariance = np.diag(self.u_px2[known] ** 2) + self.u_model_px2**2
        return float(special.chdtrc(max(1, off.size), off @ np.linalg.solve(covariance, off)))


def left_over(sector: SectorFit) -> LeftOver:
    """Blur that the image shows beyond the fitted one, by the light that is left on either side of the border.

    Parameters
    ----------
    sector
        As fitted; pixels that stray by themselves do not count.
    """
    shape = sector.shape
    side, depth = blurred_sector.border_sides(shape, roi=sector.roi)
    near = blurred_sector.near_border(shape, roi=sector.roi) & ~sector.odd
    straight = shape.outer_radius_px - shape.inner_radius_px
    lengths = shape.opening_angle_rad * np.array([shape.inner_radius_px, shape.outer_radius_px])
    row, column = np.indices(depth.shape) // _CELL_PX
    cell = row * (column.max() + 1) + column
    moments = [
        np.bincount(cell[pixels], (-2 * sector.excess * depth)[pixels]) if pixels.any() else np.zeros(1)
        for pixels in (near & (side == k) for k in range(len(blurred_sector.SIDES)))
    ]
    length = np.array([*lengths, straight, straight])
    return LeftOver(
        variance_px2=np.array([one.sum() for one in moments]) / length,
        u_px2=np.array([np.sqrt(np.sum(one**2)) for one in moments]) / length,
        u_model_px2=2 * shape.blur_px * sector.u("blur_px"),
    )


def of_image(sector: SectorFit) -> tuple[Finding, ...]:
    """Where the contrast image is structured beyond what the model explains.

    Parameters
    ----------
    sector
        The opening in the image.
    """
    found = left_over(sector)
    if found.p_value < _SIGNIFICANCE:
        pulls = np.abs(found.pulls)
        worst = int(np.argmax(pulls))
        reason = (
            f"along its {blurred_sector.SIDES[worst]} the opening is blurred by a variance that is "
            f"{found.variance_px2[worst]:+.3f} px^2 off the model's, {pulls[worst]:.0f} u"
        )
    elif sector.reduced_chi_square > _MOST_CHI_SQUARE:
        reason = f"its pixels are off by {sector.reduced_chi_square:.2f} times the variance of their noise"
    else:
        return ()
    return (
        Finding(
            code="image-not-explained",
            severity="doubt",
            what=f"the contrast image is no blurred sector behind this lens: {reason}; its light may lie elsewhere",
            cure="focus the camera on the mask, shade it from stray light, and look at the contrast image in the report",
        ),
    )


def of_sectors(fits: Sequence[RowTimingFit], sectors: Sequence[SectorFit]) -> tuple[Finding, ...]:
    """What `of_image` says of the image before each blackbody, and row delays that it contradicts.

    Parameters
    ----------
    fits, sectors
        One per recording; those before one blackbody share a sector.
    """
    found = list[Finding]()
    for sector in {id(one): one for one in sectors}.values():
        own = [fit for fit, other in zip(fits, sectors, strict=True) if other is sector]
        found += [*_of_row_delay(own, sector), *of_image(sector)]
    return tuple(dict.fromkeys(found))


def _of_row_delay(fits: Sequence[RowTimingFit], sector: SectorFit) -> list[Finding]:
    if "row_delay" not in fits[0].estimate:
        return []
    row_delay = float(np.mean([fit.estimate.value("row_delay") for fit in fits]))
    u = float(np.hypot(sector.u_row_delay_s, np.sqrt(np.mean([fit.estimate.u("row_delay") ** 2 for fit in fits]))))
    apart = abs(row_delay - sector.row_delay_s)
    if apart <= _ROW_DELAYS_APART * u:
        return []
    return [
        Finding(
            code="row-delays-disagree",
            severity="doubt",
            what=f"row delay by the row sums {1e6 * row_delay:.3f} µs, by the phases of the pixels "
            f"{1e6 * sector.row_delay_s:.3f} µs: they differ by {apart / u:.1f} u",
            cure="focus the camera on the mask; a lens that distorts or a camera that was moved may be the cause, too",
        )
    ]


def of_opening(sector: SectorFit, stated: Measured) -> tuple[Finding, ...]:
    """Where the opening in the image is not as wide as its mask: what covers one side of it turns its bisector by half as much.

    Parameters
    ----------
    sector
        The opening in the image.
    stated
        Opening angle of the mask, rad.
    """
    beside_rad = sector.shape.opening_angle_rad - stated.value
    u_rad = np.hypot(stated.standard_uncertainty, sector.u("opening_angle_rad"))
    if abs(beside_rad) <= np.hypot(_PROTRACTOR_RAD, _OPENING_APART * u_rad):
        return ()
    return (
        Finding(
            code="opening-not-as-wide",
            severity="doubt",
            what=f"the opening is {np.degrees(sector.shape.opening_angle_rad):.2f} deg wide in the image (u = "
            f"{np.degrees(sector.u('opening_angle_rad')):.2f} deg), rig.toml says {np.degrees(stated.value):.2f} deg: something "
            "covers a part of it, or opening_angle_deg is wrong; its middle is then not where centre_angle_deg has it, and the "
            "delay is wrong by as much",
            cure="look for a cable, a finger or an edge before the mask, and check [mask] opening_angle_deg",
        ),
    )


def of_lens_found(sector: SectorFit, camera: CameraOptics) -> tuple[Finding, ...]:
    """Where only a lens or a tilt that hardly is there explains the image: something else turns the phases of its pixels.

    Parameters
    ----------
    sector
        The opening in the image, with lens and tilt as they were found.
    camera
        Of rig.toml; what is not stated there is what cameras on such rigs have.
    """
    shape = sector.shape
    known = lens_knowledge.knowledge(camera, image=(shape.image_rows, shape.image_columns))
    off = known.off({name: sector.value(name) for name in SLIGHT})
    worst = int(np.argmax(np.abs(off)))
    if abs(off[worst]) <= _LENS_APART:
        return ()
    return (
        Finding(
            code="lens-unlikely",
            severity="doubt",
            what=f"the contrast image is a blurred sector only behind an unlikely lens: {_LENS_WORDS[worst]} would be "
            f"{abs(off[worst]):.0f} u off what was known beforehand; something else that turns the phases of the pixels may be "
            "taken for it, and the delay is then wrong",
            cure="check readout_mode (rows that are read one after the other look so where it says snapshot), [wheel] rotation, "
            "that the image is not mirrored, and what [camera] states of the lens",
        ),
    )


def of_lens(camera: CameraOptics, first: ReducedRecording) -> tuple[Finding, ...]:
    """Where the lens centre is said to be so far from the middle of the image that it may have been counted from there.

    Parameters
    ----------
    camera
        Of rig.toml.
    first
        Recording whose image counts; that of a region of interest, where it says so, may have the centre anywhere.
    """
    calibration = camera.calibration
    centre = camera.lens_centre_px if calibration is None else calibration.centre_px
    is_part = first.settings.region_first_row or first.settings.region_first_column
    if centre is None or is_part:
        return ()
    rows, columns = first.opening.mask.shape
    column, row = (one.value for one in centre)
    beside = float(np.hypot(column - (columns - 1) / 2, row - (rows - 1) / 2))
    if beside <= FARTHEST_CENTRE * columns:
        return ()
    return (
        Finding(
            code="lens-centre-far",
            severity="doubt",
            what=f"rig.toml has the lens centre at column {column:g}, row {row:g}, {beside:.0f} px from the middle of one of "
            f"{rows} x {columns} pixels: no lens is so far off, and angles in the image are wrong with it",
            cure="count columns and rows from the first pixel, which is 0, not from the middle; in a recording of a region of "
            "interest, state region_first_row and region_first_column",
        ),
    )


def of_rows(sector: SectorFit) -> tuple[Finding, ...]:
    """Where the rows of a camera that is said to read all of them at once appear one after the other.

    Parameters
    ----------
    sector
        The opening in the image, with a row delay that was looked for all the same.
    """
    if abs(sector.row_delay_s) <= _ROWS_APART * sector.u_row_delay_s:
        return ()
    return (
        Finding(
            code="rows-not-at-once",
            severity="doubt",
            what=f"each row of the image shows the wheel {1e6 * sector.row_delay_s:.2f} µs after the one above it (u = "
            f"{1e6 * sector.u_row_delay_s:.2f} µs), but readout_mode says that all are read at once: the timing found "
            "is that of no row",
            cure="write rolling as readout_mode if the camera reads row by row; else look for what moves the image: a tilt",
        ),
    )
