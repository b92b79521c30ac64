"""The ring that the cutouts sweep as blurred pixels see it, against points of light that are drawn."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtr

from irtiming.physics import blurred_ring
from irtiming.physics.blurred_ring import EvenLight
from irtiming.records.row_timing import SectorShape

ARCS_PX = (9.0, 30.0)
SHAPE = SectorShape(
    axle_row_px=30.4,
    axle_column_px=32.7,
    offset_row_px=0.0,
    offset_column_px=0.0,
    inner_radius_px=12.0,
    outer_radius_px=27.0,
    bisector_rad=float(np.radians(-90)),
    opening_angle_rad=float(np.radians(75)),
    blur_px=1.0,
    blur_ellipticity=0.2,
    blur_correlation=0.5,
    image_rows=61,
    image_columns=66,
)
ROI = (0, 61, 0, 66)


def _drawn(shape, row, column):
    """Radius and polar angle beside even light (n,) of points that a pixel sees: its own area, and a Gaussian askew beyond."""
    rng = np.random.default_rng([row, column])
    within = rng.uniform(-0.5, 0.5, (2, 400_000))
    spread = np.linalg.cholesky([
        [shape.blur.rows_px**2, shape.blur.covariance_px2], [shape.blur.covariance_px2, shape.blur.columns_px**2],
    ]) @ rng.standard_normal((2, 400_000))  # fmt: skip
    both = np.concatenate([within + spread, -within - spread], axis=1)
    down, right = both[0] + row - shape.axle_row_px, both[1] + column - shape.axle_column_px
    turn = np.exp(1j * (np.arctan2(down, right) - np.arctan2(row - shape.axle_row_px, column - shape.axle_column_px)))
    beside = np.angle(turn) * shape.sense
    return np.hypot(down, right), beside - beside.mean()


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("glare", [0.0, 0.1])
def test_light_at_an_arc_comes_from_beside_where_a_blur_is_askew(mirrored, glare):
    """Oracle: 800 000 points within a pixel, each behind a Gaussian askew; means of those that fall between the arcs.

    What goes astray comes from all sides, and turns the mean by so much less as it adds to the light.
    """
    shape = replace(SHAPE, mirrored=mirrored, glare=glare, glare_px=5.0)
    ring = blurred_ring.seen(shape, ARCS_PX, even=blurred_ring.even_light(shape, roi=ROI))
    turned = []
    for row, column in ((24, 27), (24, 38), (37, 27), (31, 42), (9, 54), (51, 11), (10, 10), (31, 62)):
        radius, beside = _drawn(shape, row, column)
        shown = (radius > ARCS_PX[0]) & (radius < ARCS_PX[1])
        assert ring.stays[row, column] == pytest.approx((1 - glare) * shown.mean(), abs=6e-3)
        assert ring.moment_rad[row, column] == pytest.approx((1 - glare) * (shown * beside).mean(), abs=9e-4)
        whole = (1 - glare) * shown.mean() + ring.astray[row, column]
        assert ring.aside_rad[row, column] == pytest.approx(ring.moment_rad[row, column] / whole, rel=0.05)
        turned.append(ring.moment_rad[row, column])
    assert np.max(turned) > 0.003
    assert np.min(turned) < -0.003


def test_light_within_the_ring_and_far_from_it_lies_nowhere_beside():
    """Oracle: the limits; amid the ring light comes from all sides, and from outside there is none."""
    ring = blurred_ring.seen(SHAPE, ARCS_PX, even=blurred_ring.even_light(SHAPE, roi=ROI))
    amid, outside = (30, 52), (0, 0)
    assert ring.stays[amid] == pytest.approx(1, abs=1e-9)
    assert ring.stays[outside] == pytest.approx(0, abs=1e-9)
    assert ring.moment_rad[amid] == ring.aside_rad[outside] == 0


def test_a_pixel_sees_the_ring_with_its_own_width():
    """Oracle: points within a pixel, each behind a blur of 0.7 px; a Gaussian as wide as a pixel stands for it."""
    radius = np.linspace(5, 35, 61)[None, :]
    none = np.zeros(radius.shape)
    even = EvenLight(angle_rad=none, reach_rad=none, radius_px=radius, along_px=none + 0.7, askew_px_rad=none)
    found = blurred_ring.seen(SHAPE, (10.0, 30.0), even=even)
    within = radius[..., None] + (np.arange(200) + 0.5) / 200 - 0.5
    exact = (ndtr((within - 10) / 0.7) * ndtr((30 - within) / 0.7)).mean(axis=-1)
    np.testing.assert_allclose(found.stays, exact, atol=2e-3)
    assert not found.astray.any()
    assert not found.moment_rad.any()
