"""What glare carries out of the summed pixels, against images of parts of the opening."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

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
