"""Contrast of each pixel and outline of the opening: a rolling camera by brute force, its noise and its plate known."""

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.reduce.opening import wheel_contrast
from irtiming.reduce.opening.sample_frames import SampleFrames
from irtiming.reduce.opening.wheel_contrast import noise_between_neighbours, outline

TURN = 2 * np.pi


def _sample(frames, angles):
    raw = np.rint(frames).astype(np.uint16)
    common = np.median(
        np.concatenate([raw[:, :2].reshape(len(raw), -1), raw[:, -2:].reshape(len(raw), -1)], axis=1), axis=1
    )
    return SampleFrames(
        raw=raw, values=raw, wheel_angle_rad=angles, place=np.linspace(0, 1, len(raw)), common_dn=common.astype(float)
    )


@pytest.fixture(scope="module")
def looked_at(turning, trigger_angles):
    """Every fourth of the noise-free frames, and the angles."""
    return turning[::4], trigger_angles(1000)[::4]


@pytest.mark.parametrize("sigma", [0.3, 4.0])
def test_noise_between_neighbours_is_the_standard_deviation(sigma):
    """Oracle: white noise that was drawn, on a slope that three pixels in a line do not see, with a few odd pixels."""
    random = np.random.default_rng(1)
    noise = random.normal(0, sigma, (60, 80)) + 1j * random.normal(0, sigma, (60, 80))
    rows, columns = np.mgrid[:60, :80]
    image = noise + (3 + 1j) * rows - 2j * columns
    image[10, 10] += 1e4
    assert noise_between_neighbours(image, np.ones((60, 80), bool)) == pytest.approx(sigma, rel=0.04)


def test_noise_that_rows_have_in_common_counts():
    """Oracle: the larger direction; white noise of 1, and 2 that all pixels of a row share: sqrt(5) from row to row."""
    random = np.random.default_rng(2)
    image = random.normal(0, 1, (300, 40)) + 1j * random.normal(0, 1, (300, 40))
    image += 2 * (random.normal(0, 1, (300, 1)) + 1j * random.normal(0, 1, (300, 1)))
    for picture in (image, image.T):
        found = noise_between_neighbours(picture, np.ones(picture.shape, bool))
        assert found == pytest.approx(np.sqrt(5), rel=0.08)


@pytest.mark.parametrize(("n", "known"), [(49, False), (50, True)])
def test_fewer_than_fifty_threes_tell_no_noise(n, known):
    """Oracle: the limit in the module; an area of three rows has one three in each of its columns."""
    image = np.random.default_rng(3).normal(size=(20, 80)) + 0j
    area = np.zeros(image.shape, bool)
    area[5:8, 7 : 7 + n] = True
    assert np.isfinite(noise_between_neighbours(image, area)) == known
    assert np.isfinite(noise_between_neighbours(image.T, area.T)) == known


def test_outline_is_the_opening_and_its_swing_that_of_the_wave(looked_at, paper_bolometer):
    """Oracle: half of each pixel's share of the opening; the wave of two cutouts, 2 / pi of the contrast, lowered by the lag."""
    frames, angles = looked_at
    camera = paper_bolometer()
    noisy = frames + np.random.default_rng(4).normal(0, 5, frames.shape)
    found = outline(_sample(noisy, angles), np.ones(len(frames), bool), threshold_level=0.5, name="a")
    share = camera.opening()
    assert np.sum(found.mask ^ (share > 0.5)) <= 6
    clear = np.abs(share - 0.5) > 0.3
    np.testing.assert_array_equal(found.mask[clear], (share > 0.5)[clear])
    lag = 1 / np.sqrt(1 + (2 * TURN * camera.rate_hz * camera.time_constant_s) ** 2)
    assert found.interior_dn == pytest.approx(950 * 2 / np.pi * lag, rel=0.01)
    clean = outline(_sample(frames, angles), np.ones(len(frames), bool), threshold_level=0.5, name="a")
    noise = np.std((found.harmonic - clean.harmonic).real)
    assert noise_between_neighbours(found.harmonic, share < 1e-6) == pytest.approx(noise, rel=0.1)
    assert (
        noise < found.noise_dn < 1.35 * noise
    )  # the opening fills a third of this image and has its border there, too
    inner, outer = share > 0.999, share < 1e-6
    np.testing.assert_allclose(found.contrast[inner], 1, atol=8 * found.noise_dn / found.interior_dn)
    assert np.abs(np.median(found.contrast[outer])) < 0.01
    assert 2 <= found.border_px <= 5


def test_frames_that_are_not_good_do_not_count(looked_at):
    """Oracle: the same without them; a third of the frames show something else."""
    frames, angles = looked_at
    good = np.arange(len(frames)) % 3 > 0
    spoilt = frames.copy()
    spoilt[~good] = spoilt[~good][::-1] + 300 * np.random.default_rng(5).random(spoilt[~good].shape)
    one = outline(_sample(spoilt, angles), good, threshold_level=0.5, name="a")
    other = outline(_sample(frames[good], angles[good]), np.ones(good.sum(), bool), threshold_level=0.5, name="a")
    np.testing.assert_array_equal(one.mask, other.mask)
    np.testing.assert_allclose(one.harmonic, other.harmonic, atol=1e-6)


@pytest.mark.parametrize("threshold", [0.3, 0.7])
def test_the_threshold_is_the_share_of_the_contrast(looked_at, paper_bolometer, threshold):
    """Oracle: a higher threshold leaves fewer pixels; those far on either side of it are out or in."""
    frames, angles = looked_at
    found = outline(_sample(frames, angles), np.ones(len(frames), bool), threshold_level=threshold, name="a")
    share = paper_bolometer().opening()
    assert not np.any(found.mask[share < 0.5 * threshold])
    assert np.all(found.mask[share > (1 + threshold) / 2 + 0.1])
    half = outline(_sample(frames, angles), np.ones(len(frames), bool), threshold_level=0.5, name="a")
    assert (found.mask.sum() < half.mask.sum()) == (threshold > 0.5)


def test_noise_alone_is_no_opening(looked_at):
    """Oracle: frames of noise, and the words."""
    _, angles = looked_at
    noise = 5000 + np.random.default_rng(6).normal(0, 5, (angles.size, 60, 80))
    with pytest.raises(
        ReductionError,
        match=r"a: no opening found: the liveliest pixels swing by .* at least .* the noise; check that the shutter",
    ):
        outline(_sample(noise, angles), np.ones(angles.size, bool), threshold_level=0.5, name="a")


def test_a_refusal_states_the_bound_that_is_not_met():
    """Oracle: by hand; three by three pixels swing by 300 DN, far more than noise, but are fewer than 30."""
    angles = np.linspace(0, 40, 240)
    frames = 5000 + np.random.default_rng(6).normal(0, 1, (angles.size, 60, 80))
    frames[:, 20:23, 30:33] += 300 * np.cos(2 * angles)[:, None, None]
    with pytest.raises(
        ReductionError, match=r"no opening found: \d+ pixels side by side swing with the wheel, at least 30 must;"
    ):
        outline(_sample(frames, angles), np.ones(angles.size, bool), threshold_level=0.5, name="a")


def test_an_image_that_is_turned_upside_down_has_its_outline_turned(looked_at):
    """Oracle: the symmetry, but for pixels as near to one pixel of the opening as to another."""
    frames, angles = looked_at
    good = np.ones(len(frames), bool)
    upright = outline(_sample(frames, angles), good, threshold_level=0.5, name="a")
    turned = outline(_sample(frames[:, ::-1, ::-1], angles), good, threshold_level=0.5, name="a")
    np.testing.assert_array_equal(turned.mask, upright.mask[::-1, ::-1])
    np.testing.assert_allclose(turned.contrast, upright.contrast[::-1, ::-1], atol=0.01)


def test_a_plate_that_follows_the_wheel_is_the_zero_of_the_contrast():
    """Oracle: by hand; the opening swings by 1000 DN and the plate by 200, so that a pixel that stands still is at -1/4."""
    angles = np.linspace(0, 40, 240)
    swing = np.zeros((60, 80))
    swing[4:-4, 4:-4] = 200
    swing[20:40, 30:50] = 1000
    frames = 5000 + swing * np.cos(2 * angles)[:, None, None]
    found = outline(_sample(frames, angles), np.ones(angles.size, bool), threshold_level=0.5, name="a")
    np.testing.assert_allclose(found.contrast[20:40, 30:50], 1, atol=2e-3)
    np.testing.assert_allclose(found.contrast[8:16, 30:50], 0, atol=2e-3)
    np.testing.assert_allclose(found.contrast[:4, 30:50], -0.25, atol=2e-3)


@pytest.mark.parametrize(("side", "is_deep"), [(40, True), (3, False)])
def test_contrast_is_over_that_of_the_pixels_inside_the_opening(side, is_deep):
    """Oracle: by hand; 8 DN inside and 2 DN on the border, which counts where fewer than 30 pixels lie inside."""
    seeds = np.zeros((60, 60), bool)
    seeds[5 : 5 + side, 5 : 5 + side] = True
    inside = np.zeros_like(seeds)
    inside[6 : 4 + side, 6 : 4 + side] = True
    harmonic = np.exp(0.4j) * np.where(inside, 8.0, np.where(seeds, 2.0, 0.0))
    contrast, level = wheel_contrast._contrast(harmonic, seeds)
    assert level == pytest.approx(8.0 if is_deep else 2.0)
    assert contrast[6, 6] == pytest.approx(8.0 / level)
