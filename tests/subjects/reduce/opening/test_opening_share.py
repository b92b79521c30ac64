"""Share of each pixel in the opening, against images made of known shares."""

import numpy as np
import pytest
from scipy import ndimage

from irtiming.reduce.opening import opening_share

ROWS, COLUMNS = 60, 90


def _image(*, mirroring, field=0.05, plate=0.02, noise=0.0, seed=5):
    """Contrast and true shares of a blurred box, with the wheel's mirror image on one end of it; pixels inside and beside."""
    row, column = np.mgrid[:ROWS, :COLUMNS]
    box = ((abs(row - 30) < 18) & (abs(column - 45) < 25)).astype(float)
    share = ndimage.gaussian_filter(box, 0.8)
    mirrored = field * np.exp(-0.5 * ((row - 44) ** 2 + (column - 64) ** 2) / 14.0**2)
    contrast = share * (1 + plate + mirrored) + (1 - share) * (plate + (1 - mirroring) * mirrored)
    contrast = contrast + np.random.default_rng(seed).normal(0, noise, contrast.shape)
    inside = ndimage.binary_erosion(box > 0, iterations=4)
    beside = ndimage.binary_dilation(box > 0, iterations=9) & ~ndimage.binary_dilation(box > 0, iterations=4)
    return contrast / np.median(contrast[inside]), share, inside, beside


@pytest.mark.parametrize("mirroring", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("plate", [-0.03, 0.02])
def test_shares_are_those_of_the_image(mirroring, plate):
    """Oracle: the shares that made the image; without the field they are off by 3 % at one end, with the plate by 2 % outside."""
    contrast, share, inside, beside = _image(mirroring=mirroring, plate=plate)
    near = ndimage.binary_dilation(inside, iterations=8)
    found, _ = opening_share.of_pixels(contrast, inside=inside, beside=beside)
    assert np.max(np.abs(found - share)[near]) < 2e-3
    assert np.max(np.abs(contrast - share)[near]) > 0.02


@pytest.mark.parametrize("mirroring", [0.0, 0.4, 0.9])
def test_doubt_about_the_plate_covers_its_error(mirroring):
    """Oracle: the shares that made the image; at the border they err by noise and by no more than four times the doubt."""
    contrast, share, inside, beside = _image(mirroring=mirroring, noise=2e-3)
    quiet, *_ = _image(mirroring=mirroring)
    found, doubt = opening_share.of_pixels(contrast, inside=inside, beside=beside)
    border = ~inside & ~beside & ndimage.binary_dilation(inside, iterations=6)
    bias = ndimage.uniform_filter(found - share - (contrast - quiet), 7)[border]
    assert 1e-5 < np.max(np.abs(doubt[border])) < 2e-2
    assert np.max(np.abs(bias)) < 4 * np.max(np.abs(doubt[border])) + 5e-4


def test_pulls_of_the_plates_part_are_standard():
    """Oracle: 120 draws of the noise; errors of the shares on the border, in units of the doubt there, spread by 1."""
    quiet, _, inside, beside = _image(mirroring=0.4)
    border = ~inside & ~beside & ndimage.binary_dilation(inside, iterations=6)
    clean, _ = opening_share.of_pixels(quiet, inside=inside, beside=beside)
    pulls = []
    for seed in range(120):
        contrast, *_ = _image(mirroring=0.4, noise=2e-3, seed=seed)
        found, doubt = opening_share.of_pixels(contrast, inside=inside, beside=beside)
        moved = (found - clean - (contrast - quiet))[border]
        pulls.append(moved @ doubt[border] / (doubt[border] @ doubt[border]))
    assert np.std(pulls) == pytest.approx(1, abs=0.15)


def test_an_even_wheel_leaves_only_the_plate():
    """Oracle: a straight line through two levels, plate and opening; no field to be found, and no doubt from it."""
    contrast, _, inside, beside = _image(mirroring=0.0, field=0.0, plate=0.1)
    found, doubt = opening_share.of_pixels(contrast, inside=inside, beside=beside)
    level = contrast[beside].mean()
    assert found == pytest.approx((contrast - level) / (contrast[inside].mean() - level), abs=3e-4)
    assert np.max(np.abs(doubt)) < 1e-4


def test_no_pixel_beside_the_opening():
    """Oracle: the contrast itself, which is all that is known of the shares; a region of interest without a margin."""
    contrast, _, inside, beside = _image(mirroring=0.0, field=0.0, plate=0.0)
    found, _ = opening_share.of_pixels(contrast, inside=inside, beside=np.zeros_like(beside))
    assert found[inside] == pytest.approx(1.0, abs=0.02)


def test_a_screw_beside_the_opening_and_a_bad_pixel_in_it_do_not_bend_the_shares():
    """Oracle: the shares of the same image without them; the screw swings by 30 % of the contrast, the pixel 20 % too little."""
    contrast, share, inside, beside = _image(mirroring=0.0, noise=1e-3)
    clean, _ = opening_share.of_pixels(contrast, inside=inside, beside=beside)
    spoilt = contrast.copy()
    spoilt[48:52, 72:76] += 0.3
    spoilt[25, 40] -= 0.2
    found, _ = opening_share.of_pixels(spoilt, inside=inside, beside=beside)
    border = ~inside & ~beside & ndimage.binary_dilation(inside, iterations=6)
    assert beside[48:52, 72:76].sum() > 2
    assert np.max(np.abs(found - clean)[border]) < 2e-3
    assert np.max(np.abs(found - share)[border]) < 8e-3
