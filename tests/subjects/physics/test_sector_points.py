"""Where the nodes of a sector's light lie: as close as its blur asks for, and counted from half a turn back to half a turn on."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from irtiming.physics.projection import projection_of
from irtiming.physics.sector_points import _even, _sharpest, border_points, half_turn, light_points, places
from irtiming.records.row_timing import SectorShape

SHAPE = SectorShape(
    axle_row_px=24.0,
    axle_column_px=38.0,
    offset_row_px=0.0,
    offset_column_px=0.0,
    inner_radius_px=10.0,
    outer_radius_px=25.0,
    bisector_rad=0.1,
    opening_angle_rad=1.0,
    blur_px=0.7,
    image_rows=48,
    image_columns=64,
)


def test_angles_are_counted_from_half_a_turn_back_to_half_a_turn_on():
    """Oracle: by hand; pi itself counts as half a turn back."""
    angles = [-np.pi, -3.0, 0.0, 3.0, np.pi, 4.0, -4.0, 13.0]
    expected = [-np.pi, -3.0, 0.0, 3.0, -np.pi, 4.0 - 2 * np.pi, 2 * np.pi - 4.0, 13.0 - 4 * np.pi]
    assert [half_turn(angle) for angle in angles] == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("ellipticity", [-0.6, 0.6])
def test_an_opening_to_the_left_has_as_many_nodes_as_one_to_the_right(ellipticity):
    """Oracle: the mirror image, of a blur whose axes lie along rows and columns; it is sharpest at one end of the opening."""
    points = [
        light_points(replace(SHAPE, blur_ellipticity=ellipticity, bisector_rad=-np.pi / 2 + side))
        for side in (-0.5, 0.5)
    ]
    assert points[0].row_px.size == points[1].row_px.size
    np.testing.assert_allclose(np.sort(points[0].row_px), np.sort(points[1].row_px), atol=1e-9)


def test_nodes_are_close_enough_for_the_corner_where_the_blur_is_narrowest():
    """Oracle: distances in the image; 1.2 blurs at most, of which nine tenths of the variance are gone 40 px from the middle."""
    points = light_points(replace(SHAPE, blur_growth=-0.9))
    narrowest = 0.7 * np.sqrt(1 - 0.9 * ((points.row_px - 23.5) ** 2 + (points.column_px - 31.5) ** 2).max() / 40**2)
    around = np.unique(points.angle_rad.round(9)).size
    row, column = (values.reshape(-1, around) for values in (points.row_px, points.column_px))
    for axis in (0, 1):
        gap = np.hypot(np.diff(row, axis=axis), np.diff(column, axis=axis)).max()
        assert 0.8 * narrowest < gap < 1.2 * narrowest


@pytest.mark.parametrize("opening_rad", [1.0, 2.4, 6.2])
@pytest.mark.parametrize("view", [{}, {"keystone_row": 0.05, "keystone_column": -0.03}, {"distortion": 0.08}])
def test_of_the_border_are_all_nodes_that_are_not_surely_deep(opening_rad, view):
    """Oracle: the distance in the image to 4000 places of the border, of which depths in the wheel's plane tell 2 % at least.

    Two reaches of the blur and 2 px are deep enough.
    """
    shape = replace(
        SHAPE, inner_radius_px=20.0, outer_radius_px=60.0, opening_angle_rad=opening_rad, blur_px=0.4, **view
    )
    every, found = light_points(shape), border_points(shape)
    along, turn = np.linspace(20, 60, 1000), np.linspace(-0.5, 0.5, 1000)
    radius = np.concatenate([along, along, np.full(1000, 20.0), np.full(1000, 60.0)])
    part = np.concatenate([np.full(1000, -0.5), np.full(1000, 0.5), turn, turn])
    polar = shape.bisector_rad + opening_rad * part
    border = np.stack(projection_of(shape).seen(radius * np.sin(polar), radius * np.cos(polar)), axis=1)
    apart, _ = cKDTree(border).query(np.stack([every.row_px, every.column_px], axis=1))
    kept = set(zip(found.row_px.tolist(), found.column_px.tolist(), strict=True))
    is_kept = np.array([place in kept for place in zip(every.row_px.tolist(), every.column_px.tolist(), strict=True)])
    within = 2 * (5 * 0.4 + 1)
    assert is_kept.sum() == found.row_px.size
    assert is_kept[apart < 0.98 * within].all()
    assert not is_kept[apart > 1.4 * within].any()
    assert not is_kept.all()


def test_two_nodes_are_those_of_gauss_and_legendre():
    """Oracle: by hand; one over the root of three to either side, of equal weight; a single node would be too wide."""
    place, weight = _even(2)
    np.testing.assert_allclose(place, [-(3**-0.5), 3**-0.5])
    np.testing.assert_allclose(weight, [1, 1])


@pytest.mark.parametrize(("mirrored", "sense"), [(True, -1.0), (False, 1.0)])
def test_a_sector_that_is_displaced_from_the_axle_lies_so_much_beside_it(mirrored, sense):
    """Oracle: by hand; each place 2 px higher, and 3 px to the right as the wheel is seen from its own side."""
    plain = replace(SHAPE, mirrored=mirrored)
    moved = replace(plain, offset_row_px=-2.0, offset_column_px=3.0)
    (down, right, area), (down_there, right_there, area_there) = (
        places(one, n_radial=3, n_around=4) for one in (plain, moved)
    )
    np.testing.assert_allclose(down_there - down, -2.0, atol=1e-12)
    np.testing.assert_allclose(right_there - right, sense * 3.0, atol=1e-12)
    np.testing.assert_allclose(area_there, area)


@pytest.mark.parametrize("opening_rad", [0.3, 1.0, 1.5])
def test_the_blur_is_narrowest_somewhere_within_the_opening(opening_rad):
    """Oracle: widths of an ellipse, of 0.7 and 1.4 px along its axes, over 2001 directions of the sector and no others."""
    shape = replace(SHAPE, blur_px=0.7 * 2**0.5, blur_ellipticity=0.6, bisector_rad=0.8, opening_angle_rad=opening_rad)
    polar = 0.8 + opening_rad * np.linspace(-0.5, 0.5, 2001)
    rows, columns = shape.blur.rows_px, shape.blur.columns_px
    along = np.hypot(rows * np.sin(polar), columns * np.cos(polar))
    across = np.hypot(rows * np.cos(polar), columns * np.sin(polar))
    mixed = (rows**2 - columns**2) * np.sin(polar) * np.cos(polar)
    diagonal = np.sqrt(np.minimum(1, 2 * (1 - np.abs(mixed) / (along * across)))).min()
    assert _sharpest(shape, 1.0) == pytest.approx((diagonal * along.min(), diagonal * across.min()), rel=2e-3)
