"""The sector that comes back from a contrast image of known light."""

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import ndimage
from scipy.special import ndtr

from irtiming.errors import EstimationError
from irtiming.estimate import image_doubts, row_fit, sector_best, sector_fit, sector_image, sector_images, sector_limits
from irtiming.estimate.row_light import SHAPE_NUMBERS, row_light
from irtiming.estimate.sector_search import Slopes
from irtiming.physics import blurred_sector
from irtiming.physics.light.row_sum import EDGE_DELAYS
from irtiming.physics.response.first_order_lag import HARMONICS
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.reduced import FoundInSums
from irtiming.records.rig import Measured

AT_ONCE = dict.fromkeys(EDGE_DELAYS, 0.0) | {"time_constant": 1e-4}


@pytest.fixture(scope="module")
def camera(brute_bolometer):
    """Mask beside the axle."""
    return brute_bolometer(offset=(0.35, -0.25), bisector_rad=float(np.radians(-88.3)))


@pytest.fixture(scope="module")
def lag(camera):
    return camera.timing


def _pulls(found, camera):
    numbers = [getattr(found.shape, name) - getattr(camera.shape, name) for name in found.names]
    return np.array(numbers) / np.sqrt(np.diag(found.covariance))


def _twice(rows, camera, lag, *, rig, start=None):
    """First without knowing the lag, then with it and with what the fit before left over, as the camera's estimate does.

    A fit of much the same image may stand in for the first.
    """
    found, slopes = start or sector_fit.fit([rows], camera.model, rig=rig, timing=AT_ONCE), Slopes()
    for _ in range(2):  # the first knows nothing of the lens
        found = sector_fit.fit([rows], camera.model, rig=rig, timing=lag, start=found, slopes=slopes)
    return found


@pytest.fixture(scope="module")
def noisy(camera, brute_rows):
    """Rows of even pixels with noise."""
    return brute_rows(camera, noise_dn=6.0, seed=3)


@pytest.fixture(scope="module")
def plain(camera, lag, noisy, rig_with):
    """Fit of even pixels with noise."""
    return _twice(noisy, camera, lag, rig=rig_with())


def test_the_sector_comes_back(plain, camera):
    """Oracle: the light that was summed; ten numbers and the row delay within four uncertainties, which are small."""
    assert np.all(np.abs(_pulls(plain, camera)) < 4)
    u = np.sqrt(np.diag(plain.covariance))
    assert u[:2].max() < 0.05
    assert u[6] < 2e-3
    assert abs(plain.row_delay_s - camera.row_delay_s) < 4 * plain.u_row_delay_s
    assert plain.u_row_delay_s < 2e-6
    assert plain.reduced_chi_square == pytest.approx(1, abs=0.15)
    assert plain.n_rounds == 3


def test_half_of_the_way_is_the_middle_between_the_start_and_the_end(plain, camera, lag, noisy, rig_with):
    """Oracle: the whole way from the same start, halved; an axle that is half a pixel off comes back to a quarter."""
    shape = plain.shape
    start = replace(plain, shape=replace(shape, axle_row_px=shape.axle_row_px + 0.5))
    whole, half = (
        go([noisy], camera.model, rig=rig_with(), timing=lag, start=start)
        for go in (sector_fit.fit, sector_fit.half_way)
    )
    for name in ("axle_row_px", "blur_px", "bisector_rad"):
        assert half.value(name) == pytest.approx((start.value(name) + whole.value(name)) / 2, abs=1e-9)
    assert half.value("axle_row_px") - shape.axle_row_px == pytest.approx(0.25, abs=0.05)
    assert half.n_rounds == whole.n_rounds == 4


def test_a_row_delay_is_looked_for_where_there_should_be_none(plain, camera, lag, noisy, rig_with):
    """Oracle: the row delay of the light that was summed; the camera is said to read all rows at once."""
    at_once = replace(noisy, readout_mode="snapshot")
    found = sector_fit.fit_row_by_row([at_once], camera.model, rig=rig_with(), timing=lag, start=plain)
    assert abs(found.row_delay_s - camera.row_delay_s) < 4 * found.u_row_delay_s
    held = sector_fit.fit([at_once], camera.model, rig=rig_with(), timing=lag, start=plain)
    assert held.u_row_delay_s == 0


def test_rows_in_a_guessed_sector_tell_the_lag(camera, lag, noisy, rig_with):
    """Oracle: the camera's lag and delay; a sector to a pixel or two tells them to a quarter of the lag."""
    guessed = sector_fit.guess([noisy], camera.model, rig=rig_with(), timing=AT_ONCE)
    assert guessed.n_rounds == 0
    assert not guessed.covariance.any()
    seen = row_fit.fit(noisy, camera.model, light=row_light(noisy.row_sums.row_px, guessed, n_harmonics=HARMONICS))
    assert seen.timing["time_constant"] == pytest.approx(lag["time_constant"], rel=0.25)
    assert seen.timing["edge_delay_0"] == pytest.approx(lag["edge_delay_0"], abs=0.25 * lag["time_constant"])


def test_a_blur_that_is_not_round_comes_back(brute_bolometer, lag, brute_rows, rig_with):
    """Oracle: the light that was summed through 0.5 px over rows and 0.9 px over columns."""
    soft = brute_bolometer(offset=(0.35, -0.25), blur_px=0.7, blur_ellipticity=2 / 7)
    found = _twice(brute_rows(soft, noise_dn=6.0, seed=3), soft, lag, rig=rig_with())
    assert abs(found.shape.blur_ellipticity - 2 / 7) < 4 * found.u("blur_ellipticity") < 0.1
    assert abs(found.shape.blur_px - 0.7) < 4 * found.u("blur_px") < 0.06
    assert abs(found.row_delay_s - soft.row_delay_s) < 4 * found.u_row_delay_s
    assert np.all(np.abs(_pulls(found, soft)) < 4)


@pytest.mark.parametrize("mirror", [False, True])
def test_a_blur_along_a_diagonal_comes_back(brute_bolometer, lag, brute_rows, rig_with, mirror):
    """Oracle: the light that was summed, points moved along a diagonal; read backwards, the other diagonal. No number is off."""
    soft = brute_bolometer(offset=(0.35, -0.25), blur_px=0.75, blur_ellipticity=0.1, blur_correlation=-0.5, sub=6)
    rows = brute_rows(soft, noise_dn=6.0, seed=3, mirror=mirror)
    found = _twice(rows, soft, lag, rig=rig_with(mirrored=mirror))
    expected = 0.5 if mirror else -0.5
    assert abs(found.shape.blur_correlation - expected) < 4 * found.u("blur_correlation") < 0.2
    assert abs(found.shape.blur_ellipticity - 0.1) < 4 * found.u("blur_ellipticity") < 0.1
    assert abs(found.shape.blur_px - 0.75) < 4 * found.u("blur_px") < 0.06
    assert abs(found.row_delay_s - soft.row_delay_s) < 4 * found.u_row_delay_s
    assert image_doubts.of_image(found) == ()
    if not mirror:
        assert np.all(np.abs(_pulls(found, soft)) < 4)


def test_a_blur_that_grows_to_the_corners_comes_back(brute_bolometer, lag, brute_rows, rig_with):
    """Oracle: the light that was summed, each point spread by its own width; twice the variance half a diagonal off."""
    soft = brute_bolometer(offset=(0.35, -0.25), blur_px=0.6, blur_growth=2.0, sub=6)
    rows = brute_rows(soft, noise_dn=6.0, seed=3)
    found = _twice(rows, soft, lag, rig=rig_with())
    assert abs(found.shape.blur_growth - 2.0) < 4 * found.u("blur_growth") < 2.0
    assert abs(found.shape.blur_px - 0.6) < 4 * found.u("blur_px") < 0.1
    assert np.all(np.abs(_pulls(found, soft)) < 4)


def test_even_pixels_leave_nothing_over(plain, camera):
    """Oracle: the light that was summed; no scatter of gains, no plate, and an excess that is noise."""
    light = camera.light[1].sum(axis=0)
    np.testing.assert_allclose(plain.model_contrast, light, atol=0.02)
    assert plain.gain_scatter < 1e-3
    assert plain.border_scatter < 2e-3
    assert abs(plain.excess).max() < 6 * 6.0 * np.sqrt(2 / 400) / 600
    np.testing.assert_allclose(plain.contrast[light > 0.9], light[light > 0.9], atol=0.01)


def test_pixels_that_differ_are_told_and_do_not_move_the_axle(plain, camera, lag, brute_rows, rig_with):
    """Oracle: gains that were drawn, 3 % apart; the excess is theirs, axle and bisector stay within their uncertainties."""
    gain = 1 + 0.03 * np.random.default_rng(4).standard_normal((36, 64))
    found = _twice(brute_rows(camera, gain=gain, noise_dn=6.0, seed=5), camera, lag, rig=rig_with(), start=plain)
    light = camera.light[1].sum(axis=0)
    inside = light > 0.99
    assert found.gain_scatter == pytest.approx(0.03, rel=0.2)
    seen = (found.contrast - found.model_contrast)[inside]
    np.testing.assert_allclose(seen - seen.mean(), (gain[inside] - gain[inside].mean()), atol=0.012)
    assert np.all(np.abs(_pulls(found, camera)) < 4)


def test_a_dead_pixel_on_the_border_shows_its_neighbours(plain, camera, lag, brute_rows, rig_with):
    """Oracle: the light that was summed, with the mean of left and right in place of the dead pixel, as the row sums have it."""
    rows = brute_rows(camera, noise_dn=0.5)
    angles, light = camera.light
    border = [(row, int(np.flatnonzero(light[:, row].sum(axis=0) > 0.5)[0])) for row in (12, 16, 20)]
    good, shown = np.ones((36, 64), bool), light.copy()
    for row, column in border:
        good[row, column] = False
        shown[:, row, column] = (light[:, row, column - 1] + light[:, row, column + 1]) / 2
    dead = replace(rows, contrast=replace(rows.contrast, good=good))
    seen = row_light(rows.rows.row_px, _twice(dead, camera, lag, rig=rig_with(), start=plain), n_harmonics=HARMONICS)
    waves = np.exp(-1j * np.multiply.outer(np.arange(7), angles))
    for row, _ in border:
        found = seen.harmonics[np.searchsorted(seen.row_px, row), :7]
        expected, own = (waves @ one[:, row].sum(axis=1) for one in (shown, light))
        off = np.abs(found / found[0] - expected / expected[0]).max()
        assert off < 0.3 * np.abs(own / own[0] - expected / expected[0]).max()


def test_a_mirrored_image_is_the_same_sector(plain, camera, lag, brute_rows, rig_with):
    """Oracle: the image read backwards, counterclockwise; columns are counted leftwards, so the axle alone moves."""
    found = _twice(brute_rows(camera, noise_dn=6.0, seed=3, mirror=True), camera, lag, rig=rig_with(mirrored=True))
    assert found.shape.mirrored
    other = camera.shape
    assert found.shape.axle_column_px == pytest.approx(63 - other.axle_column_px, abs=0.05)
    for name in SHAPE_NUMBERS:
        if name != "axle_column_px":
            assert getattr(found.shape, name) == pytest.approx(getattr(plain.shape, name), abs=6 * plain.u(name)), name


def test_phases_of_two_speeds_may_differ(camera, brute_rows, rig_with):
    """Oracle: the axle. Before the lag is known, 2.3 ms and 6 ms turn the second harmonic by another angle at each speed."""
    recordings = [brute_rows(replace(camera, rate_hz=rate), noise_dn=6.0, seed=int(rate)) for rate in (3.0, 7.0)]
    found = sector_fit.fit(recordings, camera.model, rig=rig_with(), timing=AT_ONCE)
    assert found.shape.axle_row_px == pytest.approx(camera.axle[0], abs=0.1)
    assert found.shape.axle_column_px == pytest.approx(camera.axle[1], abs=0.1)
    assert found.row_delay_s == pytest.approx(camera.row_delay_s, abs=12e-6)
    assert found.reduced_chi_square < 2


@pytest.mark.parametrize("off_s", [0.0, 2e-3])
def test_images_of_two_speeds_tell_the_row_delay_whatever_the_delay(camera, lag, brute_rows, rig_with, off_s):
    """Oracle: the camera's row delay, and its axle; each image is turned by its own angle, in all orders of the wheel."""
    recordings = [brute_rows(replace(camera, rate_hz=rate), noise_dn=6.0, seed=int(rate)) for rate in (1.5, 7.53)]
    found, later = None, {name: lag[name] + off_s * (name in EDGE_DELAYS) for name in lag}
    for _ in range(4):
        found = sector_fit.fit(recordings, camera.model, rig=rig_with(), timing=later, start=found)
    assert abs(found.row_delay_s - camera.row_delay_s) < 3 * found.u_row_delay_s < 3e-6
    assert abs(found.shape.axle_column_px - camera.axle[1]) < 3 * found.u("axle_column_px")


@pytest.mark.parametrize(
    ("fit", "n_before", "refused"),
    [("fit", 1, False), ("fit", 2, False), ("fit", 3, True), ("settled", 1, True), ("fit_row_by_row", 1, True)],
)
def test_first_fits_may_have_any_lens(plain, camera, lag, noisy, rig_with, monkeypatch, fit, n_before, refused):
    """Oracle: by hand; where no lens centre is near enough, the fourth fit and the last one are refused, those before not.

    In a simulated laboratory at four speeds the third had its lens centre 33 px aside, and the fourth where it is.
    """
    monkeypatch.setattr(sector_limits, "FARTHEST_CENTRE", 0.0)
    start = replace(plain, n_rounds=n_before)
    made = getattr(sector_fit, fit)
    with pytest.raises(EstimationError, match="no lens shows") if refused else nullcontext():
        assert made([noisy], camera.model, rig=rig_with(), timing=lag, start=start).n_rounds == n_before + 1


def test_a_slit_is_no_sector(brute_bolometer, brute_rows, rig_with):
    """Oracle: a mask of two pixels' width, of which three at least must be."""
    slit = brute_bolometer(radii=(15.0, 17.0))
    with pytest.raises(
        EstimationError,
        match="counted: the opening does not look like an annular sector about the axle: .* the whole opening must be",
    ):
        sector_fit.fit([brute_rows(slit, noise_dn=6.0)], slit.model, rig=rig_with(), timing=AT_ONCE)


@pytest.mark.parametrize(
    ("mirror", "rotation", "way"),
    [
        (False, "clockwise", ""),
        (True, "clockwise", "left"),
        (False, "counterclockwise", "right"),
        (True, "counterclockwise", ""),
    ],
)
def test_the_image_says_against_which_rotation_it_is(brute_rows, camera, lag, rig_with, mirror, rotation, way):
    """Oracle: the opening stands above the axle, so that a clockwise wheel moves edges to the right, mirrored to the left."""
    rig = rig_with(mirrored=rotation == "counterclockwise")
    rows = brute_rows(camera, noise_dn=6.0, mirror=mirror)
    sense = sector_images.of([rows], camera.model, rig=rig, timing=lag, known=None).sense()
    assert (sense.way if sense else "") == (f"to the {way}" if way else "")
    assert sense is None or sense.stated == f"[wheel] rotation = '{rotation}' with [mask] centre_angle_deg = -90"


def _over_half_width(k, camera):
    """Distortion over half a diagonal, as rig.toml states it: over half the image's width."""
    scale = camera.columns**2 / (camera.rows**2 + camera.columns**2)
    return Measured(k.value * scale, k.standard_uncertainty * scale)


@pytest.mark.parametrize("known", [None, Measured(-0.08, 0.01)])
def test_the_lens_is_told_by_an_axle_far_from_the_middle(brute_bolometer, lag, brute_rows, rig_with, known):
    """Oracle: the lens through which the light was placed; all numbers within four uncertainties, whatever rig.toml says."""
    bent = brute_bolometer(offset=(0.35, -0.25), distortion=-0.08)
    rig = rig_with() if known is None else rig_with(distortion=_over_half_width(known, bent))
    found = _twice(brute_rows(bent, noise_dn=6.0, seed=3), bent, lag, rig=rig)
    assert np.all(np.abs(_pulls(found, bent)) < 4)
    assert np.sqrt(found.covariance[9, 9]) < 0.01
    assert found.reduced_chi_square == pytest.approx(1, abs=0.15)


def test_a_lens_that_the_image_does_not_tell_is_as_rig_toml_states(brute_bolometer, lag, brute_rows, rig_with):
    """Oracle: an axle and mask in the middle of the image, round which a lens changes radii alone; the prior stays."""
    round_it = brute_bolometer(rows=65, columns=65, axle=(32.0, 32.0))
    rows = brute_rows(round_it, noise_dn=6.0, seed=3)
    stated = _over_half_width(Measured(-0.03, 0.02), round_it)
    found = _twice(rows, round_it, lag, rig=rig_with(distortion=stated))
    assert found.shape.distortion == pytest.approx(-0.03, abs=0.01)
    u = np.sqrt(np.diag(found.covariance))
    assert 0.01 < u[9] < 0.03
    assert abs(found.shape.outer_radius_px - 29.6) < 4 * u[5]
    assert abs(found.shape.bisector_rad - round_it.bisector_rad) < 4 * u[6] < 0.01
    tied = found.covariance[9, 5] / (u[9] * u[5])
    assert abs(tied) > 0.9  # radii and lens are uncertain together, so that what is seen is certain


@pytest.mark.parametrize(("reflection", "plate"), [(0.0, -0.03), (1.0, 0.02)])
def test_the_plate_and_what_it_reflects_do_not_turn_the_mask(
    plain, camera, lag, brute_rows, rig_with, reflection, plate
):
    """Oracle: contrast made pixel by pixel: 5 % of it reflected by the wheel at one end, the plate's part at its own phase."""
    rows = brute_rows(camera, noise_dn=2.0, seed=6)
    down, across = np.arange(36)[:, None] - camera.axle[0], np.arange(64)[None, :] - camera.axle[1]
    angle, radius = np.arctan2(down, across) - camera.bisector_rad, np.hypot(down, across)
    theta = wheel_angle_rad(0.0, rows.track, at_ticks=rows.trigger_ticks) + camera.gate_rad - camera.centre_rad
    light, ring = camera.light[1].sum(axis=0), ndtr((radius - 5.3) / 0.85) * ndtr((32.6 - radius) / 0.85)
    reflected = 0.05 * np.exp(-0.5 * ((down + 14) ** 2 + (across - 17) ** 2) / 9.0**2)
    beyond = light * (plate + reflected) + (ring - light) * (plate + (1 - reflection) * reflected)
    more = np.zeros((36, 64), complex)
    for row, column in np.argwhere((ring > 1e-4) | (light > 0)):
        at = theta - angle[row, column] + camera.omega * row * camera.row_delay_s
        more[row, column] = -600 * beyond[row, column] * (rows.contrast.frame_weight @ camera.seen(at))
    image = replace(rows.contrast, projection_dn=rows.contrast.projection_dn + more)
    found = _twice(replace(rows, contrast=image), camera, lag, rig=rig_with(), start=plain)
    assert abs(found.shape.bisector_rad - camera.bisector_rad) < 4 * found.u("bisector_rad") < 4e-3
    mean = np.average(reflected, weights=light)
    assert found.plate == pytest.approx((plate + (1 - reflection) * mean) / (1 + plate + mean), abs=0.005)
    assert found.plate_reflection == pytest.approx(reflection, abs=0.35)
    assert found.unevenness > 0.004


def test_a_tilted_camera_with_its_lens_centre_aside(brute_bolometer, brute_rows, rig_with):
    """Oracle: the turned plane before a pinhole from which the light came; tilt, focal length, axle and row delay within 4 u."""
    tilted = brute_bolometer(
        tilt_rad=(0.12, -0.09), focal_px=90.0, lens_px=(1.5, -2.0), distortion=-0.03, offset=(0.2, 0.1)
    )
    found = _twice(brute_rows(tilted, noise_dn=3.0, seed=5), tilted, tilted.timing, rig=rig_with())
    truth = tilted.shape
    for name in ("axle_row_px", "axle_column_px", "keystone_row", "keystone_column", "log_focal_length", "lens_row_px"):
        assert abs(getattr(found.shape, name) - getattr(truth, name)) < 4 * found.u(name), name
    assert abs(found.shape.keystone_row) > 4 * found.u("keystone_row")
    assert abs(found.row_delay_s - tilted.row_delay_s) < 4 * found.u_row_delay_s


def test_pixels_that_exchange_light_leave_no_blur_over(plain, camera, lag, brute_rows, rig_with):
    """Oracle: the exchange that was put in, 10 % with the columns beside, of variance 0.1 px^2, which the blur takes."""
    rows = brute_rows(camera, noise_dn=0.5, seed=3)
    parts = [
        ndimage.correlate1d(one, [0.05, 0.9, 0.05], axis=1)
        for one in (rows.contrast.projection_dn.real, rows.contrast.projection_dn.imag)
    ]
    image = replace(rows.contrast, projection_dn=parts[0] + 1j * parts[1])
    exchanging = replace(rows, contrast=image)
    before = _twice(exchanging, camera, lag, rig=rig_with(), start=plain)
    found = sector_fit.settled([exchanging], camera.model, rig=rig_with(), timing=lag, start=before)
    assert found.n_rounds == before.n_rounds + 1
    assert np.abs(image_doubts.left_over(found).variance_px2).max() < 0.01
    assert found.shape.blur.columns_px**2 - camera.shape.blur.columns_px**2 == pytest.approx(0.1, rel=0.3)


def test_a_gain_that_is_not_quite_known_does_not_move_the_axle(camera, lag, brute_rows, brute_frames, rig_with):
    """Oracle: the sector of even levels; the gain goes as the wheel's fourth order, 2 u off what is known of it."""
    rows = brute_rows(camera, noise_dn=0.5, seed=3)
    wave = np.cos(4 * camera.omega * 0.033 * np.arange(400) + 1.0)
    _, openness = brute_frames(camera)
    change = -600 * 0.004 * wave[:, None, None] * (openness - openness.mean(axis=0))
    moved = rows.contrast.projection_dn + np.einsum("n,nij->ij", rows.contrast.frame_weight, change)
    known = FoundInSums(
        edges_late_rad=camera.omega * np.array([lag[name] for name in EDGE_DELAYS]), blade_share=0.0, relative_gain=np.ones(400),
        u_gain=0.002 * wave[:, None], u_offset=np.zeros((400, 1)),
    )  # fmt: skip
    told, taken_as_known = (
        _twice(
            replace(rows, contrast=replace(rows.contrast, projection_dn=moved, in_sums=one)),
            camera,
            lag,
            rig=rig_with(),
        )
        for one in (known, None)
    )
    even = _twice(rows, camera, lag, rig=rig_with())

    def off(found):
        return np.hypot(
            found.shape.axle_row_px - even.shape.axle_row_px, found.shape.axle_column_px - even.shape.axle_column_px
        )

    assert off(taken_as_known) > 5 * off(told)
    assert off(told) < even.u("axle_row_px")
    assert told.reduced_chi_square < 1.05 * even.reduced_chi_square


@pytest.mark.parametrize(
    ("at", "stray", "is_odd"), [(3, 0.011, True), (3, 0.009, False), (12, 0.15, False), (12, 0.25, True)]
)
def test_a_lone_dead_pixel_beside_the_opening_is_odd(at, stray, is_odd):
    """Oracle: by hand; ten times a noise of 0.001 beside the light, ten times gains of 0.02 within; no neighbour is."""
    residual, light = np.zeros((16, 16)), np.zeros((16, 16))
    light[8:], residual[at, 5] = 1.0, stray
    seen = SimpleNamespace(residual=residual, light=light, u=1e-3)
    odd = sector_fit._odd(seen, np.zeros((16, 16)), gain_scatter=0.02, border_scatter=0.0)
    assert odd[at, 5] == is_odd
    assert odd.sum() == is_odd


def test_structure_that_neighbours_share_is_not_odd():
    """Oracle: by hand; stray light of 15 noises that falls off over the image is no dead pixel."""
    residual = np.linspace(0.015, 0, 16)[:, None] + np.zeros((16, 16))
    seen = SimpleNamespace(residual=residual, light=np.zeros((16, 16)), u=1e-3)
    assert not sector_fit._odd(seen, np.zeros((16, 16)), gain_scatter=0.02, border_scatter=0.0).any()


def test_burrs_are_counted_by_the_light_of_a_pixel_on_the_border():
    """Oracle: burrs that were drawn, 0.05 where the border halves a pixel, falling with the root of the light's slope."""
    rng, blur_px = np.random.default_rng(1), 3.0
    off = np.arange(40) - 19.5
    sharp = np.tile(ndtr(off / np.hypot(blur_px, np.sqrt(1 / 12))), (60, 1))
    residual = 0.05 * np.exp(-(off**2) / (4 * blur_px**2)) * rng.standard_normal(sharp.shape)
    seen = SimpleNamespace(
        sharp=sharp, light=sharp, residual=residual, u=0.0, model=sharp, plate=0.0, ring=0.0 * sharp, over_ring=0.0 * sharp,
        ring_angle_rad=0.0 * sharp, centre_angle_rad=0.0 * sharp, light_angle_rad=0.0 * sharp, unevenness=0.0, field_height=0.1,
    )  # fmt: skip
    good = np.ones(sharp.shape, bool)
    view = SimpleNamespace(good=good, summed=good, stand_ins=[], shape=lambda _: None, roi=(0, 60, 0, 40))
    numbers = dict.fromkeys((*SHAPE_NUMBERS, *sector_image.NUMBERS), 0.0) | {"blur_px": blur_px}
    images = SimpleNamespace(view=view, contrast=lambda _: seen)
    found = sector_fit._told(images, numbers, names=(), covariance=np.zeros((0, 0)), chi_square=1.0)
    assert found.border_scatter == pytest.approx(0.05, rel=0.06)


def test_phases_of_a_sector_err_together(camera):
    """Oracle: by hand; pixels behind one another share what is across their phase, in all images; others do not."""
    roi, shape = (10, 26, 20, 44), camera.shape
    good = np.ones((16, 24), bool)
    view = SimpleNamespace(good=good, roi=roi, shape=lambda _: shape)
    images = SimpleNamespace(view=view, seen=2 * [SimpleNamespace(swayed=())])
    n, first = good.size, sector_best.N_PRIORS
    found = sector_best._clusters(images, {}, first + 2 * 2 * n)
    assert np.all(found[:first] == -1)
    across = found[first:].reshape(2, 2, n)[:, 1]
    angle, radius = blurred_sector.pixel_places(shape, roi=roi)
    beside = np.abs(angle.ravel()[:, None] - angle.ravel()) * radius.mean()
    together = across[0][:, None] == across[0]
    assert together[beside < 1e-9].all()
    assert not together[beside > 6.1].any()
    assert np.mean(together[beside < 1.0]) > 0.5
    assert np.array_equal(across[0], across[1])


def test_of_dead_pixels_those_that_are_summed_are_stood_in_for():
    """Oracle: by hand; one of three summed pixels is dead, and one beside them that no sum has: its neighbour lends nothing."""
    light, residual = np.array([[0.1, 0.5, 0.9, 0.7, 0.2]]), np.array([[9.0, 0.2, 9.0, 0.4, 0.1]])
    summed = np.array([[False, True, True, True, False]])
    good = np.array([[False, True, False, True, True]])
    view = sector_image.View(
        roi=(0, 1, 0, 5), image=(1, 5), good=good, summed=summed, mirrored=False, field_prior=0.1
    )  # fmt: skip
    assert sector_fit._borrowed(light, view) == pytest.approx(np.array([[0.0, 0.25, -0.9, 0.35, 0.0]]))
    assert sector_image._stood_in(residual, view) == pytest.approx(np.array([[0.0, 0.2, 0.3, 0.4, 0.1]]))


def test_light_counts_where_pixels_are_summed():
    """Oracle: by hand; of two pixels, one of them summed, all that a row's sum is made of is that of the one."""
    seen = SimpleNamespace(
        plate=0.1, over_ring=np.array([[0.2, 0.3]]), ring=np.array([[0.7, 0.8]]), model=np.ones((1, 2)),
        residual=np.array([[0.04, 0.05]]), light=np.array([[0.9, 0.2]]), centre_angle_rad=np.array([[1.0, 2.0]]),
        light_angle_rad=np.array([[3.0, 4.0]]), ring_angle_rad=np.array([[5.0, 6.0]]),
    )  # fmt: skip
    view = SimpleNamespace(summed=np.array([[True, False]]), shape=lambda numbers: numbers, stand_ins=())
    found = sector_fit._light(seen, {}, view=view)
    expected = {"ring": [0.2, 0.0], "swept": [0.7, 0.0], "borrowed": [0.0, 0.0], "excess": [0.04, 0.0]}
    assert {name: found[name][0].tolist() for name in expected} == expected
    assert found["excess_angle_rad"].tolist() == [[3.0, 2.0]]
    assert found["ring_angle_rad"].tolist() == [[5.0, 6.0]]


def test_the_ring_is_looked_for_beside_the_opening_and_no_farther_in_than_the_axle():
    """Oracle: by hand; of the margins 4, 6 and 9 px, 6 lies next to 6.6, and 8.3 less 9 px or more is at the axle."""
    numbers = {"outer_radius_px": 30.0, "inner_radius_px": 8.3, "ring_outer_px": 31.5, "ring_inner_px": 6.8}
    off = {"ring_outer_px": 36.6, "ring_inner_px": 0.1}
    images = SimpleNamespace(
        sharp=lambda _: None, residuals=lambda at, _: np.array([at[name] - place for name, place in off.items()])
    )
    assert sector_fit._ring_tried(images, numbers) == numbers | {"ring_outer_px": 36.0, "ring_inner_px": 0.0}
