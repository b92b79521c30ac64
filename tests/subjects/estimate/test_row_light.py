"""Light of the rows: the sector's, what it leaves over, and how it changes with the sector."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.errors import EstimationError
from irtiming.estimate.row_light import SHAPE_NUMBERS, SHAPE_STEPS, Variations, _powers, changes, row_light, shape_of
from irtiming.physics import blurred_sector, sector_points
from irtiming.physics.response.first_order_lag import HARMONICS
from irtiming.records.blur import Blur


@pytest.fixture(scope="module")
def sector(brute_bolometer, sector_of):
    """The camera's sector in a region two rows down and three columns to the right of the image's corner."""
    camera = brute_bolometer(
        axle=(37.2, 34.3), offset=(0.2, -0.3), rows=38, columns=67, distortion=-0.05, tilt_rad=(0.1, -0.06), focal_px=150.0,
        lens_px=(1.5, -2.0),
    )  # fmt: skip
    return sector_of(camera, roi=(2, 38, 3, 67))


@pytest.fixture(scope="module")
def bare(sector):
    """Its light, for a clockwise and for a counterclockwise wheel."""
    return {
        mirrored: row_light(
            ROWS, replace(sector, shape=replace(sector.shape, mirrored=mirrored)), n_harmonics=HARMONICS
        )
        for mirrored in (False, True)
    }


ROWS = np.arange(4, 36)


def test_rows_of_a_bare_sector_are_those_of_the_blurred_sector(sector, bare):
    """Oracle: `physics.blurred_sector`, itself tested by counting; rows with the light of three pixels."""
    found = bare[False]
    whole = blurred_sector.row_harmonics(
        sector_points.light_points(sector.shape, n_harmonics=HARMONICS),
        ROWS,
        blur_px=sector.shape.blur_px,
        n_harmonics=HARMONICS,
    )
    lit = whole[:, 0].real > 3
    assert 20 < lit.sum() < ROWS.size
    np.testing.assert_array_equal(found.is_lit, lit)
    np.testing.assert_array_equal(found.row_px, ROWS[lit])
    np.testing.assert_allclose(found.harmonics, whole[lit])


@pytest.mark.parametrize("kind", ["ring", "borrowed", "excess"])
def test_what_lies_beyond_the_sector_acts_at_its_own_angle(sector, bare, kind):
    """Oracle: by hand; light L at angle a, r from the axle, adds L exp(-i m a) exp(-m^2 (blur^2 + 1/12) / 2 r^2) to its row."""
    light, angle = np.zeros((36, 64)), np.zeros((36, 64))
    light[10, 20], angle[10, 20] = 0.7, 0.3
    light[10, 21], angle[10, 21] = -0.2, -0.4
    light[15, 5], angle[15, 5] = 0.1, 3.0
    seen = row_light(ROWS, replace(sector, **{kind: light, f"{kind}_angle_rad": angle}), n_harmonics=HARMONICS)
    bare = bare[False]
    order = np.arange(HARMONICS + 1)
    added = dict(zip(seen.row_px, seen.harmonics - bare.harmonics, strict=True))
    _, radius = blurred_sector.pixel_places(sector.shape, roi=sector.roi)
    wide = np.exp(-np.multiply.outer((sector.shape.blur_px**2 + 1 / 12) / (2 * radius**2), order**2))
    left, right = wide[10, 20] * np.exp(-0.3j * order), wide[10, 21] * np.exp(0.4j * order)
    np.testing.assert_allclose(added[12], 0.7 * left - 0.2 * right, atol=1e-10)
    np.testing.assert_allclose(added[17], 0.1 * wide[15, 5] * np.exp(-3j * order), atol=1e-10)
    assert all(np.abs(value).max() < 1e-12 for row, value in added.items() if row not in (12, 17))


def test_plate_is_seen_beside_the_opening(sector, bare):
    """Oracle: nearly a whole ring of a warmer plate less the opening in it, both in closed form."""
    shape, blur_px = sector.shape, sector.shape.blur_px
    wider = replace(
        shape,
        inner_radius_px=shape.inner_radius_px - 2,
        outer_radius_px=shape.outer_radius_px + 2,
        opening_angle_rad=6.0,
    )
    points = sector_points.light_points(wider)
    ring = blurred_sector.image(
        points, np.ones(points.row_px.size, complex), blur=Blur(blur_px, blur_px), roi=sector.roi
    ).real
    angle, _ = blurred_sector.pixel_places(shape, roi=sector.roi)
    seen = row_light(ROWS, replace(sector, plate=-0.05, ring=-0.05 * ring, ring_angle_rad=angle), n_harmonics=HARMONICS)
    rows = np.intersect1d(seen.row_px, bare[False].row_px)
    found, opening = (one.harmonics[np.isin(one.row_px, rows)] for one in (seen, bare[False]))
    whole = blurred_sector.row_harmonics(points, rows, blur_px=blur_px, n_harmonics=HARMONICS)
    expected = opening - 0.05 * (whole - opening)
    np.testing.assert_allclose(found[:, :9], expected[:, :9], atol=3e-3)


@pytest.mark.parametrize("beside", [0.03, 0.01, 0.0])
def test_a_warmer_blade_is_told_from_a_mask_plate(sector, beside):
    """Oracle: contrasts by hand; one 3 % less in the opening and q less beside it makes 1, p and f to 0.97, p - q, f."""
    swept, field = np.full(sector.ring.shape, 0.8), 0.01 * np.cos(sector.ring_angle_rad)
    true = replace(sector, plate=-0.05, swept=swept, ring=-0.05 * swept + field)
    seen_plate = (-0.05 - beside) / 0.97
    seen = replace(true, plate=seen_plate, ring=seen_plate * swept + field / 0.97)
    found, expected = (
        row_light(ROWS, seen, n_harmonics=HARMONICS, blade=0.03, beside=beside),
        row_light(ROWS, true, n_harmonics=HARMONICS),
    )
    assert np.array_equal(found.row_px, expected.row_px)
    np.testing.assert_allclose(found.harmonics, expected.harmonics, atol=1e-12)
    if beside == 0.03:
        bare = row_light(ROWS, seen, n_harmonics=HARMONICS)
        assert bare.row_px.size < expected.row_px.size


@pytest.mark.parametrize("number", range(len(SHAPE_NUMBERS)), ids=SHAPE_NUMBERS)
@pytest.mark.parametrize("mirrored", [False, True])
def test_changes_with_the_sector_are_differences(sector, bare, number, mirrored):
    """Oracle: Richardson's extrapolation of central differences over four and eight times the step, low harmonics."""
    sector = replace(sector, shape=replace(sector.shape, glare=0.02, glare_px=2.5, mirrored=mirrored))
    shape = sector.shape
    found = bare[mirrored]
    name, own = SHAPE_NUMBERS[number], SHAPE_STEPS[number]
    ahead, behind = (replace(sector, shape=replace(shape, **{name: getattr(shape, name) + off})) for off in (own, -own))
    (change,) = changes(found, Variations(at=behind, beside=(ahead,), steps=(2 * own,)))
    step = 4 * own
    values = {one: getattr(shape, one) for one in SHAPE_NUMBERS}

    def slope(by):
        low, high = (shape_of(values | {name: values[name] + sign * by}, mirrored, image=(38, 67)) for sign in (-1, 1))
        return (light(high) - light(low)) / (2 * by)

    def light(of):
        points, over_rows = sector_points.light_points(of), of.blur_px * (1 - of.blur_ellipticity)
        sharp = blurred_sector.row_harmonics(points, found.row_px, blur_px=over_rows, n_harmonics=20)
        wide_px = float(np.hypot(over_rows, of.glare_px))
        wide = blurred_sector.row_harmonics(
            sector_points.light_points(replace(of, blur_px=1.0, blur_growth=0.0)),
            found.row_px,
            blur_px=wide_px,
            n_harmonics=20,
        )
        return (1 - of.glare) * sharp + of.glare * wide

    expected = (4 * slope(step) - slope(2 * step)) / 3
    np.testing.assert_allclose(change[:, :21], expected, atol=2e-4 * np.abs(expected).max() + 1e-8)


def test_numbers_make_the_sector_they_were_taken_from(sector):
    """Oracle: round trip through its numbers; more of them are left alone."""
    numbers = {name: getattr(sector.shape, name) for name in SHAPE_NUMBERS} | {"another": 7.0}
    assert shape_of(numbers, False, image=(38, 67)) == sector.shape
    assert shape_of(numbers, True, image=(38, 67)) == replace(sector.shape, mirrored=True)
    assert len(SHAPE_NUMBERS) == 29


def test_too_few_rows_are_refused(sector):
    """Oracle: five rows in the light; six must be."""
    with pytest.raises(EstimationError, match="only 5 image rows hold the light of 3 pixels or more, at least 6 must"):
        row_light(np.array([1, 2, 12, 13, 14, 15, 16]), sector, n_harmonics=HARMONICS)


def test_a_tilted_camera_s_rows_see_the_light_that_was_counted(brute_bolometer):
    """Oracle: sub-pixel points of the turned plane, projected by a rotation matrix and a pinhole and summed row by row."""
    camera = brute_bolometer(tilt_rad=(0.1, -0.06), focal_px=150.0, lens_px=(1.5, -2.0), distortion=-0.05)
    angle, light = camera.light
    rows, order = np.arange(8, 28), np.arange(13)
    expected = np.exp(-1j * np.outer(order, angle)) @ light.sum(axis=2)
    points = sector_points.light_points(camera.shape, n_harmonics=12)
    found = blurred_sector.row_harmonics(points, rows, blur_px=camera.blur_px, n_harmonics=12)
    np.testing.assert_allclose(found, expected[:, rows].T, atol=3e-4 * np.abs(expected[0]).max())


def test_of_the_plates_light_glare_brings_some_from_farther_round(sector, bare):
    """Oracle: by hand; of light L, r from the axle, a share g is smeared by the glare's width beside blur and pixel."""
    light, angle, g, glare_px = np.zeros((36, 64)), np.zeros((36, 64)), 0.2, 4.0
    light[10, 20], angle[10, 20] = 0.7, 0.3
    ring = {"ring": light, "ring_angle_rad": angle, "swept": light}
    glaring = replace(sector, shape=replace(sector.shape, glare=g, glare_px=glare_px))
    alone = row_light(ROWS, glaring, n_harmonics=HARMONICS)
    seen = row_light(ROWS, replace(glaring, **ring), n_harmonics=HARMONICS)
    order, at = np.arange(HARMONICS + 1), int(np.flatnonzero(seen.row_px == 12)[0])
    _, radius = blurred_sector.pixel_places(sector.shape, roi=sector.roi)
    variances = (sector.shape.blur_px**2 + 1 / 12) + np.array([0.0, glare_px**2])[:, None]
    stays, astray = 0.7 * np.exp(-0.3j * order) * np.exp(-variances * order**2 / (2 * radius[10, 20] ** 2))
    np.testing.assert_allclose((seen.harmonics - alone.harmonics)[at], (1 - g) * stays + g * astray, atol=1e-10)
    np.testing.assert_allclose(seen.before[at], (1 - g) * stays + g * astray, atol=1e-10)
    assert abs(astray[6]) < 0.8 * abs(stays[6])


def test_powers_of_the_light_are_those_of_each_row_of_the_region(sector):
    """Oracle: by hand; two pixels of row 12, the eleventh of the region: squares and cubes of their light at their angles."""
    light, angle = np.zeros((36, 64)), np.zeros((36, 64))
    light[10, 20:22], angle[10, 20:22] = (0.5, 0.2), (0.3, -0.4)
    found = _powers(replace(sector, contrast=light, excess_angle_rad=angle), np.array([10, 12]), n_harmonics=6)
    waves = np.exp(-1j * np.outer(np.arange(7), [0.3, -0.4]))
    np.testing.assert_allclose(found.squares, [np.zeros(7), waves @ [0.25, 0.04]], atol=1e-12)
    np.testing.assert_allclose(found.cubes, [np.zeros(7), waves @ [0.125, 0.008]], atol=1e-12)
    np.testing.assert_allclose(found.askew, [np.zeros(7), waves @ [0.375, 0.096]], atol=1e-12)


def test_a_row_is_smeared_as_the_mean_square_width_of_its_light_says(sector):
    """Oracle: by hand; of two pixels of 0.5 and 0.2 of the light, blur and pixel over their distances from the axle."""
    light = np.zeros((36, 64))
    light[10, [12, 30]] = 0.5, 0.2
    found = _powers(replace(sector, contrast=light), np.array([12]), n_harmonics=6)
    shape = sector.shape
    away = np.hypot(12 - shape.axle_row_px, sector.roi[2] + np.array([12, 30]) - shape.axle_column_px)
    squares = (shape.blur_px**2 + 1 / 12) / away**2
    assert squares[0] != pytest.approx(squares[1], rel=0.1)
    mean = (0.25 * squares[0] + 0.04 * squares[1]) / 0.29
    assert -2 * np.log(found.smear) == pytest.approx([mean], rel=1e-6)
