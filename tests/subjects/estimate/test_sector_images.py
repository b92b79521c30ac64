"""What is known of the contrast images of a sector: uncertainties of pixels, and what levels that are not known do to them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import sector_images
from irtiming.physics.light.row_sum import EDGE_DELAYS
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.reduced import FoundInSums

NOISE_DN = 6.0


@pytest.fixture(scope="module")
def camera(brute_bolometer):
    return brute_bolometer(offset=(0.35, -0.25))


@pytest.fixture(scope="module")
def rows(camera, brute_rows):
    return brute_rows(camera, noise_dn=NOISE_DN, seed=3)


def test_a_pixel_is_as_uncertain_as_its_noise_and_gain_along_its_phase_and_its_noise_across(
    camera, rows, rig_with, sector_of
):
    """Oracle: by hand; 6 DN in 400 frames. At first gains are 2 % apart, then 3 % in the light; an odd pixel says nothing."""
    light, odd = np.zeros((camera.rows, camera.columns)), np.zeros((camera.rows, camera.columns), bool)
    light[10:20], odd[25, 7] = 1.0, True
    known = sector_of(camera, model_contrast=light, gain_scatter=0.03, odd=odd)
    first, later = (
        sector_images.of([rows], camera.model, rig=rig_with(), timing=camera.timing, known=one) for one in (None, known)
    )
    noise_dn, full_dn = NOISE_DN * (2 / 400) ** 0.5, first.seen[0].full_dn
    assert first.u_dn[0][15, 30] == pytest.approx(np.hypot(noise_dn, 0.02 * full_dn) + 1j * noise_dn)
    assert later.u_dn[0][15, 30] == pytest.approx(np.hypot(noise_dn, 0.03 * full_dn) + 1j * noise_dn, rel=1e-3)
    assert later.u_dn[0][25, 7] == pytest.approx(np.hypot(noise_dn, full_dn) * (1 + 1j))


def test_a_small_opening_in_a_wide_region_shows_what_its_pixels_do(camera, rows, rig_with):
    """Oracle: by hand; 250 DN and 3 % of scatter in a twentieth of the pixels, 1 DN in all others, two of them stuck."""
    random, size = np.random.default_rng(4), np.ones((camera.rows, camera.columns))
    opening = np.zeros(size.shape, bool)
    opening[10 : 10 + camera.rows // 4, 5 : 5 + camera.columns // 5] = True
    size[opening] = 250 * random.normal(1, 0.03, opening.sum())
    size[0, :2] = 4000
    small = replace(rows, contrast=replace(rows.contrast, projection_dn=size + 0j))
    (look,) = sector_images.of([small], camera.model, rig=rig_with(), timing=camera.timing, known=None).seen
    assert look.full_dn == pytest.approx(250, rel=0.01)


def test_a_delay_that_is_not_right_yet_turns_each_image_by_its_own_angle(camera, rows, brute_rows, rig_with, sector_of):
    """Oracle: 1 ms at 3 and at 7 turns a second; what the fit before took for the turn is of no matter."""
    other = brute_rows(replace(camera, rate_hz=7.0), noise_dn=NOISE_DN, seed=7)
    later = {name: camera.timing[name] + 1e-3 * (name in EDGE_DELAYS) for name in camera.timing}
    known = sector_of(camera, turn_rad=0.1, row_delay_s=camera.row_delay_s)
    images = sector_images.of([rows, other], camera.model, rig=rig_with(), timing=later, known=known)
    assert images.begin["turn_rad"] == pytest.approx(-2 * np.pi * 3.0 * 1e-3, abs=1e-3)
    assert images.begin["turn_1_rad"] == pytest.approx(-2 * np.pi * 7.0 * 1e-3, abs=1e-3)


def test_what_an_unknown_gain_does_to_the_image_turns_with_it(camera, rows, rig_with, sector_of):
    """Oracle: points in the time domain, one for each pixel in the light, seen with another gain; an image turned by 0.2 rad."""
    turn_rad, wave = 0.2, np.cos(4 * camera.omega * 0.033 * np.arange(400) + 1.0)
    late_rad = camera.omega * np.array([camera.timing[name] for name in EDGE_DELAYS])
    told = FoundInSums(
        edges_late_rad=late_rad, blade_share=0.0, relative_gain=np.ones(400), u_gain=0.02 * wave[:, None],
        u_offset=np.zeros((400, 1)),
    )  # fmt: skip
    lit = np.argwhere(camera.light[1].sum(axis=0) > 0.99)[::20]
    light = np.zeros((camera.rows, camera.columns))
    light[tuple(lit.T)] = 1.0
    projection_dn = rows.contrast.projection_dn * np.exp(2j * turn_rad)
    (look,) = sector_images.of(
        [replace(rows, contrast=replace(rows.contrast, in_sums=told, projection_dn=projection_dn))], camera.model,
        rig=rig_with(), timing=camera.timing,
        known=sector_of(camera, model_contrast=light, row_delay_s=camera.row_delay_s),
    ).seen  # fmt: skip
    theta = wheel_angle_rad(0.0, rows.track, at_ticks=rows.trigger_ticks) + camera.gate_rad - camera.centre_rad
    expected = np.zeros(light.shape, complex)
    for row, column in lit:
        angle = np.arctan2(row - camera.axle[0], column - camera.axle[1]) - camera.bisector_rad
        seen = camera.seen(theta - angle + turn_rad + camera.omega * row * camera.row_delay_s)
        expected[row, column] = rows.contrast.frame_weight @ (0.02 * wave * (seen - 0.5))
    (found,) = look.swayed
    np.testing.assert_allclose(found, expected, atol=0.02 * np.abs(expected).max())


def test_where_light_ends_within_a_pixel_its_phase_is_uncertain_as_the_blurs_shape_is(camera, sector_of):
    """Oracle: by hand; twice the polar angle of a fifth of the width of blur and pixel, by the root of the light's slope."""
    light = np.clip(0.25 * (np.arange(camera.columns) - 20.0), 0, 1) * np.ones((camera.rows, 1))
    found = sector_images._imperfect(sector_of(camera, model_contrast=light))
    wide_px = np.hypot(camera.shape.blur_px, 12**-0.5)
    away_px = np.hypot(15 - camera.shape.axle_row_px, 22 - camera.shape.axle_column_px)
    border = (0.25 * np.sqrt(2 * np.pi) * wide_px) ** 0.5
    assert found[15, 22].imag == pytest.approx(2 * 0.2 * border * wide_px / away_px, rel=1e-3)
    assert found[15, 22].real == 0


def test_the_edges_way_is_asked_for_by_the_bright_pixels_and_to_a_pixel_of_the_longer_side(monkeypatch):
    """Oracle: by hand; of 2 x 5 pixels those of less than half of the brightest are dark, and a fifth is the least."""
    asked = {}

    def contradiction(in_light, rig, *, least_turn_rad):
        asked.update(in_light=in_light, rig=rig, least_turn_rad=least_turn_rad)
        return "word"

    monkeypatch.setattr(sector_images.edge_motion, "contradiction", contradiction)
    projection = np.array([[10j, 9.0, 1.0, 0.0, 10.0], [4.0, -6.0, 0.0, 10.0, 3j]])
    images = SimpleNamespace(seen=[SimpleNamespace(projection=projection)], rig="rig")
    assert sector_images.Images.sense(images) == "word"
    np.testing.assert_array_equal(asked["in_light"], [[10j, 9.0, 0.0, 0.0, 10.0], [0.0, -6.0, 0.0, 10.0, 0.0]])
    assert (asked["rig"], asked["least_turn_rad"]) == ("rig", pytest.approx(0.2))
