"""Quiet pixels, and the brightest and darkest frames, from an outline of the opening: by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.reduce.opening import in_contrast

SHAPE = (60, 60)


def _outline(moved_dn, *, interior_dn=1000.0, noise_dn=0.1):
    """Of an opening of 10 x 10 pixels in a corner; the others follow the wheel by so much."""
    mask = np.zeros(SHAPE, bool)
    mask[:10, :10] = True
    harmonic = np.where(mask, interior_dn, moved_dn) + 0j
    return SimpleNamespace(mask=mask, border_px=2, harmonic=harmonic, interior_dn=interior_dn, noise_dn=noise_dn)


@pytest.mark.parametrize(
    ("interior_dn", "noise_dn", "most_dn"), [(1000.0, 0.1, 2.0), (1000.0, 1.0, 3.5), (500.0, 0.1, 1.0)]
)
def test_pixels_are_quiet_that_move_by_less_than_a_share_of_the_opening_or_its_noise(interior_dn, noise_dn, most_dn):
    """Oracle: by hand; 0.2 % of the opening's contrast, or 3.5 times its noise where that is more."""
    moved = np.full(SHAPE, 100.0)
    moved[30:40], moved[40:] = 0.99 * most_dn, 1.01 * most_dn
    quiet = in_contrast._quiet(_outline(moved, interior_dn=interior_dn, noise_dn=noise_dn))
    assert np.flatnonzero(quiet.any(axis=1)).tolist() == list(range(30, 40))
    assert quiet[30:40].all()


def test_pixels_near_the_opening_are_never_quiet():
    """Oracle: by hand; three pixels beyond the border of two, in the rows beside it."""
    quiet = in_contrast._quiet(_outline(np.zeros(SHAPE)))
    assert np.flatnonzero(~quiet[5]).tolist() == list(range(10 + 5))
    assert quiet[20:].all()


def test_where_hardly_any_pixel_is_quiet_the_quietest_quarter_is():
    """Oracle: by hand; of pixels that move by their column's number a quarter lies in the first columns."""
    moved = np.broadcast_to(100.0 + np.arange(60.0), SHAPE)
    outline = _outline(moved)
    quiet = in_contrast._quiet(outline)
    away = np.ones(SHAPE, bool)
    away[:15, :15] = np.hypot(*np.mgrid[-9:6, -9:6].clip(0)) > 5
    assert quiet.sum() == pytest.approx(away.sum() / 4, rel=0.1)
    assert not quiet[:, 20:].any()


def test_no_pixel_is_quiet_where_the_opening_fills_the_image():
    """Oracle: by hand; the last row of sixty is away from it, of a hundred that must be."""
    outline = _outline(np.zeros(SHAPE))
    outline.mask[:54] = True
    assert not in_contrast._quiet(outline).any()


@pytest.mark.parametrize(("n_rows", "is_enough"), [(3, False), (4, True)])
def test_of_a_large_image_two_per_cent_must_be_quiet(n_rows, is_enough):
    """Oracle: by hand; of 200 x 100 pixels 400, which are four rows, beyond three that are near the opening."""
    mask = np.ones((200, 100), bool)
    mask[200 - n_rows - 3 :] = False
    moved = np.zeros((200, 100)) + 0j
    outline = SimpleNamespace(mask=mask, border_px=0, harmonic=moved, interior_dn=1000.0, noise_dn=0.1)
    quiet = in_contrast._quiet(outline)
    assert quiet.any() == is_enough
    assert not quiet[: 200 - n_rows].any()


def test_the_brightest_and_darkest_frames_are_brought_to_the_same_level():
    """Oracle: by hand; of 100 good frames the six brightest and the six darkest, less the drift that each has, in the middle."""
    n = 110
    light = np.random.default_rng(2).permutation(np.arange(n, dtype=float))
    drift = np.linspace(0.0, 9.0, n)
    values = np.zeros((n, 2, 3)) + drift[:, None, None]
    values[:, 0, 0] += light
    mask = np.zeros((2, 3), bool)
    mask[0, 0] = True
    good = light < 100
    sample = SimpleNamespace(values=values, common_dn=drift, level=lambda _: values[:, 0, 0] - drift)
    bright, dark = in_contrast._extreme_frames(sample, good, mask)
    middle = np.median(drift[good])
    assert bright[0, 0] == pytest.approx(97 - 0.5 + middle)
    assert dark[0, 0] == pytest.approx(2.5 + middle)
    np.testing.assert_allclose(bright[1], middle)
    np.testing.assert_allclose(dark[1], middle)
