"""Light of a blurred sector in the sums over rows, with its glare, against points that are counted one by one."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from irtiming.physics.light import sector_rows
from irtiming.records.row_timing import SectorShape

SHAPE = SectorShape(
    axle_row_px=33.37, axle_column_px=29.61, offset_row_px=0.0, offset_column_px=0.0, inner_radius_px=7.3,
    outer_radius_px=26.4, bisector_rad=float(np.radians(-93)), opening_angle_rad=float(np.radians(75)), blur_px=0.8,
    image_rows=45, image_columns=64,
)  # fmt: skip
ROI, ROWS, HIGHEST = (2, 36, 5, 55), np.array([9, 10, 20, 31]), 6


def _points():
    """Rows, columns, polar angles from the bisector and areas of 100 x 150 places of the sector."""
    radius = 7.3 + (26.4 - 7.3) * (np.arange(100) + 0.5) / 100
    beside = np.radians(75) * ((np.arange(150) + 0.5) / 150 - 0.5)
    r, a = (one.ravel() for one in np.meshgrid(radius, beside))
    polar = a + SHAPE.bisector_rad
    return 33.37 + r * np.sin(polar), 29.61 + r * np.cos(polar), a, r * (26.4 - 7.3) / 100 * np.radians(75) / 150


def _into(place, rows, width):
    return norm.cdf((rows[:, None] + 0.5 - place) / width) - norm.cdf((rows[:, None] - 0.5 - place) / width)


@pytest.mark.parametrize("glare", [0.0, 0.2])
def test_a_row_has_its_own_light_and_what_of_the_glare_falls_into_its_summed_pixels(glare):
    """Oracle: each point's light spread over rows by the normal distribution, its glare over rows and summed columns."""
    row, column, angle, area = _points()
    summed = np.ones((34, 50), bool)
    summed[:, 30:], summed[18, :25] = False, False
    waves = area[:, None] * np.exp(-1j * np.outer(angle, np.arange(HIGHEST + 1)))
    own = _into(row, ROWS.astype(float), 0.8) @ waves
    wide = np.hypot(0.8, 5.0)
    rows, columns = _into(row, ROWS.astype(float), wide), _into(column, np.arange(5, 55, dtype=float), wide)
    astray = (rows * (summed[ROWS - 2].astype(float) @ columns)) @ waves
    shape = replace(SHAPE, glare=glare, glare_px=5.0)
    found = sector_rows.harmonics(shape, ROWS, summed=summed, roi=ROI, n_harmonics=HIGHEST)
    np.testing.assert_allclose(found, (1 - glare) * own + glare * astray, atol=2e-3 * abs(own).max())
