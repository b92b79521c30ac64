"""What a contrast image would be, against frames that were summed point by point in the time domain."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from irtiming.estimate import contrast_look, sector_guess, sector_image
from irtiming.estimate.point_table import PointTable
from irtiming.estimate.row_light import SHAPE_NUMBERS
from irtiming.estimate.sector_image import NUMBERS, SeenContrast, View
from irtiming.physics import blurred_ring, blurred_sector
from irtiming.physics.blur_shape import exchanged
from irtiming.physics.wheel_angle import wheel_angle_rad

TURN = 2 * np.pi


@pytest.fixture(scope="module")
def camera(brute_bolometer):
    return brute_bolometer(offset=(0.3, -0.2))


@pytest.fixture(scope="module")
def lag(camera):
    """Timing that made the frames."""
    return camera.timing


@pytest.fixture(scope="module")
def rows(camera, brute_rows):
    """Frames in two stretches, a tenth of them lost."""
    keep = np.delete(np.arange(400), np.random.default_rng(0).choice(400, 40, replace=False))
    return brute_rows(camera, keep=keep, segment=(np.arange(400) > 170).astype(np.int64), offset_dn=(-50.0, 80.0))


def _view(rows, **fields):
    good = rows.contrast.good
    return View(
        **(
            {
                "roi": rows.contrast.roi,
                "good": good,
                "summed": rows.opening.summed,
                "mirrored": False,
                "image": rows.opening.mask.shape,
                "field_prior": 0.1,
            }
            | fields
        )
    )


def _numbers(camera):
    return (
        dict.fromkeys(NUMBERS, 0.0)
        | {name: getattr(camera.shape, name) for name in SHAPE_NUMBERS}
        | {
            "row_delay_s": camera.row_delay_s,
            "ring_inner_px": camera.radii[0] - 2,
            "ring_outer_px": camera.radii[1] + 2,
        }
    )


def _along(rows, look):
    return np.full(rows.contrast.good.shape, np.hypot(look.u_dn, 0.02 * look.full_dn) + 1j * look.u_dn)


def test_table_is_the_projection_of_a_point_of_light(camera, rows, lag):
    """Oracle: a point that is covered, uncovered and lags in the time domain, summed with the weights of the recording."""
    (look,) = contrast_look.looks([rows], camera.model, timing=lag)
    theta = wheel_angle_rad(0.0, rows.track, at_ticks=rows.trigger_ticks)
    for angle in (-0.6, 0.0, 0.31, 2.0):
        seen = camera.seen(theta + camera.gate_rad - camera.centre_rad - angle)
        assert look.point.values(np.array(angle)) == pytest.approx(rows.contrast.frame_weight @ seen, abs=8e-4)
    np.testing.assert_allclose(look.point.values(np.array([0.3])), look.point.values(np.array([0.3 - TURN])))


@pytest.mark.parametrize("width_rad", [1e-4, 3e-3, 0.02, 0.2, 1.0])
def test_even_light_shows_the_tables_mean_over_its_angles(rows, camera, lag, width_rad):
    """Oracle: a dense sum over the normal distribution; of a few frames, whose table is rough."""
    (look,) = contrast_look.looks([rows], camera.model, timing=lag)
    spectrum = np.fft.fft(look.point.table)
    spectrum[:65] += 200 * np.random.default_rng(2).normal(size=65)
    rough = PointTable(table=np.fft.ifft(spectrum))
    assert np.std(np.abs(rough.table)) > 0.1 * np.mean(np.abs(look.point.table))
    off = np.linspace(-6, 6, 6001)
    weight = np.exp(-0.5 * off**2) / np.sum(np.exp(-0.5 * off**2))
    angle = np.array([0.1, 0.7, 5.0])
    expected = rough.values(angle[:, None] + width_rad * off) @ weight
    found = rough.smeared(angle, width_rad=np.full(3, width_rad))
    np.testing.assert_allclose(found, expected, atol=5e-4 * np.abs(look.point.table).max())


def test_recordings_of_one_speed_are_added_up(camera, rows, lag, brute_rows, brute_bolometer):
    """Oracle: sums over the recordings of a speed, cold ones turned over; uncertainties add up in squares; speeds stay apart."""
    fast = brute_rows(replace(camera, rate_hz=5.0))
    slow, quick = contrast_look.looks([rows, fast, rows], camera.model, timing=lag)
    (one,) = contrast_look.looks([rows], camera.model, timing=lag)
    assert (slow.omega, quick.omega) == (pytest.approx(3 * TURN), pytest.approx(5 * TURN))
    np.testing.assert_allclose(slow.projection, -2 * rows.contrast.projection_dn)
    np.testing.assert_allclose(slow.point.table, 2 * one.point.table, atol=1e-12)
    assert slow.u_dn == pytest.approx(np.sqrt(2) * rows.contrast.u_dn)
    np.testing.assert_array_equal(quick.projection, -fast.contrast.projection_dn)


def test_the_true_numbers_explain_the_image(camera, rows, lag):
    """Oracle: the frames; a contrast of -600 DN turned over, no plate, an even field, nothing left beyond a few thousandths."""
    (look,) = contrast_look.looks([rows], camera.model, timing=lag)
    found = sector_image.fitted(look, _numbers(camera), view=_view(rows, field_prior=1e-3), u_dn=_along(rows, look))
    assert found.full_dn == pytest.approx(600, rel=1e-3)
    assert abs(found.plate) < 1e-3
    assert np.abs(found.field).max() < 2e-3
    lit = camera.light[1].sum(axis=0) > 0.5
    assert np.abs(found.left_dn[lit]).max() < 600 * 3e-3
    assert found.misfit.size == 2 * 36 * 64 + _view(rows).field.size


def test_far_within_the_ring_the_wheel_covers_all_whatever_goes_astray(camera, rows, lag):
    """Oracle: by hand; the ends of the ring are so far that as much light comes as goes astray, a fifth."""
    (look,) = contrast_look.looks([rows], camera.model, timing=lag)
    wide = {"ring_inner_px": -1e3, "ring_outer_px": 1e3, "glare": 0.2, "glare_px": 6.0}
    found = sector_image.fitted(look, _numbers(camera) | wide, view=_view(rows), u_dn=_along(rows, look))
    np.testing.assert_allclose(found.coverage, 1.0, atol=1e-12)


def test_a_warmer_blade_shows_alike_before_the_opening_and_beside_it(camera, rows, lag):
    """Oracle: by hand; a wave once a turn of 2 % of the contrast, smeared by the blur, leaves contrast, plate and rest alone."""
    (look,) = contrast_look.looks([rows], camera.model, timing=lag)
    view, numbers = _view(rows), _numbers(camera) | {"ring_inner_px": -1e3, "ring_outer_px": 1e3}
    once = np.exp(-1j * TURN * np.arange(look.point.table.size) / look.point.table.size)
    odd = PointTable(table=0.02 * np.abs(look.point.table).mean() * once)
    (sharp,) = sector_image.sharp([look], numbers, view=view)
    smeared = np.exp(-(blurred_sector.angular_reach(view.shape(numbers), roi=view.roi) ** 2) / 2)
    warmer = replace(look, projection=look.projection + 600 * smeared * odd.values(sharp.angle_rad), odd=odd)
    none, found, unknown = (
        sector_image.fitted(one, numbers, view=view, u_dn=_along(rows, look))
        for one in (look, warmer, replace(warmer, odd=look.odd))
    )
    assert found.full_dn == pytest.approx(none.full_dn, rel=2e-4)
    assert found.plate == pytest.approx(none.plate, abs=1e-4)
    assert np.abs(found.left_dn - none.left_dn).max() < 0.1
    assert np.abs(unknown.left_dn - none.left_dn).max() > 5


def test_before_a_plate_that_mirrors_too_the_wheel_covers_less_where_it_is_not_open(camera, rows, lag):
    """Oracle: the light that was summed; a plate that mirrors 0.3 leaves 0.7 of the wheel's beside the opening."""
    (look,) = contrast_look.looks([rows], camera.model, timing=lag)
    wide = {"ring_inner_px": -1e3, "ring_outer_px": 1e3, "plate_reflection": 0.3}
    found = sector_image.fitted(look, _numbers(camera) | wide, view=_view(rows), u_dn=_along(rows, look))
    light = camera.light[1].sum(axis=0)
    np.testing.assert_allclose(found.coverage, 1 - 0.3 * (1 - light), atol=3e-3)


def test_uneven_wheel_is_a_field_about_the_mean_contrast(camera, brute_rows, lag):
    """Oracle: pixels that respond by up to 10 % more about a place beside the opening; their mean is the contrast's affair."""
    gain = 1 + 0.1 * np.exp(-0.5 * ((np.arange(36)[:, None] - 25.0) ** 2 + (np.arange(64) - 22.0) ** 2) / 15.0**2)
    rows = brute_rows(camera, gain=gain)
    (look,) = contrast_look.looks([rows], camera.model, timing=lag)
    light = camera.light[1].sum(axis=0)
    view = _view(rows, good=light > 1e-3)  # beside it nothing is mirrored here
    found = sector_image.fitted(look, _numbers(camera), view=view, u_dn=_along(rows, look))
    mean = np.average(gain, weights=light)
    assert found.full_dn == pytest.approx(600 * mean, rel=3e-3)
    assert np.average(found.field, weights=light) == pytest.approx(0, abs=1e-4)
    np.testing.assert_allclose(found.field[light > 0.99], (gain / mean - 1)[light > 0.99], atol=0.015)
    assert found.unevenness == pytest.approx(np.std((gain / mean)[light > 0.99]), rel=0.5)


@pytest.mark.parametrize(
    ("number", "step"),
    [
        *((name, 0.02) for name in SHAPE_NUMBERS[:6]),
        ("bisector_rad", 1e-3),
        ("opening_angle_rad", 1e-3),
        ("blur_px", 0.01),
        ("distortion", 4e-4),
        ("turn_rad", 5e-4),
    ],
)
def test_any_other_number_explains_it_worse(camera, rows, lag, number, step):
    """Oracle: the frames; a thousandth of a pixel's worth in either direction adds to the misfit."""
    (look,) = contrast_look.looks([rows], camera.model, timing=lag)
    view, along = _view(rows, field_prior=1e-3), np.full((36, 64), 0.05 + 0.05j)
    misfits = []
    for by in (-1, 0, 1):
        numbers = _numbers(camera)
        numbers[number] += by * step
        found = sector_image.fitted(replace(look, u_dn=0.05), numbers, view=view, u_dn=along)
        misfits.append(np.sum(found.misfit**2))
    assert misfits[1] < min(misfits[0], misfits[2])


def test_contrast_is_the_light_in_each_pixel(camera, brute_rows, lag):
    """Oracle: the light that was summed; pixels of another gain stand out by just that, a dead one has its neighbours' mean."""
    gain = np.ones((36, 64))
    gain[12, 30], gain[18, 25] = 1.06, 0.97
    rows = brute_rows(camera, gain=gain)
    good = rows.contrast.good.copy()
    good[15, 31] = False
    looks = contrast_look.looks([rows], camera.model, timing=lag)
    along = [_along(rows, look) for look in looks]
    found = sector_image.contrast(looks, _numbers(camera), view=_view(rows, good=good, field_prior=1e-3), u_dn=along)
    light = camera.light[1].sum(axis=0)
    np.testing.assert_allclose(found.light, light, atol=2e-3)
    assert found.residual[12, 30] == pytest.approx(0.06, abs=3e-3)
    assert found.residual[18, 25] == pytest.approx(-0.03, abs=3e-3)
    assert found.residual[15, 31] == pytest.approx(np.mean(found.residual[15, [30, 32]]))
    inside = light > 0.5
    angles, weight = camera.light
    mean_angle = np.einsum("b,bij->ij", angles, weight) / np.maximum(light, 1e-9)
    np.testing.assert_allclose(found.light_angle_rad[inside], mean_angle[inside], atol=2e-3)
    down, across = np.arange(36)[:, None] - camera.axle[0], np.arange(64)[None, :] - camera.axle[1]
    polar = np.exp(1j * (np.arctan2(down, across) - camera.bisector_rad))
    np.testing.assert_allclose(np.exp(1j * found.centre_angle_rad), polar, atol=1e-9)


def test_the_height_of_the_field_is_its_mean_square_over_what_is_likely():
    """Oracle: closed forms; half a normal distribution, of two images together too, and an even one up to the highest."""
    seen = SeenContrast(**(dict.fromkeys(("light", "sharp", "ring", "field", "residual"), np.zeros((1, 1)))
        | dict.fromkeys(("light_angle_rad", "ring_angle_rad", "centre_angle_rad"), np.zeros((1, 1)))
        | {"plate": 0.0, "unevenness": 0.0, "u": 1.0, "fits": []}))  # fmt: skip

    def image(log_evidence):
        return SimpleNamespace(solved=SimpleNamespace(log_evidence=log_evidence))

    bell, even = image(lambda height: -((height / 0.005) ** 2) / 2), image(np.zeros_like)
    assert replace(seen, fits=[bell]).field_height == pytest.approx(0.005, rel=2e-3)
    assert replace(seen, fits=[bell, bell]).field_height == pytest.approx(0.005 / np.sqrt(2), rel=2e-3)
    assert replace(seen, fits=[even]).field_height == pytest.approx(sector_image.HIGHEST_FIELD / np.sqrt(3), rel=0.1)


@pytest.mark.parametrize("mirror", [False, True])
def test_first_guess_is_near(camera, brute_rows, mirror):
    """Oracle: the camera's sector, to a pixel and three degrees; before any lag is known, from a mirrored image too."""
    rows = brute_rows(camera, noise_dn=5.0, mirror=mirror)
    (look,) = contrast_look.looks([rows], camera.model, timing=camera.timing | {"time_constant": 1e-4})
    guess = sector_guess.first_guess(look, _view(rows, mirrored=mirror))
    column = 63 - camera.axle[1] if mirror else camera.axle[1]
    assert guess["axle_row_px"] == pytest.approx(camera.axle[0], abs=1.0)
    assert guess["axle_column_px"] == pytest.approx(column, abs=1.0)
    assert guess["inner_radius_px"] == pytest.approx(camera.radii[0], abs=1.0)
    assert guess["outer_radius_px"] == pytest.approx(camera.radii[1], abs=1.0)
    assert guess["bisector_rad"] == pytest.approx(camera.bisector_rad, abs=0.055)
    assert guess["opening_angle_rad"] == pytest.approx(camera.opening_rad, abs=0.055)
    assert guess["row_delay_s"] == 0
    rolling = sector_guess.first_guess(look, _view(rows, mirrored=mirror), is_rolling=True)
    assert rolling["row_delay_s"] == pytest.approx(camera.row_delay_s, rel=0.3)
    assert (rolling["axle_row_px"], rolling["axle_column_px"]) == pytest.approx((camera.axle[0], column), abs=0.25)


@pytest.mark.parametrize("beside", ["reflection", "plate"])
def test_first_guess_is_of_the_opening_whatever_swings_beside_it(camera, brute_rows, lag, beside):
    """Oracle: the camera's sector, to a pixel and three degrees; the wheel mirrors the camera, or a plate fills the view."""
    (look,) = contrast_look.looks([brute_rows(camera)], camera.model, timing=lag)
    view, numbers = _view(brute_rows(camera)), _numbers(camera)
    angle, radius = blurred_sector.pixel_places(view.shape(numbers), roi=view.roi)
    swings = look.point.values(angle - numbers["turn_rad"])
    highest, room = np.abs(swings).max(), 40
    plate = np.where((radius > numbers["ring_inner_px"]) & (np.abs(angle) > 0.7), -0.25 * swings, 0.0)
    shown = np.pad(
        look.projection + (plate if beside == "plate" else 0.0), ((room, room), (0, 0)),
        constant_values=0.25 * highest if beside == "plate" else 0.0,
    )  # fmt: skip
    if beside == "reflection":
        shown[5:20, 5:25] = 0.9j * highest
    row0, row1, column0, column1 = view.roi
    wide = replace(
        view, roi=(row0 - room, row1 + room, column0, column1), good=np.ones(shown.shape, bool),
        summed=np.pad(view.summed, ((room, room), (0, 0)), constant_values=True),
    )  # fmt: skip
    guess = sector_guess.first_guess(replace(look, projection=shown), wide)
    assert guess["axle_row_px"] == pytest.approx(camera.axle[0], abs=1.0)
    assert guess["axle_column_px"] == pytest.approx(camera.axle[1], abs=1.0)
    assert guess["inner_radius_px"] == pytest.approx(camera.radii[0], abs=1.0)
    assert guess["bisector_rad"] == pytest.approx(camera.bisector_rad, abs=0.055)
    assert guess["opening_angle_rad"] == pytest.approx(camera.opening_rad, abs=0.055)


@pytest.mark.parametrize("axle", [(17.7, 31.8), (18, 32)], ids=["between pixels", "on a pixel"])
def test_first_guess_of_light_all_round_the_axle_is_half_a_turn_at_most(camera, brute_rows, lag, axle):
    """Oracle: the limit; a disc of 15 px whose phases are those of all directions fills a turn, and no opening is so wide."""
    (look,) = contrast_look.looks([brute_rows(camera)], camera.model, timing=lag)
    wide = _view(brute_rows(camera))
    down, across = np.arange(36)[:, None] - axle[0], np.arange(64)[None, :] - axle[1]
    angle, radius = np.arctan2(down, across), np.hypot(down, across)
    shown = np.where(radius < 15, look.point.values(angle), 0.0)
    guess = sector_guess.first_guess(replace(look, projection=shown), replace(wide, summed=np.ones((36, 64), bool)))
    assert (guess["axle_row_px"], guess["axle_column_px"]) == pytest.approx(axle, abs=1.0)
    assert np.isfinite(list(guess.values())).all()
    assert guess["opening_angle_rad"] == 3.0


@pytest.mark.parametrize(("axis", "away"), [(0, 1), (1, 2)])
def test_a_pixel_exchanges_light_with_two_others(axis, away):
    """Oracle: by hand; of one pixel in the light, 6 % go to either side, and nothing is lost."""
    sector = np.zeros((9, 9), complex)
    sector[4, 4] = 1 - 2j
    expected = 0.88 * sector
    for side in (-away, away):
        expected += 0.06 * np.roll(sector, side, axis=axis)
    np.testing.assert_allclose(exchanged(sector, 0.12, axis=axis, away=away), expected, atol=1e-12)


def test_what_goes_astray_over_the_ring_comes_from_farther_round_the_axle(camera, brute_rows, lag):
    """Oracle: what points of light show on a fine grid, spread by a Gaussian of SciPy's; near the axle that is less."""
    rows = brute_rows(camera)
    (look,) = contrast_look.looks([rows], camera.model, timing=lag)
    view, numbers = _view(rows), _numbers(camera) | {"row_delay_s": 0.0, "glare": 0.08, "glare_px": 3.0}
    shape = view.shape(numbers)
    (sharp,) = sector_image.sharp([look], numbers, view=view)
    arcs = numbers["ring_inner_px"], numbers["ring_outer_px"]
    ring = blurred_ring.seen(shape, arcs, even=sharp.even)
    shown = sector_image._shown(look, sharp, shape, ring=ring, roi=view.roi)
    fine, beyond = 3, 12.0
    row, column = (
        np.arange(ends[0] - beyond, ends[-1] + beyond + 1, 1 / fine) for ends in (view.rows[:, 0], view.columns[0])
    )
    down, right = row[:, None] - shape.axle_row_px, column - shape.axle_column_px
    radius, angle = np.hypot(down, right), np.arctan2(down, right) - shape.bisector_rad
    there = (radius > arcs[0]) & (radius < arcs[1])
    light = there * look.point.values(angle - numbers["turn_rad"])
    astray = gaussian_filter(light, fine * 3.0, mode="constant")
    stays = gaussian_filter(light, fine * np.hypot(shape.blur_px, 12**-0.5), mode="constant")
    at = np.ix_(*(_nodes_at(ends, beyond, fine) for ends in (view.rows[:, 0], view.columns[0])))
    ringed = (sharp.even.radius_px > arcs[0] + 2) & (sharp.even.radius_px < arcs[1] - 2)
    exact = 0.92 * stays[at] + 0.08 * astray[at]
    as_if_straight = ring.whole * sharp.point
    off, was = (
        np.sqrt(np.mean(np.abs(one - exact)[ringed] ** 2)) / np.abs(look.point.table).mean()
        for one in (shown, as_if_straight)
    )
    assert off < 0.0015
    assert was > 0.004


def _nodes_at(ends, beyond, fine):
    """Nodes of the fine grid that are the middles of pixels."""
    return np.round((ends - ends[0] + beyond) * fine).astype(int)


def test_model_and_residual_are_the_measured_contrast(camera, brute_rows, lag):
    """Oracle: the image itself, along its phase over a lit pixel; in one place pixels respond by up to 10 % more."""
    gain = 1 + 0.1 * np.exp(-0.5 * ((np.arange(36)[:, None] - 25.0) ** 2 + (np.arange(64) - 22.0) ** 2) / 15.0**2)
    rows = brute_rows(camera, gain=gain)
    (look,) = contrast_look.looks([rows], camera.model, timing=lag)
    view, numbers, along = _view(rows), _numbers(camera), _along(rows, look)
    seen = sector_image.contrast([look], numbers, view=view, u_dn=[along])
    (sharp,) = sector_image.sharp([look], numbers, view=view)
    shown = (look.projection * sharp.point.conj()).real / np.abs(sharp.point) ** 2
    full_dn = sector_image.fitted(look, numbers, view=view, u_dn=along).full_dn
    np.testing.assert_allclose(seen.model + seen.residual, shown / full_dn, atol=6e-3)
    assert np.ptp(seen.over_ring) > 0.05
