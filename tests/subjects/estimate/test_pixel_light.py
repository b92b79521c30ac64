"""The light of single pixels over polar angle: against sums over a fine grid of points."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import ndtr

from irtiming.estimate.pixel_light import light_of_pixels
from irtiming.records.row_timing import SectorShape

ROI, BLUR_PX, GLARE, GLARE_PX, PLATE = (4, 44, 10, 70), 0.8, 0.05, 4.0, 0.1
ORDERS = np.array([2, 6])


def _sector(glare):
    shape = SectorShape(
        axle_row_px=47.0, axle_column_px=41.0, offset_row_px=0.0, offset_column_px=0.0, inner_radius_px=12.0,
        outer_radius_px=35.0, bisector_rad=-1.5, opening_angle_rad=1.2, blur_px=BLUR_PX, image_rows=60, image_columns=80,
        glare=glare, glare_px=GLARE_PX,
    )  # fmt: skip
    rows, columns = np.mgrid[ROI[0] : ROI[1], ROI[2] : ROI[3]]
    polar = np.arctan2(rows - 47.0, columns - 41.0) + 1.5
    return SimpleNamespace(shape=shape, roi=ROI, plate=PLATE, ring=np.full(rows.shape, 0.02), ring_angle_rad=polar)


def _light(row, column, *, width_px):
    """Sum over the sector of what a Gaussian carries into the pixel: of 1, and of exp(-i m phi)."""
    radius, angle = np.meshgrid(np.arange(12.0, 35.0, 0.05) + 0.025, np.linspace(-0.6, 0.6, 2001), indexing="ij")
    down, right = 47.0 + radius * np.sin(angle - 1.5), 41.0 + radius * np.cos(angle - 1.5)
    shares = [np.diff(ndtr((np.array([at - 0.5, at + 0.5])[:, None, None] - to) / width_px), axis=0)[0]
              for at, to in ((row, down), (column, right))]  # fmt: skip
    step = np.full(angle.shape[1], 1.2 / 2000)
    step[[0, -1]] /= 2
    amount = shares[0] * shares[1] * radius * 0.05 * step
    return np.array([np.sum(amount * np.exp(-1j * m * angle)) for m in (0, *ORDERS)])


@pytest.mark.parametrize("glare", [0.0, GLARE])
@pytest.mark.parametrize(("row", "column"), [(22, 45), (20, 24), (34, 47), (12, 43)])
def test_a_pixel_inside_and_on_the_border_sees_what_blur_and_glare_carry_to_it(glare, row, column):
    """Oracle: the sum over a million points of the sector; what the ring adds is even light about the pixel's own angle."""
    found = light_of_pixels(_sector(glare), ORDERS, row_px=np.array([row]), column_px=np.array([column]))
    sector = (1 - glare) * _light(row, column, width_px=BLUR_PX)
    if glare:
        sector = sector + glare * _light(row, column, width_px=np.hypot(BLUR_PX, GLARE_PX))
    away, polar = np.hypot(row - 47.0, column - 41.0), np.arctan2(row - 47.0, column - 41.0) + 1.5
    orders = np.array([0, *ORDERS])
    ring = 0
    for share, width in ((1 - glare, BLUR_PX), (glare, np.hypot(BLUR_PX, GLARE_PX))):
        smeared = np.exp(-0.5 * orders**2 * (width**2 + 1 / 12) / away**2)
        ring = ring + 0.02 * share * smeared * np.exp(-1j * orders * polar)
    expected = (1 - PLATE) * sector + ring
    assert found.share[0] == pytest.approx(expected[0].real, abs=2e-3)
    np.testing.assert_allclose(found.harmonics[:, 0], expected[1:], atol=3e-3)
    assert found.angle_rad[0] == pytest.approx(polar, abs=0.01)
    assert found.reach_rad[0] == pytest.approx(np.sqrt(BLUR_PX**2 + 1 / 12) / away, rel=1e-3)
    assert bool(found.is_inside[0]) is ((row, column) == (22, 45))
