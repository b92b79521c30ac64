"""A lens that distorts: the way there is a formula, the way back must undo it."""

import numpy as np
import pytest

from irtiming.physics.lens import HIGHEST, LOWEST, Lens

ROWS, COLUMNS = 120, 160


@pytest.mark.parametrize("distortion", [LOWEST, -0.05, -1e-4, 0.0, 0.03, HIGHEST])
def test_there_and_back(distortion):
    """Oracle: every pixel's centre, corners too, comes back to where it was."""
    lens = Lens(distortion=distortion, rows=ROWS, columns=COLUMNS)
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
def test_magnification_is_the_derivative(distortion):
    """Oracle: central differences along the radius and across it."""
    lens = Lens(distortion=distortion, rows=ROWS, columns=COLUMNS)
    place, step = np.array([20.0, 30.0]), 1e-4
    radial = place - lens.middle_px
    radial = radial / np.hypot(*radial)
    for way, expected in zip((radial, radial[::-1] * (-1, 1)), lens.magnification(*place), strict=True):
        ahead, behind = (np.array(lens.seen(*(place + sign * step * way))) for sign in (1, -1))
        assert np.hypot(*(ahead - behind)) / (2 * step) == pytest.approx(expected, rel=1e-8)


def test_beyond_the_turning_point_a_place_stays_finite():
    """Oracle: r_d is largest, 2/3 of r_u, where 3 |k| r_u^2 = 1; farther out there is no point, and 3/2 is kept."""
    lens = Lens(distortion=-0.3, rows=ROWS, columns=COLUMNS)
    row, column = lens.flat(np.array([0.0]), np.array([0.0]))
    assert row[0] - lens.middle_px[0] == pytest.approx(-1.5 * lens.middle_px[0])
    assert column[0] - lens.middle_px[1] == pytest.approx(-1.5 * lens.middle_px[1])
