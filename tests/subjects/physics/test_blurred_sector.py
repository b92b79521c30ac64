"""A blurred sector against sub-pixels that are counted one by one."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.path import Path
from scipy.stats import norm

from irtiming.physics.blurred_sector import (
    angular_reach,
    blur_across_px,
    even_angle_rad,
    glare_harmonics,
    image,
    pixel_places,
    pixel_smear,
    row_harmonics,
    well_inside,
    with_glare,
)
from irtiming.physics.sector_points import border_points, glare_points, light_points
from irtiming.records.blur import Blur
from irtiming.records.row_timing import SectorShape

SHAPE = SectorShape(
    axle_row_px=33.37,
    axle_column_px=29.61,
    offset_row_px=0.31,
    offset_column_px=-0.43,
    inner_radius_px=7.3,
    outer_radius_px=26.4,
    bisector_rad=float(np.radians(-93)),
    opening_angle_rad=float(np.radians(75)),
    blur_px=0.8,
    image_rows=45,
    image_columns=64,
)
ROI = (2, 36, 5, 55)
SUB = 16


def _counted(shape):
    """Sub-pixels: row (n,), column (k,), polar angle about the axle from the bisector (n, k), and area in the light, px^2."""
    place = (np.arange(SUB) + 0.5) / SUB - 0.5
    row, column = (np.arange(45)[:, None] + place).ravel(), (np.arange(64)[:, None] + place).ravel()
    (axle_row,), (axle_column,) = _unbent(shape, np.array([shape.axle_row_px]), np.array([shape.axle_column_px]))
    flat_row, flat_column = _unbent(shape, row[:, None] + 0 * column, 0 * row[:, None] + column)
    down, across = flat_row - axle_row, flat_column - axle_column
    across = -across if shape.mirrored else across
    own_down, own_across = down - shape.offset_row_px, across - shape.offset_column_px
    radius = np.hypot(own_down, own_across)
    beside = np.angle(np.exp(1j * (np.arctan2(own_down, own_across) - shape.bisector_rad)))
    inside = (
        (radius > shape.inner_radius_px)
        & (radius < shape.outer_radius_px)
        & (np.abs(beside) < shape.opening_angle_rad / 2)
    )
    polar = np.angle(np.exp(1j * (np.arctan2(down, across) - shape.bisector_rad)))
    return row, column, polar, inside / SUB**2


def _unbent(shape, row, column):
    """Places before the lens, by interpolation in a table of r_d over r_u."""
    middle, unit = ((shape.image_rows - 1) / 2, (shape.image_columns - 1) / 2), np.hypot(45, 64) / 2
    before = np.linspace(0, 1.3, 100_001)
    after = before * (1 + shape.distortion * before**2)
    seen = np.hypot(row - middle[0], column - middle[1]) / unit
    factor = np.interp(seen, after, before) / np.maximum(seen, 1e-12)
    return middle[0] + factor * (row - middle[0]), middle[1] + factor * (column - middle[1])


def _into(pixels, places, blur):
    """Share of light from each place that a Gaussian carries into each pixel, shape (place, pixel)."""
    high, low = ((pixels + half - places[:, None]) / blur for half in (0.5, -0.5))
    return norm.cdf(high) - norm.cdf(low)


def _border(shape):
    """Corners of a polygon along the border as the lens shows it, column and row from the image's middle, px."""
    radius = np.linspace(shape.inner_radius_px, shape.outer_radius_px, 2000)
    half = np.linspace(-0.5, 0.5, 4000) * shape.opening_angle_rad + shape.bisector_rad
    ring = [(r, a) for a, r in ((half[0], radius), (half[-1], radius[::-1]))]
    polar = np.concatenate([np.full(2000, half[0]), half, np.full(2000, half[-1]), half[::-1]])
    away = np.concatenate(
        [ring[0][0], np.full(4000, shape.outer_radius_px), ring[1][0], np.full(4000, shape.inner_radius_px)]
    )
    (row,), (column,) = _unbent(shape, np.array([shape.axle_row_px]), np.array([shape.axle_column_px]))
    y = row + shape.offset_row_px + away * np.sin(polar) - 22.0
    sense = -1 if shape.mirrored else 1
    x = column + sense * (shape.offset_column_px + away * np.cos(polar)) - 31.5
    bent = 1 + shape.distortion * (x**2 + y**2) / (45**2 + 64**2) * 4
    x, y = x * bent, y * bent
    return x, y


@pytest.fixture(
    scope="module",
    params=[(False, 0.0), (True, 0.0), (False, -0.1), (True, 0.15)],
    ids=["clockwise", "counterclockwise", "barrel", "pincushion"],
)
def shape(request):
    """The sector as a clockwise and as a counterclockwise wheel counts its angles, and through lenses that distort."""
    mirrored, distortion = request.param
    return replace(SHAPE, mirrored=mirrored, distortion=distortion)


@pytest.mark.parametrize("blur", [0.4, 0.8, 3.0])
def test_image_is_that_of_the_counted_sub_pixels(shape, blur):
    """Oracle: 16 x 16 sub-pixels a pixel, each spread by a Gaussian; complex brightness, so that angles count too."""
    shape = replace(shape, blur_px=blur)
    row, column, polar, area = _counted(shape)
    by_row, by_column = _into(np.arange(*ROI[:2]), row, blur), _into(np.arange(*ROI[2:]), column, blur)
    expected = by_row.T @ (np.exp(-2j * polar) * area) @ by_column
    points = light_points(shape)
    found = image(points, np.exp(-2j * points.angle_rad), blur=shape.blur, roi=ROI)
    assert found.shape == (34, 50)
    np.testing.assert_allclose(found, expected, atol=0.012)  # the border is jagged by a sixteenth of a pixel
    assert np.abs(found - expected).mean() < 6e-4


@pytest.mark.parametrize("n_harmonics", [0, 40])
@pytest.mark.parametrize("blur", [0.3, 0.8, 3.0])
def test_nodes_are_close_enough_for_the_blur_and_the_waves(blur, n_harmonics):
    """Oracle: nodes three times as close, whose error is nil."""
    shape = replace(SHAPE, blur_px=blur)
    coarse, fine = (light_points(one, n_harmonics=n_harmonics) for one in (shape, replace(shape, blur_px=blur / 3)))
    found, expected = (
        image(points, np.exp(-1j * n_harmonics * points.angle_rad), blur=shape.blur, roi=ROI)
        for points in (coarse, fine)
    )
    np.testing.assert_allclose(found, expected, atol=2e-5)


ELLIPTIC = replace(SHAPE, blur_px=0.75, blur_ellipticity=0.3, glare=0.03, glare_px=5.0)


def _spread(shape, value):
    """Image of the counted sub-pixels, and of the glare alone, each spread along rows and columns by the normal distribution."""
    row, column, _, _ = _counted(shape)
    blurs = (0.7 * shape.blur_px, 1.3 * shape.blur_px)
    widths = [blurs, tuple(float(np.hypot(blur, shape.glare_px)) for blur in blurs)]
    return [_into(np.arange(*ROI[:2]), row, a).T @ value @ _into(np.arange(*ROI[2:]), column, b) for a, b in widths]


@pytest.mark.parametrize("mirrored", [False, True])
def test_blur_that_is_not_round_and_glare_are_those_of_the_counted_sub_pixels(mirrored):
    """Oracle: 16 x 16 sub-pixels a pixel, spread by one width over rows and by another over columns, or by that of the glare."""
    shape = replace(ELLIPTIC, mirrored=mirrored)
    _, _, polar, area = _counted(shape)
    narrow, wide = _spread(shape, np.exp(-2j * polar) * area)
    near, far = light_points(shape), glare_points(shape)
    assert far.row_px.size < near.row_px.size / 10
    found = image(near, np.exp(-2j * near.angle_rad), blur=shape.blur, roi=ROI)
    np.testing.assert_allclose(found, narrow, atol=0.012)
    assert np.abs(found - narrow).mean() < 6e-4
    np.testing.assert_allclose(with_glare(found, replace(shape, glare=1.0)), wide, atol=1e-3)
    widths = tuple(float(np.hypot(blur, shape.glare_px)) for blur in shape.blur[:2])
    np.testing.assert_allclose(image(far, np.exp(-2j * far.angle_rad), blur=Blur(*widths), roi=ROI), wide, atol=1e-3)
    border = border_points(shape)
    near_border = image(border, np.exp(-2j * border.angle_rad), blur=shape.blur, roi=ROI)
    inside = well_inside(shape, roi=ROI)
    np.testing.assert_allclose(near_border[~inside], narrow[~inside], atol=0.012)


def test_glare_of_the_rows_is_what_falls_into_their_summed_pixels():
    """Oracle: sub-pixels spread over the image, summed over a ragged region; all rows and columns together hold all light."""
    _, _, polar, area = _counted(ELLIPTIC)
    summed = np.ones((34, 50), bool)
    summed[:, 40:], summed[3, :20] = False, False
    found = glare_harmonics(ELLIPTIC, summed, roi=ROI, n_harmonics=12)
    for m in (0, 2, 11):
        _, wide = _spread(ELLIPTIC, np.exp(-1j * m * polar) * area)
        np.testing.assert_allclose(found[:, m], (wide * summed).sum(axis=1), atol=0.02)
    everywhere = glare_harmonics(ELLIPTIC, np.ones((140, 140), bool), roi=(-50, 90, -40, 100), n_harmonics=0)
    assert everywhere.sum() == pytest.approx(light_points(ELLIPTIC).area_px2.sum(), rel=1e-9)


@pytest.mark.parametrize("correlation", [0.0, -0.5])
@pytest.mark.parametrize("mirrored", [False, True])
def test_even_light_through_a_blur_that_is_not_round(mirrored, correlation):
    """Oracle: mean and standard deviation of the polar angles of a pixel's points, each blurred by a Gaussian of two widths."""
    shape = replace(ELLIPTIC, mirrored=mirrored, blur_correlation=correlation)
    place = (np.arange(30) + 0.5) / 30 - 0.5
    node, weight = np.polynomial.hermite_e.hermegauss(16)
    weights = np.multiply.outer(weight, weight) / weight.sum() ** 2 / 900
    down_by, right_by = shape.blur.rows_px * node, shape.blur.columns_px * node
    own = np.sqrt(1 - correlation**2)
    box = (3, 10, 40, 55)
    shift, reach = even_angle_rad(shape, roi=box), angular_reach(shape, roi=box)
    sense = -1 if mirrored else 1
    for row, column in ((4, 41), (9, 54)):
        off, square = 0.0, 0.0
        for below in place:
            down = row - shape.axle_row_px + below + down_by[:, None]
            for beside in place:
                right = column - shape.axle_column_px + beside + own * right_by + correlation * right_by[:, None]
                centre = np.arctan2(row - shape.axle_row_px, sense * (column - shape.axle_column_px))
                angle = np.angle(np.exp(1j * (np.arctan2(down, sense * right) - centre)))
                off, square = off + np.sum(weights * angle), square + np.sum(weights * angle**2)
        assert abs(off) > 3e-5
        assert shift[row - 3, column - 40] == pytest.approx(off, rel=0.02)
        assert reach[row - 3, column - 40] == pytest.approx(np.sqrt(square), rel=3e-3)


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_blur_askew_is_that_of_the_counted_sub_pixels(mirrored):
    """Oracle: 16 x 16 sub-pixels a pixel, moved along a diagonal by a Gaussian's nodes and spread along rows and columns."""
    shape = replace(SHAPE, mirrored=mirrored, blur_px=0.8, blur_ellipticity=0.1, blur_correlation=-0.55)
    row, column, polar, area = _counted(shape)
    rows_px, columns_px = 0.72, 0.88
    along = 0.55 * rows_px * columns_px
    node, weight = np.polynomial.hermite_e.hermegauss(9)
    expected = 0
    for move, share in zip(node * np.sqrt(along), weight / weight.sum(), strict=True):
        by_row = _into(np.arange(*ROI[:2]), row + move, np.sqrt(rows_px**2 - along))
        by_column = _into(np.arange(*ROI[2:]), column - move, np.sqrt(columns_px**2 - along))
        expected = expected + share * (by_row.T @ (np.exp(-2j * polar) * area) @ by_column)
    near = ~well_inside(shape, roi=ROI)
    for points in (light_points(shape), border_points(shape)):
        found = image(points, np.exp(-2j * points.angle_rad), blur=shape.blur, roi=ROI)
        np.testing.assert_allclose(found[near], expected[near], atol=0.012)
        assert np.abs(found - expected)[near].mean() < 2e-3


@pytest.mark.parametrize("growth", [-0.5, 3.0])
def test_a_blur_that_grows_to_the_corners_is_that_of_the_counted_sub_pixels(growth):
    """Oracle: 16 x 16 sub-pixels a pixel, each spread by a width of its own: 1 + growth times the square of half diagonals."""
    shape = replace(SHAPE, blur_px=0.6, blur_growth=growth)
    rows, columns, polar, area = _counted(shape)
    lit = area > 0
    row, column = rows[np.nonzero(lit)[0]], columns[np.nonzero(lit)[1]]
    half_diagonals2 = ((row - 22) ** 2 + (column - 31.5) ** 2) / ((45**2 + 64**2) / 4)
    width = 0.6 * np.sqrt(1 + growth * half_diagonals2)[:, None]
    by_row, by_column = _into(np.arange(*ROI[:2]), row, width), _into(np.arange(*ROI[2:]), column, width)
    value = np.exp(-2j * polar[lit]) * area[lit]
    expected = by_row.T @ (value[:, None] * by_column)
    near = ~well_inside(shape, roi=ROI)
    for points in (light_points(shape), border_points(shape)):
        found = image(points, np.exp(-2j * points.angle_rad), blur=shape.blur, roi=ROI)
        np.testing.assert_allclose(found[near], expected[near], atol=0.012)
    found = row_harmonics(light_points(shape), np.arange(*ROI[:2]), blur_px=0.6, n_harmonics=2)
    np.testing.assert_allclose(found[:, 2], by_row.T @ value, atol=0.05)


def test_a_round_blur_is_the_same_in_every_direction():
    """Oracle: the one width that it has."""
    assert np.all(even_angle_rad(SHAPE, roi=ROI) == 0)
    np.testing.assert_allclose(blur_across_px(SHAPE, roi=ROI), 0.8, rtol=1e-14)
    np.testing.assert_allclose(blur_across_px(SHAPE, roi=ROI, along=True), 0.8, rtol=1e-14)


def test_row_harmonics_are_the_sums_over_the_sub_pixels(shape):
    """Oracle: exp(-i m angle) added up over the sub-pixels, times the share that falls into the row."""
    row, _, polar, area = _counted(shape)
    rows = np.array([9, 5, 20, 28, 40])
    by_line = np.stack([(np.exp(-1j * m * polar) * area).sum(axis=1) for m in range(31)], axis=1)
    expected = _into(rows, row, SHAPE.blur_px).T @ by_line
    found = row_harmonics(light_points(shape), rows, blur_px=SHAPE.blur_px, n_harmonics=30)
    np.testing.assert_allclose(found, expected, atol=0.05)
    size = np.abs(expected[:, 0]).max()
    assert np.abs(found - expected).max() / size < 2e-3


def test_light_is_as_much_as_the_sector_is_large():
    """Oracle: gamma (R^2 - r^2) / 2, before and after the blur, and whichever way it is added up."""
    area = SHAPE.opening_angle_rad * (SHAPE.outer_radius_px**2 - SHAPE.inner_radius_px**2) / 2
    points = light_points(SHAPE)
    assert points.area_px2.sum() == pytest.approx(area, rel=1e-12)
    for blur in (0.5, 2.0):
        points = light_points(replace(SHAPE, blur_px=blur))
        whole = image(points, np.ones(points.row_px.size, complex), blur=Blur(blur, blur), roi=(-20, 80, -20, 90))
        assert whole.sum().real == pytest.approx(area, rel=1e-6)
        rows = row_harmonics(points, np.arange(-20, 80), blur_px=blur, n_harmonics=3)
        np.testing.assert_allclose(rows[:, 0].real, whole.sum(axis=1).real, atol=2e-5)
        np.testing.assert_array_equal(rows[:, 0].imag, 0)


def test_a_lens_makes_the_image_as_large_as_its_border(shape):
    """Oracle: the area of a polygon along the border, each corner carried through the lens (shoelace formula)."""
    x, y = _border(shape)
    area = abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2
    assert light_points(shape).area_px2.sum() == pytest.approx(area, rel=1e-6)


def test_quadrature_is_fine_enough():
    """Oracle: the same with nodes for a quarter of the blur, sixteen times as many."""
    rows = np.arange(5, 34)
    coarse, fine = light_points(SHAPE), light_points(replace(SHAPE, blur_px=SHAPE.blur_px / 4))
    assert fine.row_px.size > 10 * coarse.row_px.size
    few, many = (row_harmonics(p, rows, blur_px=SHAPE.blur_px, n_harmonics=64) for p in (coarse, fine))
    np.testing.assert_allclose(few, many, atol=2e-5)


FAR_OUT = replace(SHAPE, axle_row_px=21.0, axle_column_px=26.0, bisector_rad=0.1, outer_radius_px=33.0, blur_px=0.5)
"""Reaches a corner of the image, where a lens magnifies most."""


@pytest.mark.parametrize("distortion", [-0.15, 0.1, 0.3])
def test_quadrature_is_fine_enough_where_a_lens_magnifies_most(distortion):
    """Oracle: the same with nodes for a quarter of the blur, in every pixel; 1 is the light of a whole one."""
    shape = replace(FAR_OUT, distortion=distortion)
    few, many = (
        image(points, np.ones(points.row_px.size, complex), blur=shape.blur, roi=(0, 45, 0, 75))
        for points in (light_points(shape), light_points(replace(shape, blur_px=shape.blur_px / 4)))
    )
    np.testing.assert_allclose(few, many, atol=3e-5)


@pytest.mark.parametrize("distortion", [-0.15, 0.0, 0.3])
def test_neighbouring_nodes_are_nowhere_further_apart_than_their_limit(distortion):
    """Oracle: distances in the image; the limit of 1.2 blurs is the module's, beyond it ghosts of the nodes would show."""
    shape = replace(FAR_OUT, distortion=distortion, inner_radius_px=20.0, offset_row_px=0.0, offset_column_px=0.0)
    points = light_points(shape)
    around = np.unique(points.angle_rad.round(9)).size
    row, column = (values.reshape(-1, around) for values in (points.row_px, points.column_px))
    for axis in (0, 1):
        gap = np.hypot(np.diff(row, axis=axis), np.diff(column, axis=axis)).max()
        assert 0.5 * shape.blur_px < gap < 1.2 * shape.blur_px


@pytest.mark.parametrize("distortion", [-0.1, 0.0, 0.3])
def test_pixels_well_inside_keep_away_from_the_border(distortion):
    """Oracle: distance of each pixel's centre to a polygon along the border, its corners carried through the lens."""
    shape, roi = replace(FAR_OUT, distortion=distortion), (0, 45, 20, 75)
    x, y = _border(shape)
    row, column = np.arange(*roi[:2])[:, None, None] - 22.0, np.arange(*roi[2:])[None, :, None] - 31.5
    away = np.sqrt(np.min((row - y) ** 2 + (column - x) ** 2, axis=2))
    within = Path(np.stack([x, y], axis=1)).contains_points(
        np.stack(np.broadcast_arrays(column[..., 0], row[..., 0]), axis=-1).reshape(-1, 2)
    ).reshape(away.shape)  # fmt: skip
    found = well_inside(shape, roi=roi)
    needed = 5 * shape.blur_px + 1
    assert found.sum() > 100
    assert np.all(within[found])
    assert away[found].min() > 0.98 * needed
    assert np.all(found[within & (away > (1.05 if distortion == 0 else 1.8) * needed)])


def test_points_near_the_border_make_the_whole_image_but_for_what_is_well_inside(shape):
    """Oracle: the image of all points of light."""
    shape = replace(shape, blur_px=0.5, outer_radius_px=31.0)
    every, near = light_points(shape), border_points(shape)
    value = [np.exp(-2j * points.angle_rad) for points in (every, near)]
    whole, border = (image(p, v, blur=shape.blur, roi=ROI) for p, v in zip((every, near), value, strict=True))
    inside = well_inside(shape, roi=ROI)
    assert inside.sum() > 50
    assert near.row_px.size < every.row_px.size
    np.testing.assert_allclose(border[~inside], whole[~inside], atol=2e-6)


@pytest.mark.parametrize("order", [1, 4, 16])
def test_smear_of_a_pixel_in_even_light(order):
    """Oracle: exp(-i m phi) averaged over 200 x 200 points of a pixel, each blurred by a Gaussian (Gauss-Hermite)."""
    radius, blur = 31.7, 0.8
    place = (np.arange(200) + 0.5) / 200 - 0.5
    node, weight = np.polynomial.hermite_e.hermegauss(20)
    spread = (place[:, None] + blur * node).ravel()
    weights = np.tile(weight, 200)
    weights = weights / weights.sum()
    wave = np.exp(-1j * order * np.arctan2(spread, radius + spread[:, None]))
    seen = abs(weights @ wave @ weights)
    assert pixel_smear(np.array([radius]), blur_px=blur, order=order)[0] == pytest.approx(
        seen, abs=2e-3 * order**2 / 16
    )
    assert pixel_smear(np.array([0.2, 1.0]), blur_px=blur, order=1).tolist() == pytest.approx(
        [np.exp(-(blur**2 + 1 / 12) / 2)] * 2
    )


def test_a_mirrored_sector_is_the_mirror_image():
    """Oracle: the image read backwards about the axle's column; rows and their angles stay."""
    straight = replace(SHAPE, axle_column_px=30.0)
    other = replace(straight, mirrored=True)
    one, two = (
        image(p, np.exp(1j * p.angle_rad), blur=SHAPE.blur, roi=(0, 40, 0, 61))
        for p in (light_points(straight), light_points(other))
    )
    np.testing.assert_allclose(two, one[:, ::-1], atol=1e-12)
    rows = np.arange(8, 30)
    harmonics = [row_harmonics(light_points(s), rows, blur_px=0.8, n_harmonics=9) for s in (straight, other)]
    np.testing.assert_allclose(harmonics[0], harmonics[1], atol=1e-12)


def test_one_point_of_light_is_spread_as_a_gaussian():
    """Oracle: products of differences of the normal distribution (scipy.stats), up to five blurs away."""
    points = light_points(SHAPE)
    value = np.zeros(points.row_px.size, complex)
    value[100] = (2 - 1j) / points.area_px2[100]
    found = image(points, value, blur=Blur(0.8, 0.8), roi=ROI)
    expected = np.outer(
        _into(np.arange(*ROI[:2]), points.row_px[100:101], 0.8),
        _into(np.arange(*ROI[2:]), points.column_px[100:101], 0.8),
    )
    np.testing.assert_allclose(found, (2 - 1j) * expected, atol=1e-6)


def test_places_of_the_pixels_are_their_polar_coordinates(shape):
    """Oracle: by hand for the pixel four rows above and three columns beside the axle, and a turn all around."""
    at_axle = replace(shape, distortion=0.0, axle_row_px=20.0, axle_column_px=30.0, bisector_rad=float(np.radians(-90)))
    angle, radius = pixel_places(at_axle, roi=(16, 25, 27, 34))
    assert radius[0, 0] == pytest.approx(5)
    assert abs(angle[0, 0]) == pytest.approx(np.arctan2(3, 4))
    assert np.sign(angle[0, 0]) == (1 if shape.mirrored else -1)  # a wheel's own sense counts as clockwise
    assert angle[0, 3] == pytest.approx(0)
    assert np.all((angle >= -np.pi) & (angle < np.pi))
    assert angle.shape == radius.shape == (9, 7)


def test_angles_are_taken_about_the_axle_not_about_the_mask():
    """Oracle: arctan2 of each node about the axle; the mask's own centre lies beside it."""
    points = light_points(SHAPE)
    polar = np.arctan2(points.row_px - SHAPE.axle_row_px, points.column_px - SHAPE.axle_column_px) - SHAPE.bisector_rad
    np.testing.assert_allclose(np.exp(1j * points.angle_rad), np.exp(1j * polar), atol=1e-12)
    own = np.hypot(
        points.row_px - SHAPE.axle_row_px - SHAPE.offset_row_px,
        points.column_px - SHAPE.axle_column_px - SHAPE.offset_column_px,
    )
    assert own.min() > SHAPE.inner_radius_px
    assert own.max() < SHAPE.outer_radius_px
