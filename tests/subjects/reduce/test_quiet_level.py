"""Mean of the pixels beside the opening: against the correction carried out on every pixel."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.reduce.accumulators.quiet_level import QuietLevel
from irtiming.reduce.nonuniformity import Correction


@pytest.mark.parametrize("rows", [(3, 6), (2, 5, 6), (0,), ()], ids=["every third", "any", "the first", "none"])
def test_the_level_is_the_mean_of_the_quiet_pixels(rows):
    """Oracle: correct, then average; frames that come in two blocks, and rows that leave some of the image unread."""
    rng = np.random.default_rng(2)
    correct = Correction(
        gain=rng.uniform(0.5, 2.0, (8, 6)), offset_dn=rng.normal(0, 100, (8, 6)), bad=np.zeros((8, 6), bool)
    )
    quiet = np.zeros((8, 6), bool)
    quiet[list(rows), 1:4] = True
    frames = rng.integers(1000, 9000, (5, 8, 6)).astype(np.uint16)
    found = QuietLevel(quiet, correct, n_frames=5)
    for now in (slice(0, 3), slice(3, 5)):
        found.add(SimpleNamespace(whole=frames[now], now=now))
    corrected = correct.offset_dn + correct.gain * frames
    expected = corrected[:, quiet].mean(axis=1) if rows else np.zeros(5)
    np.testing.assert_allclose(found.level_dn, expected, rtol=1e-6)


@pytest.mark.parametrize(("fewest", "counted"), [(1, [0, 2, 5, 15]), (3, [2, 5, 15]), (4, [5, 15])])
def test_a_band_has_the_mean_of_its_own_quiet_pixels_if_they_are_enough(fewest, counted):
    """Oracle: by hand; 16 bands of two rows each, of which four have 2, 3, 4 and 12 quiet pixels."""
    quiet = np.zeros((32, 6), bool)
    quiet[0, :2], quiet[4:6, 1], quiet[4, 4], quiet[10:12, 2:4], quiet[30:, :] = True, True, True, True, True
    frames = np.random.default_rng(3).integers(1000, 9000, (4, 32, 6)).astype(np.uint16)
    correct = Correction(gain=np.ones((32, 6)), offset_dn=np.zeros((32, 6)), bad=np.zeros((32, 6), bool))
    found = QuietLevel(quiet, correct, n_frames=4, fewest=fewest)
    found.add(SimpleNamespace(whole=frames, now=slice(0, 4)))
    expected = np.zeros((4, 16))
    for band in counted:
        rows = slice(2 * band, 2 * band + 2)
        expected[:, band] = frames[:, rows][:, quiet[rows]].mean(axis=1)
    np.testing.assert_allclose(found.band_dn, expected, rtol=1e-6)
