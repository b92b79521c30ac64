"""The compiled loops against plain NumPy."""

import numpy as np
import pytest

from irtiming.reduce import kernels

SHAPES = [(7, 12, 16), (1, 1, 1), (3, 1, 17), (5, 13, 1), (0, 4, 5), (11, 31, 37)]


def _frames(shape, seed=0):
    return np.random.default_rng(seed).integers(0, 65536, shape, dtype=np.uint16)


def _views():
    """Frames as they come: whole, a region of interest, every other frame, columns turned, and fortran order."""
    whole = _frames((9, 21, 33))
    return [whole, whole[:, 3:18, 5:30], whole[::2], whole[:, :, ::-1], np.asfortranarray(whole)]


@pytest.mark.parametrize("frames", [*map(_frames, SHAPES), *_views()], ids=lambda f: str(f.shape))
def test_counts_above_a_threshold_per_pixel(frames):
    """Oracle: NumPy's comparison and sum, exactly; values equal to the threshold do not count."""
    thresholds = np.random.default_rng(1).integers(0, 65536, frames.shape[1:], dtype=np.uint16)
    if len(frames):
        thresholds[0] = frames[0, 0]
    assert kernels.count_above(frames, thresholds).tolist() == (frames > thresholds).sum(axis=(1, 2)).tolist()


@pytest.mark.parametrize("frames", [*map(_frames, SHAPES), *_views()], ids=lambda f: str(f.shape))
def test_weighted_sums(frames):
    """Oracle: NumPy in double precision; single precision within a row keeps 6 digits of it."""
    weights = np.random.default_rng(2).uniform(0, 2, frames.shape[1:]).astype(np.float32)
    expected = (frames * weights.astype(float)).sum(axis=(1, 2))
    np.testing.assert_allclose(kernels.weighted_sum(frames, weights), expected, rtol=1e-6)


def test_weighted_sum_of_a_large_frame_keeps_its_step():
    """Oracle: NumPy in double precision at 640 x 512; a millionth of the sum is a thousandth of a 2 DN step in 2000."""
    frames = _frames((2, 512, 640), 3) // 4
    weights = np.random.default_rng(4).normal(1, 0.1, (512, 640)).astype(np.float32)
    expected = (frames * weights.astype(float)).sum(axis=(1, 2))
    np.testing.assert_allclose(kernels.weighted_sum(frames, weights), expected, rtol=3e-8)


@pytest.mark.parametrize("full_scale", [16383, 65535])
@pytest.mark.parametrize("frames", [*map(_frames, SHAPES), *_views()], ids=lambda f: str(f.shape))
def test_pixels_at_the_limits(frames, full_scale):
    """Oracle: NumPy's comparison; zeros and full scale are put in by hand."""
    frames = frames % 500
    if min(frames.shape) > 3:
        frames[1, 2, :5], frames[2, 0, 3:] = 0, full_scale
    expected = [(frames == 0).sum(axis=(1, 2)).tolist(), (frames >= full_scale).sum(axis=(1, 2)).tolist()]
    assert kernels.count_at_limits(frames, full_scale).tolist() == expected
    some = frames[:, ::3]
    expected = [(some == 0).sum(axis=(1, 2)).tolist(), (some >= full_scale).sum(axis=(1, 2)).tolist()]
    assert kernels.count_at_limits(frames, full_scale, 3).tolist() == expected


def test_sums_within_take_the_taken_pixels_of_each_row():
    """Oracle: NumPy on whole numbers; full scale over 640 columns does not overflow."""
    frames, rng = _frames((5, 7, 640)), np.random.default_rng(8)
    frames[0] = 65535
    taken = rng.random((7, 640)) < 0.6
    bits = np.where(taken, 0xFFFF, 0).astype(np.uint16)
    wanted = (frames.astype(np.int64) * taken).sum(axis=2)
    assert np.array_equal(kernels.sum_within(frames, bits), wanted)
    assert np.array_equal(
        kernels.sum_within(frames[:, 2:5, 3:], bits[2:5, 3:]).sum(axis=1),
        (frames[:, 2:5, 3:].astype(np.int64) * taken[2:5, 3:]).sum(axis=(1, 2)),
    )


def test_repeated_frames_are_those_equal_to_the_last_bit():
    """Oracle: by hand; one bit of the last pixel makes a frame another one."""
    frames = _frames((6, 4, 5))
    frames[2] = frames[1]
    frames[4] = frames[3]
    frames[4, -1, -1] ^= 1
    assert kernels.repeats(frames, frames[0]).tolist() == [True, False, True, False, False, False]
    assert kernels.repeats(frames[:1], frames[5]).tolist() == [False]


def test_projections_add_up():
    """Oracle: the sums in NumPy, added to what is there."""
    frames, rng = _frames((9, 6, 11)), np.random.default_rng(9)
    cosine, sine = rng.normal(size=(2, 9))
    into = rng.normal(size=(3, 6, 11))
    wanted = into + np.stack([np.einsum("n,nij->ij", weight, frames) for weight in (cosine, sine, np.ones(9))])
    kernels.add_projection(frames, cosine, sine, into)
    np.testing.assert_allclose(into, wanted, rtol=1e-12)
