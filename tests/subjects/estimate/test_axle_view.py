"""Where the summed light of the opening lies in the image, beside a mask plate that shows too."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import plate_light, shape
from irtiming.estimate.row_light import SHAPE_NUMBERS
from irtiming.physics import blurred_sector, sector_points
from irtiming.records.blur import Blur
from irtiming.records.row_timing import SectorShape
from irtiming.reduce.opening import dead_pixels

SHAPE = SectorShape(
    axle_row_px=31.2, axle_column_px=38.6, offset_row_px=0.0, offset_column_px=0.0, inner_radius_px=8.0,
    outer_radius_px=20.5, bisector_rad=float(np.radians(-91)), opening_angle_rad=1.309, blur_px=0.7,
    image_rows=60, image_columns=80,
)  # fmt: skip
ROI = (4, 34, 15, 65)
PLATE = 0.05
BEYOND_RAD = (0.35, 0.70)
"""By how much the summed region reaches beyond the opening: as far as blur carries light at one end, twice that at the other."""


def _image(shape_drawn):
    points = sector_points.light_points(shape_drawn)
    return blurred_sector.image(points, np.ones(points.row_px.size, complex), blur=Blur(0.7, 0.7), roi=ROI).real


def _seen(*, plate, mirrored, uneven=0.0):
    """Sector that shows its light, a plate all around it and a wheel uneven at one end, in a lopsided region of summed pixels."""
    drawn = replace(SHAPE, mirrored=mirrored)
    light = _image(drawn)
    angle, radius = blurred_sector.pixel_places(drawn, roi=ROI)
    half = drawn.opening_angle_rad / 2
    region = (angle > -half - BEYOND_RAD[0]) & (angle < half + BEYOND_RAD[1]) & (radius > 4) & (radius < 24)
    summed = np.zeros((60, 80), bool)
    summed[ROI[0] : ROI[1], ROI[2] : ROI[3]] = region
    swept = np.where((radius > 7) & (radius < 21.5) & region, 1.0, 0.0)
    ring = swept * np.where(angle > half, plate + uneven, plate)
    n = len(SHAPE_NUMBERS)
    sector = SimpleNamespace(
        shape=drawn, names=SHAPE_NUMBERS, covariance=np.zeros((n, n)), contrast=(1 - plate) * light + ring,
        model_contrast=light, plate=plate, swept=swept, ring=ring, ring_angle_rad=angle, roi=ROI, u=lambda name: 0.0,
        value=lambda name: getattr(drawn, name), excess=np.zeros_like(light), gain_scatter=0.0, borrowed_angle_rad=angle,
    )  # fmt: skip
    return sector, summed, angle


def _turn(view, mirrored):
    return (view.mean_angle_rad - view.bisector_rad) * (-1 if mirrored else 1)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("plate", [0.0, PLATE])
def test_plate_turns_no_light(plate, mirrored):
    """Oracle: symmetry; the opening about the axle has its light about the bisector, whatever shows beside one of its ends."""
    sector, summed, _ = _seen(plate=plate, mirrored=mirrored)
    assert abs(_turn(shape.view(sector, summed), mirrored)) < 2e-4


@pytest.mark.parametrize("mirrored", [False, True])
def test_light_plate_and_uneven_wheel_make_up_the_sum(mirrored):
    """Oracle: pixels added up one by one; the first moments of opening, plate and uneven wheel are those of their sum."""
    sector, summed, angle = _seen(plate=PLATE, mirrored=mirrored, uneven=0.03)
    view, sense = shape.view(sector, summed), -1 if mirrored else 1
    beside = sector.ring.sum()
    opening = np.where(summed[ROI[0] : ROI[1], ROI[2] : ROI[3]], sector.contrast, 0.0)
    turns = sense * (view.mean_angle_rad - view.bisector_rad)
    angles = turns - np.convolve(
        view.beside_ends_rad, [0.5, 0.5], "valid"
    )  # wheel coordinates grow against polar angles
    shares = PLATE * np.array(view.plate_share) + np.array(view.uneven_share)
    found = (opening.sum() - beside) * turns + opening.sum() * float(shares @ angles)
    assert float(np.sum(shares)) == pytest.approx(beside / opening.sum(), rel=1e-3)
    assert beside / opening.sum() > 0.03
    assert float(np.sum(view.uneven_share)) > 0.002
    assert found == pytest.approx(float(np.sum(opening * angle)), rel=0.02)
    assert found > 0.003 * opening.sum()


@pytest.mark.parametrize("mirrored", [False, True])
def test_stand_ins_show_their_own_light_for_that_of_dead_pixels(mirrored):
    """Oracle: images of the opening's part before an edge, their pixels added up with what each counts in the sum."""
    sector, summed, _ = _seen(plate=0.0, mirrored=mirrored)
    sector.ring = 0.5 * sector.model_contrast  # as if a third of what shows were the wheel's
    bad = np.zeros(summed.shape, bool)
    bad[[16, 24, 22], [38, 30, 47]] = True
    weight = dead_pixels.weights(summed, bad)
    view = shape.view(sector, summed)
    more, drawn = (weight - summed)[ROI[0] : ROI[1], ROI[2] : ROI[3]], sector.shape
    sense, half = (-1 if mirrored else 1), drawn.opening_angle_rad / 2
    turned = sense * (view.mean_angle_rad - view.bisector_rad)
    ends, share = plate_light.of_single_pixels(sector, summed, weight=weight, shift_rad=turned)
    edges = np.linspace(-0.6, 0.6, 25)
    found = np.interp(edges, ends, np.append(0.0, np.cumsum(share)))
    for edge, got in zip(edges, found, strict=True):
        low = turned - edge  # polar angles fall as wheel coordinates grow
        part = replace(drawn, bisector_rad=drawn.bisector_rad + (low + half) / 2, opening_angle_rad=half - low)
        light = _image(part)
        assert got == pytest.approx(1.5 * float(np.sum(more * light) / sector.contrast.sum()), abs=1.5e-4)
    assert np.ptp(found) > 9e-4


def test_gains_that_differ_count_where_their_pixels_are():
    """Oracle: images of the opening's part before an edge, their pixels added up with gains that nothing smooth would explain."""
    sector, summed, angle = _seen(plate=0.0, mirrored=False)
    light, inside = sector.model_contrast, summed[ROI[0] : ROI[1], ROI[2] : ROI[3]]
    uneven = np.where(inside, light * np.random.default_rng(7).normal(0, 0.05, light.shape), 0.0)
    smooth = np.stack([angle**k for k in range(3)])
    normal = np.einsum("kij,lij,ij->kl", smooth, smooth, light)
    amounts = np.linalg.solve(normal, np.einsum("kij,ij->k", smooth, uneven))
    fine = uneven - light * np.tensordot(amounts, smooth, 1)
    sector.excess, sector.borrowed_angle_rad = fine + light * (0.02 + 0.03 * angle - 0.01 * angle**2), angle
    sector.gain_scatter = 10.0  # of which hardly any is noise
    ends, share = plate_light.of_single_pixels(sector, summed, weight=summed.astype(float), shift_rad=0.0)
    half, gains = sector.shape.opening_angle_rad / 2, fine / np.maximum(light, 1e-6)
    for edge in (-0.5, -0.3, -0.1, 0.1, 0.3, 0.5):
        part = replace(
            sector.shape, bisector_rad=sector.shape.bisector_rad + (half - edge) / 2, opening_angle_rad=half + edge
        )
        seen = _image(part)
        got = float(np.interp(edge, ends, np.append(0.0, np.cumsum(share))))
        assert got == pytest.approx(float(np.sum(gains * seen) / sector.contrast.sum()), abs=2e-4)
    assert np.max(np.abs(np.cumsum(share))) > 1e-3


def test_as_much_of_the_gains_counts_as_is_not_noise():
    """Oracle: by hand; half of the scatter is that of gains, so a quarter of its square."""
    sector, summed, angle = _seen(plate=0.0, mirrored=False)
    sector.excess = np.random.default_rng(7).normal(0, 0.05, angle.shape) * sector.model_contrast
    weight = summed.astype(float)
    rms = float(np.sqrt(np.mean(sector.excess[sector.model_contrast > 0.98] ** 2)))
    shares = []
    for sector.gain_scatter in (rms, rms / 2):
        ends, share = plate_light.of_single_pixels(sector, summed, weight=weight, shift_rad=0.0)
        shares.append(np.interp(np.linspace(-0.6, 0.6, 9), ends, np.append(0.0, np.cumsum(share))))
    assert shares[1] == pytest.approx(shares[0] / 4, abs=2e-6)
    assert np.ptp(shares[0]) > 1e-3


def test_what_a_pixel_shows_that_does_not_count_counts_nothing():
    """Oracle: by hand; what is fine adds up to nothing, so that what is left of it in all others is the light of that pixel."""
    sector, summed, angle = _seen(plate=0.0, mirrored=False)
    sector.excess, weight, at = np.zeros(angle.shape), summed.astype(float), (12, 23)
    sector.excess[at], sector.gain_scatter = -sector.model_contrast[at], 10.0
    weight[ROI[0] + at[0], ROI[2] + at[1]] = 0
    _, share = plate_light.of_single_pixels(sector, summed, weight=weight, shift_rad=0.0)
    light = sector.model_contrast[at] / sector.contrast.sum()
    assert light > 1e-3
    assert share.sum() == pytest.approx(0, abs=0.05 * light)


def test_what_is_all_noise_is_left_out():
    """Oracle: the scatter that is stated for gains, none."""
    sector, summed, angle = _seen(plate=0.0, mirrored=False)
    sector.excess = np.random.default_rng(7).normal(0, 0.01, angle.shape)
    sector.borrowed_angle_rad, sector.gain_scatter = angle, 0.0
    _, share = plate_light.of_single_pixels(sector, summed, weight=summed.astype(float), shift_rad=0.0)
    assert share.size == 0


def test_a_sum_without_dead_pixels_has_no_stand_ins():
    """Oracle: plain pixels, each counted once."""
    sector, summed, _ = _seen(plate=0.0, mirrored=False)
    _, share = plate_light.of_single_pixels(sector, summed, weight=summed.astype(float), shift_rad=0.0)
    assert share.size == 0


def test_an_image_without_a_plate_knows_where_a_plate_would_show():
    """Oracle: the same image without noise; a few noisy pixels are no plate, and what they add to the sum is as small as they."""
    sector, summed, _ = _seen(plate=0.0, mirrored=False)
    quiet = shape.view(sector, summed)
    sector.ring = sector.swept * np.random.default_rng(5).normal(0, 1e-4, sector.swept.shape)
    noisy = shape.view(sector, summed)
    assert noisy.plate_share == pytest.approx(quiet.plate_share, abs=1e-4)
    assert float(np.sum(quiet.plate_share)) > 1
    assert 0 < float(np.max(np.abs(noisy.uneven_share))) < 1e-5


def test_light_that_is_uneven_along_the_opening_makes_the_mask_less_certain():
    """Oracle: the stated share, 3 %, of the turn of the light's centre: a slope over the angle, pixels added up one by one."""
    sector, summed, angle = _seen(plate=0.0, mirrored=False)
    light = np.where(summed[ROI[0] : ROI[1], ROI[2] : ROI[3]], sector.model_contrast, 0.0)
    sector.contrast = sector.model_contrast * (1 + 0.3 * angle)
    mean, spread = np.average(angle, weights=light), np.average(angle**2, weights=light)
    turn = (mean + 0.3 * spread) / (1 + 0.3 * mean) - mean
    view = shape.view(sector, summed)
    assert turn > 0.03
    assert view.u_off_axle_rad == pytest.approx(0.03 * turn, rel=1e-3)
