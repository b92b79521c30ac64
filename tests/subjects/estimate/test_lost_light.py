"""What glare carries out of the summed pixels, against images of parts of the opening."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import ndtr

from irtiming.estimate import plate_light
from irtiming.physics import blurred_sector, sector_points
from irtiming.records.row_timing import SectorShape

SHAPE = SectorShape(
    axle_row_px=70.2, axle_column_px=48.3, offset_row_px=0.4, offset_column_px=-0.3, inner_radius_px=24.0,
    outer_radius_px=56.0, bisector_rad=float(np.radians(-88)), opening_angle_rad=1.3, blur_px=0.8, glare=0.03, glare_px=5.0,
    image_rows=90, image_columns=100,
)  # fmt: skip
ROI = (0, 80, 5, 95)


@dataclass
class _Sector:
    shape: SectorShape
    roi: tuple[int, int, int, int]


def _kept(shape, summed):
    """Light of a sector that its glare leaves in the summed pixels, px^2: its sharp image, spread, added up."""
    points = sector_points.light_points(shape)
    sharp = blurred_sector.image(points, np.ones(points.row_px.size, complex), blur=shape.blur, roi=ROI)
    return points.area_px2.sum(), float(
        (blurred_sector.with_glare(sharp, replace(shape, glare=1.0)).real * summed).sum()
    )


@pytest.mark.parametrize("mirrored", [False, True])
def test_parts_of_the_opening_lose_what_their_images_lack(mirrored):
    """Oracle: images of the opening without its outer parts, blurred, spread and added up over a lopsided region."""
    shape = replace(SHAPE, mirrored=mirrored)
    angle, radius = blurred_sector.pixel_places(shape, roi=ROI)
    summed = (np.abs(angle) < 0.75) & (angle > -0.7) & (radius > 20) & (radius < 60)
    whole = np.zeros((90, 100), bool)
    whole[ROI[0] : ROI[1], ROI[2] : ROI[3]] = summed
    ends, share = plate_light.lost(_Sector(shape, ROI), whole, shift_rad=0.0)
    assert ends[[0, -1]] == pytest.approx([-0.65, 0.65])
    area, kept = _kept(shape, summed)
    assert share.sum() == pytest.approx((area - kept) / area, abs=2e-3)
    for first, last in ((4, 12), (0, 8), (8, 16), (2, 5)):
        low, high = -ends[last], -ends[first]  # polar angles fall as wheel coordinates grow
        part = replace(shape, bisector_rad=shape.bisector_rad + (low + high) / 2, opening_angle_rad=high - low)
        part_area, part_kept = _kept(part, summed)
        assert share[first:last].sum() == pytest.approx((part_area - part_kept) / area, rel=0.03, abs=2e-4)
    assert share[0] > 1.3 * share[7]


def test_a_pixel_near_the_axle_spreads_its_plate_by_blur_and_glare_over_its_distance():
    """Oracle: by hand; one pixel, 1.5 px from the axle and 0.1 rad from the middle, and normal distributions over the angle."""
    shape = replace(SHAPE, axle_row_px=10.0, axle_column_px=10.5, offset_row_px=0.0, offset_column_px=0.0, blur_px=0.2,
                    glare=0.25, glare_px=0.6)  # fmt: skip
    summed = np.zeros((20, 24), bool)
    summed[10, 12] = True
    one = np.where(summed, 1.0, 0.0)
    sector = SimpleNamespace(
        shape=shape,
        roi=(0, 20, 0, 24),
        swept=one,
        ring=0.3 * one,
        plate=0.2,
        contrast=0.8 * one,
        ring_angle_rad=-0.1 * one,
    )
    found = plate_light.beside(sector, summed, shift_rad=0.0)
    narrow = np.sqrt(0.2**2 + 1 / 12) / 1.5
    wide = np.hypot(narrow, 0.6 / 1.5)
    before = 0.75 * ndtr((found.ends_rad - 0.1) / narrow) + 0.25 * ndtr((found.ends_rad - 0.1) / wide)
    np.testing.assert_allclose(found.plate, np.diff(before) / 0.8)
    np.testing.assert_allclose(found.uneven, 0.1 * np.diff(before) / 0.8)


def test_steps_are_fine_about_both_ends_of_the_opening_and_coarse_within():
    """Oracle: by hand; 0.57 rad within an opening of 1.3 rad there are four steps, from there to 0.8 rad nine of 1.46 degrees."""
    ends = plate_light._ends(1.3, 0.8)
    outer = np.linspace(0.57, 0.8, 10)
    np.testing.assert_allclose(ends, [*-outer[::-1], -0.285, 0.0, 0.285, *outer], atol=1e-12)
