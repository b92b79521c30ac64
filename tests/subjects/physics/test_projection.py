"""A tilted camera: against a plane turned by a rotation matrix before a pinhole."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from irtiming.physics import projection
from irtiming.records.row_timing import SectorShape

ROWS, COLUMNS, UNIT = 120, 160, 100.0


def _shape(**fields):
    return SectorShape(
        axle_row_px=64.0, axle_column_px=73.5, offset_row_px=0.0, offset_column_px=0.0, inner_radius_px=17.0,
        outer_radius_px=52.0, bisector_rad=-1.57, opening_angle_rad=1.3, blur_px=0.7, image_rows=ROWS, image_columns=COLUMNS,
        **fields,
    )  # fmt: skip


def _tilted(tilt, focal_px, **fields):
    """Sector of a camera turned by these angles about an axis along the rows' order and one along the columns'."""
    normal = Rotation.from_rotvec([*tilt, 0.0]).as_matrix()[2, :2]
    keystone = normal * UNIT / focal_px
    return _shape(
        keystone_row=keystone[0], keystone_column=keystone[1], log_focal_length=math.log(focal_px / UNIT), **fields
    )


@pytest.mark.parametrize(("tilt", "focal_px"), [((0.024, -0.019), 300.0), ((0.0, 0.2), 900.0), ((-0.1, 0.05), 150.0)])
def test_a_turned_plane_before_a_pinhole(tilt, focal_px):
    """Oracle: x = f X / Z of points of a plane turned by a 3 x 3 rotation matrix, moved until the axle is where it appears."""
    seen = projection.projection_of(_tilted(tilt, focal_px, lens_row_px=3.0, lens_column_px=-5.0))
    centre = np.array([62.5, 74.5])
    matrix = Rotation.from_rotvec([*tilt, 0.0]).as_matrix()
    at_axle = np.array([64.0 - centre[0], 73.5 - centre[1], focal_px])
    rng = np.random.default_rng(1)
    down, right = rng.uniform(-55, 55, (2, 40))
    place = matrix @ np.array([down, right, 0 * down]) + at_axle[:, None]
    expected = centre[:, None] + focal_px * place[:2] / place[2]
    np.testing.assert_allclose(seen.seen(down, right), expected, atol=1e-9)
    np.testing.assert_allclose(seen.flat(*expected), (down, right), atol=1e-9)


def test_magnification_is_the_derivative():
    """Oracle: central differences of where points appear; the least is the smaller singular value or a little less."""
    seen = projection.projection_of(
        _tilted((0.03, -0.02), 300.0, distortion=-0.05, lens_row_px=3.0, lens_column_px=-5.0)
    )
    down, right, step = np.array([-40.0, -20.0, 30.0]), np.array([25.0, -31.0, 8.0]), 1e-4
    least, area = seen.magnification(down, right)
    by_down = np.subtract(seen.seen(down + step, right), seen.seen(down - step, right)) / (2 * step)
    by_right = np.subtract(seen.seen(down, right + step), seen.seen(down, right - step)) / (2 * step)
    for k in range(3):
        slopes = np.array([by_down[:, k], by_right[:, k]])
        assert area[k] == pytest.approx(np.linalg.det(slopes), rel=1e-7)
        smallest = np.linalg.svd(slopes)[1][1]
        assert smallest * 0.97 < least[k] < smallest * 1.001


def test_without_tilt_nothing_but_the_lens():
    """Oracle: places from the axle are differences of rows and columns."""
    seen = projection.projection_of(_shape(log_focal_length=2.0))
    assert seen.seen(np.array([3.0]), np.array([-4.0])) == (67.0, 69.5)
    assert seen.flat(np.array([67.0]), np.array([69.5])) == (3.0, -4.0)
    assert seen.magnification(3.0, -4.0) == (1.0, 1.0)
    np.testing.assert_allclose(seen.tilt, 0)


def test_a_camera_that_looks_along_the_plane_stays_finite():
    """Oracle: a sine is at most one; a search may ask for more."""
    seen = projection.projection_of(_shape(keystone_row=0.25, log_focal_length=4.0))
    assert np.hypot(*seen.tilt) < 1
    assert np.all(np.isfinite(seen.flat(np.array([10.0, 100.0]), np.array([10.0, 100.0]))))
