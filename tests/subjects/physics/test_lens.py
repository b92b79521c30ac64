"""A lens that distorts: the way there is a formula, the way back must undo it."""

import numpy as np
import pytest

from irtiming.physics.lens import HIGHEST, LOWEST, Lens, magnified
from irtiming.records.row_timing import LensTerms

ROWS, COLUMNS = 120, 160
TERMS = LensTerms(quartic=0.02, sextic=-0.004, tangential_row=0.001, tangential_column=-0.002, row_stretch=1.01)


@pytest.mark.parametrize("distortion", [LOWEST, -0.05, -1e-4, 0.0, 0.03, HIGHEST])
@pytest.mark.parametrize("terms", [LensTerms(), TERMS])
def test_there_and_back(distortion, terms):
    """Oracle: every pixel's centre, corners too, comes back to where it was."""
    lens = Lens(distortion=distortion, rows=ROWS, columns=COLUMNS, terms=terms)
    row, column = np.arange(ROWS)[:, None] + 0.0, np.arange(COLUMNS)[None, :] + 0.0
    back = lens.seen(*lens.flat(row, column))
    for found, expected in zip(back, (row, column), strict=True):
        np.testing.assert_allclose(found, expected + 0 * found, atol=1e-8)
    one = lens.flat(7.0, 11.0)
    assert one == pytest.approx([np.broadcast_to(part, (ROWS, COLUMNS))[7, 11] for part in lens.flat(row, column)])


def test_a_corner_comes_nearer_by_the_distortion():
    """Oracle: by hand; the point of the flat plane one half diagonal from the middle moves by k half diagonals."""
    lens = Lens(distortion=-0.05, rows=61, columns=81)
    assert lens.middle_px == (30, 40)
    unit = np.hypot(61, 81) / 2
    row, column = lens.seen(30 + 0.6 * unit, 40 - 0.8 * unit)
    assert (row, column) == pytest.approx((30 + 0.95 * 0.6 * unit, 40 - 0.95 * 0.8 * unit))
    assert lens.seen(30.0, 40.0) == lens.flat(30.0, 40.0) == (30, 40)


@pytest.mark.parametrize("distortion", [-0.12, 0.0, 0.2])
@pytest.mark.parametrize("terms", [LensTerms(), TERMS])
def test_magnification_is_the_derivative(distortion, terms):
    """Oracle: central differences; the least of any direction is the smaller singular value, that of areas the determinant."""
    lens = Lens(distortion=distortion, rows=ROWS, columns=COLUMNS, off_row_px=3.0, off_column_px=-5.0, terms=terms)
    place, step = np.array([20.0, 30.0]), 1e-4
    slopes = np.array([
        np.subtract(lens.seen(*(place + step * way)), lens.seen(*(place - step * way))) / (2 * step) for way in np.eye(2)
    ])  # fmt: skip
    least, area = magnified(tuple((place - lens.middle_px) / lens.half_diagonal_px), lens.coefficients)
    assert least == pytest.approx(np.linalg.svd(slopes)[1][1], rel=1e-8)
    assert area == pytest.approx(np.linalg.det(slopes), rel=1e-8)


def test_opencv_s_formula():
    """Oracle: OpenCV's camera model written out by hand, in lengths over the focal length, with a camera matrix of its own."""
    fx, fy, cx, cy = 300.0, 303.0, 82.0, 57.0
    k1, k2, p1, p2, k3 = -0.21, 0.13, 0.002, -0.003, -0.04
    x, y = 0.13, -0.17
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    column = fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx
    row = fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy
    unit = np.hypot(ROWS, COLUMNS) / 2
    s = unit / fx
    lens = Lens(
        distortion=k1 * s**2, rows=ROWS, columns=COLUMNS, off_row_px=cy - 59.5, off_column_px=cx - 79.5,
        terms=LensTerms(
            quartic=k2 * s**4, sextic=k3 * s**6, tangential_row=p1 * s, tangential_column=p2 * s, row_stretch=fy / fx
        ),
    )  # fmt: skip
    assert lens.seen(cy + fx * y, cx + fx * x) == pytest.approx((row, column), abs=1e-9)
    assert lens.flat(row, column) == pytest.approx((cy + fx * y, cx + fx * x), abs=1e-9)


def test_beyond_the_turning_point_a_place_stays_finite():
    """Oracle: r_d is largest, 2/3 of r_u, where 3 |k| r_u^2 = 1; farther out there is no point, and 3/2 is kept."""
    lens = Lens(distortion=-0.3, rows=ROWS, columns=COLUMNS)
    row, column = lens.flat(np.array([0.0]), np.array([0.0]))
    assert row[0] - lens.middle_px[0] == pytest.approx(-1.5 * lens.middle_px[0])
    assert column[0] - lens.middle_px[1] == pytest.approx(-1.5 * lens.middle_px[1])
