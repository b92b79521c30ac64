"""Frames at an end of the scale, and frames that repeat the one before, over blocks: by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.reduce.accumulators.limits import Limits
from irtiming.reduce.accumulators.repeats import Repeats

FULL_SCALE = 4095


def _blocks(frames, length):
    for first in range(0, len(frames), length):
        yield SimpleNamespace(now=slice(first, first + length), part=frames[first : first + length])


@pytest.mark.parametrize("end", [0, FULL_SCALE])
@pytest.mark.parametrize(("n_at_end", "is_dead"), [(8, False), (9, True), (16, True)])
def test_a_frame_more_than_half_of_which_is_at_an_end_is_dead(end, n_at_end, is_dead):
    """Oracle: by hand; 16 pixels in the rows that are looked at, 0 and 4 of 8. What other rows hold says nothing."""
    frames = np.full((3, 8, 8), 2000, np.uint16)
    frames[:, [1, 2, 3, 5, 6, 7]] = end
    looked_at = frames[1, ::4].reshape(-1)
    looked_at[:n_at_end] = end
    frames[1, ::4] = looked_at.reshape(2, 8)
    limits = Limits(FULL_SCALE, n_frames=3)
    for block in _blocks(frames, 2):
        limits.add(block)
    assert limits.is_dead.tolist() == [False, is_dead, False]


def test_pixels_at_both_ends_do_not_add_up():
    """Oracle: by hand; 8 of 16 pixels at either end are half at most."""
    frames = np.zeros((1, 4, 16), np.uint16)
    frames[0, 0, 8:] = FULL_SCALE
    limits = Limits(FULL_SCALE, n_frames=1)
    limits.add(next(_blocks(frames, 1)))
    assert not limits.is_dead.any()


def test_repeats_are_found_within_blocks_and_across_them():
    """Oracle: by hand; frames 2 and 3 are frame 1 again, of which 2 begins a block; one that differs by a bit is no repeat."""
    frames = np.random.default_rng(0).integers(100, 4000, (7, 4, 5), dtype=np.uint16)
    frames[2] = frames[3] = frames[1]
    frames[6] = frames[5]
    frames[6, 3, 4] ^= 1
    repeats = Repeats(1.0, n_frames=7)
    for block in _blocks(frames, 2):
        repeats.add(block)
    assert np.flatnonzero(repeats.is_repeated).tolist() == [2, 3]


def test_what_was_given_may_change_afterwards():
    """Oracle: by hand; a block is valid until the next one, so the last frame must have been kept elsewhere."""
    frames = np.random.default_rng(1).integers(100, 4000, (2, 4, 5), dtype=np.uint16)
    repeats, block = Repeats(1.0, n_frames=4), SimpleNamespace(now=slice(0, 2), part=frames)
    repeats.add(block)
    last = frames[1].copy()
    frames[:] = 0
    repeats.add(SimpleNamespace(now=slice(2, 4), part=np.stack([last, last])))
    assert repeats.is_repeated.tolist() == [False, False, True, True]


def test_without_noise_no_frame_is_a_repeat():
    """Oracle: by hand; frames of one scene are then alike."""
    repeats = Repeats(0.0, n_frames=4)
    repeats.add(SimpleNamespace(now=slice(0, 4), part=np.ones((4, 2, 2), np.uint16)))
    assert not repeats.is_repeated.any()
