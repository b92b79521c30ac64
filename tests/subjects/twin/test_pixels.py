"""Light on the twin's pixels: rays counted one by one, areas and angles computed by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtr

from irtiming.twin.pixels import Picture, expose, picture
from irtiming.twin.rays import trace
from irtiming.twin.scene import ChopperWheel, Scene
from irtiming.twin.spread import pixel_spread


def _frame(shot: Picture, *angles: float) -> np.ndarray:
    out = np.empty_like(shot.closed_dn)
    expose(shot, np.array(angles), out=out)
    return out.astype(float)


def _light(shot: Picture, *angles: float) -> float:
    """Sum of what the blackbody adds, in pixels fully lit."""
    return float((_frame(shot, *angles) - shot.closed_dn).sum() / shot.opening_dn[0])


def _open_share(scene: Scene, theta: float) -> float:
    """Share of an ideal opening that lies over a cutout: overlap of intervals of phi, by hand."""
    mask, beta = scene.mask, math.atan(scene.beams.half_separation_m / scene.beams.height_m)
    centre = mask.centre_angle_rad if scene.wheel.rotation == "clockwise" else math.pi - mask.centre_angle_rad
    low, high = centre - mask.opening_angle_rad / 2, centre + mask.opening_angle_rad / 2
    a0, a1, a2, a3 = scene.wheel.cutout_edges_rad
    overlap = 0.0
    for begin, end in ((a1, a2), (a3, a0 + 2 * math.pi)):
        for turns in range(-3, 4):
            top = math.pi / 2 + beta + theta - begin + 2 * math.pi * turns
            bottom = math.pi / 2 + beta + theta - end + 2 * math.pi * turns
            overlap += max(0.0, min(high, top) - max(low, bottom))
    return overlap / mask.opening_angle_rad


@pytest.mark.parametrize("rotation", ["clockwise", "counterclockwise"])
def test_open_share_is_that_of_an_ideal_opening(small_scene: Scene, rotation: str) -> None:
    """Oracle: overlap of angle intervals, by hand; the same for blur, which only moves light."""
    scene = replace(
        small_scene,
        wheel=replace(small_scene.wheel, rotation=rotation),
        mask=replace(small_scene.mask, centre_angle_rad=math.radians(-80)),
        optics=replace(small_scene.optics, blur_px=1.2),
    )
    shot = picture(scene)
    area = scene.mask.opening_angle_rad / 2 * (39.5e-3**2 - 15e-3**2) / scene.optics.pixel_pitch_m**2
    for theta in np.linspace(-1, 13, 60):
        assert _light(shot, theta) / area == pytest.approx(_open_share(scene, theta), abs=4e-4)


def test_area_of_the_opening(small_scene: Scene) -> None:
    """Oracle: area of an annular sector, gamma / 2 (r2^2 - r1^2)."""
    shot = picture(small_scene)
    lit = max(_light(shot, theta) for theta in np.linspace(0, 2 * math.pi, 50))
    area = math.radians(75) / 2 * (39.5**2 - 15**2) / 1.6**2
    assert lit == pytest.approx(area, rel=5e-4)


def test_blur_moves_light_and_keeps_its_sum(small_scene: Scene) -> None:
    """Oracle: conservation: light that leaves one pixel is in another."""
    sharp = picture(replace(small_scene, optics=replace(small_scene.optics, blur_px=0.0)))
    soft = picture(replace(small_scene, optics=replace(small_scene.optics, blur_px=1.5)))
    for theta in (0.3, 1.3, 2.9, 4.0):
        assert _light(soft, theta) == pytest.approx(_light(sharp, theta), rel=5e-4, abs=0.2)
        assert np.abs(_frame(soft, theta) - _frame(sharp, theta)).max() > 500


@pytest.mark.parametrize(
    ("blurs_px", "blur_turn_rad"),
    [((0.7, 0.7), 0.0), ((0.7, 0.5), 0.0), ((0.0, 0.0), 0.0), ((0.9, 0.5), 0.6), ((0.5, 0.9), -1.2)],
)
@pytest.mark.parametrize(("n", "error"), [(110, 0.04), (1024, 0.01), (7000, 2.5e-3)])
def test_an_edge_anywhere_in_a_pixel_covers_what_it_should(
    n: int, error: float, blurs_px: tuple[float, float], blur_turn_rad: float
) -> None:
    """Oracle: the integral of a square pixel convolved with a Gaussian, over the light side of an edge in any direction.

    Along an axis the integral is one of normal distributions; at 45 degrees it is taken by brute force over 400 x 400 places.
    Places of a blur that is turned fill a cube, not a square, and are so much less even.
    """
    place = pixel_spread(n, blurs_px, turn_rad=blur_turn_rad, variants=4).astype(float)
    slope, level = math.sin(blur_turn_rad), math.cos(blur_turn_rad)
    fine = (np.arange(400) + 0.5) / 400 - 0.5
    for turn in (0.0, math.pi / 4, math.pi / 2, 3 * math.pi / 4):
        down, right = math.sin(turn), math.cos(turn)
        across = np.sort((down * fine[:, None] + right * fine).ravel())
        by_row, by_column = down * level - right * slope, down * slope + right * level
        blur_px = math.hypot(by_row * blurs_px[0], by_column * blurs_px[1])
        for depth in np.linspace(-1.5, 1.5, 13) + 0.013:
            inside = across[::7]
            expected = np.mean(ndtr((depth - inside) / blur_px)) if blur_px > 0 else np.mean(inside < depth)
            covered = np.mean(place @ [down, right] < depth, axis=1)
            assert covered == pytest.approx(expected, abs=error if blur_turn_rad == 0 else 1.6 * error)


def test_fast_count_equals_a_count_ray_by_ray(small_scene: Scene) -> None:
    """Oracle: every ray of every pixel asked by itself whether it lies in a cutout."""
    shot = picture(replace(small_scene, radiance=replace(small_scene.radiance, mask_k=297.0)))
    table = shot.table
    kept = np.diff(table.first_ray)
    pixel = np.repeat(np.arange(kept.size), kept)
    is_opening = np.arange(pixel.size) - table.first_ray[pixel] < table.n_opening[pixel]
    gain = np.where(is_opening, shot.opening_dn[pixel], shot.plate_dn[pixel]) / table.n_ray[pixel]
    phi = table.reference_rad[pixel] + table.offset_rad.astype(float)
    a0, a1, a2, a3 = small_scene.wheel.cutout_edges_rad
    for angles in ([0.2, 0.204], [1.7, 1.9, 2.1], [6.28, 6.281], [-40.0, -39.9999], [0.0, 0.8, 1.6, 2.4]):
        expected = shot.closed_dn.astype(float).copy().ravel()
        for theta in angles:
            seen = np.mod(shot.gate_rad + theta - phi, 2 * math.pi)
            is_open = ((seen >= a1) & (seen < a2)) | (seen >= a3) | (seen < a0)
            expected[table.pixel] += np.bincount(pixel, gain * is_open) / len(angles)
        assert _frame(shot, *angles).ravel() == pytest.approx(expected, abs=0.01)


def test_counterclockwise_is_the_mirror_image(small_scene: Scene) -> None:
    """Oracle: the picture reflected in the vertical through the axle, with the axle in the middle of the image."""
    optics = replace(small_scene.optics, wheel_centre_row_px=31.5, wheel_centre_column_px=39.5)
    mask = replace(small_scene.mask, centre_angle_rad=math.radians(-70), centre_x_m=3e-4)
    mirrored = replace(mask, centre_angle_rad=math.pi - mask.centre_angle_rad, centre_x_m=-3e-4)
    one = picture(replace(small_scene, optics=optics, mask=mask))
    wheel = replace(small_scene.wheel, rotation="counterclockwise")
    other = picture(replace(small_scene, optics=optics, mask=mirrored, wheel=wheel))
    for theta in (0.4, 1.1, 2.0):
        assert _light(one, theta) == pytest.approx(_light(other, theta), abs=0.1)
        difference = _frame(one, theta) - _frame(other, theta)[:, ::-1]
        assert np.abs(difference).mean() < 4


def test_light_moves_clockwise_as_the_wheel_turns(small_scene: Scene) -> None:
    """Oracle: by hand: while a cutout comes over the opening, light enters at its left end, at 9 o'clock's side."""
    shot = picture(small_scene)
    theta = np.linspace(0, 2 * math.pi, 400)
    light = np.array([_light(shot, t) for t in theta])
    opening = np.flatnonzero(np.diff(light) > 0.5)
    early = opening[np.argmin(np.abs(light[opening] / light.max() - 0.2))]
    columns = (_frame(shot, theta[early]) - shot.closed_dn).sum(axis=0)
    assert (columns * np.arange(80)).sum() / columns.sum() < small_scene.optics.wheel_centre_column_px - 3


@pytest.mark.parametrize(("roll", "distortion"), [(0.2, 0.0), (0.0, -0.05), (-0.1, 0.08)])
def test_mask_appears_where_roll_and_distortion_put_it(small_scene: Scene, roll: float, distortion: float) -> None:
    """Oracle: middle of the opening, mapped by hand: phi + roll, then r_d = r_u (1 + k r_u^2)."""
    optics = replace(
        small_scene.optics,
        roll_rad=roll,
        distortion=distortion,
        wheel_centre_row_px=31.5,
        wheel_centre_column_px=39.5,
    )
    mask = replace(small_scene.mask, inner_radius_m=27e-3, outer_radius_m=29e-3, opening_angle_rad=0.08)
    shot = picture(replace(small_scene, optics=optics, mask=mask))
    lit = max((_frame(shot, t) - shot.closed_dn for t in np.linspace(0, 3, 20)), key=np.sum)
    row = (lit.sum(axis=1) * np.arange(64)).sum() / lit.sum() - 31.5
    column = (lit.sum(axis=0) * np.arange(80)).sum() / lit.sum() - 39.5
    radius, half_diagonal = 28 / 1.6, math.hypot(64, 80) / 2
    radius *= 1 + distortion * (radius / half_diagonal) ** 2
    phi = -math.pi / 2 + roll
    assert (row, column) == pytest.approx((radius * math.sin(phi), radius * math.cos(phi)), abs=0.03)


def test_exposure_is_the_mean_over_the_window(small_scene: Scene) -> None:
    """Oracle: frames at single instants, averaged."""
    shot = picture(small_scene)
    angles = np.linspace(0.9, 0.95, 4)
    mean = np.mean([_frame(shot, t) for t in angles], axis=0)
    assert _frame(shot, *angles) == pytest.approx(mean, abs=0.01)


def test_narcissus_darkens_the_middle_and_solid_wheel_hides_the_plate(small_scene: Scene) -> None:
    """Oracle: by hand: 200 DN missing at the image centre, nothing missing far away."""
    radiance = replace(small_scene.radiance, narcissus_dn=200.0)
    shot = picture(replace(small_scene, radiance=radiance))
    level = radiance.level_dn(radiance.wheel_k)
    assert shot.closed_dn[31, 39] == pytest.approx(level - 200, abs=6)
    assert shot.closed_dn[0, 0] == pytest.approx(level, abs=0.1)


def test_no_ray_beyond_the_ring_ever_changes(small_scene: Scene) -> None:
    """Oracle: by hand: hub and rim have no live pixel beyond the ring's blurred border."""
    wheel = ChopperWheel(inner_radius_m=20e-3, outer_radius_m=30e-3)
    table = trace(replace(small_scene, wheel=wheel, optics=replace(small_scene.optics, blur_px=0.0)))
    row, column = np.divmod(table.pixel, 80)
    radius = np.hypot(row - 31.2, column - 40.1) * 1.6e-3
    assert radius.min() > 20e-3 - 1.6e-3
    assert radius.max() < 30e-3 + 1.6e-3
