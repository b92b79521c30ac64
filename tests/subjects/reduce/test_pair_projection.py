"""The projection of frames in pairs, against sums written out over whole stacks."""

import numpy as np
import pytest

from irtiming.reduce.accumulators.projection import Projection

SHAPE = (3, 4)


@pytest.fixture
def stack():
    """Frames, their wave, and which were triggered next after the one before."""
    rng = np.random.default_rng(2)
    frames = rng.integers(0, 4000, (60, *SHAPE)).astype(np.uint16)
    follows = np.ones(60, bool)
    follows[[0, 13, 41]] = False
    return frames, np.exp(-2j * rng.uniform(0, 6, 60)), follows


def _projected(stack, stretches, *, block):
    """Stretches of frames, given in blocks."""
    frames, wave, follows = stack
    made = Projection(wave, shape=SHAPE, follows=follows)
    for stretch in stretches:
        for first in range(0, len(stretch), block):
            part = stretch[first : first + block]
            made.add(part, np.ascontiguousarray(frames[part]))
        made.keep(stretch)
    return made


@pytest.mark.parametrize("block", [1, 7, 60])
def test_pairs_are_sums_over_frames_that_followed_each_other(stack, block):
    """Oracle: by numpy over the whole stack; a frame left out, one after a lost trigger, and two stretches."""
    frames, wave, follows = stack
    stretches = [np.delete(np.arange(30), 5), np.arange(32, 60)]
    made = _projected(stack, stretches, block=block).pairs
    now, before, weight = np.zeros(SHAPE, complex), np.zeros(SHAPE, complex), []
    for stretch in stretches:
        pairs = np.array([n for n in stretch if n - 1 in stretch and follows[n]])
        centred = wave[pairs] - wave[pairs].mean()
        now += np.tensordot(centred, frames[pairs].astype(float), 1)
        before += np.tensordot(centred, frames[pairs - 1].astype(float), 1)
        weight.append([dict(zip(pairs.tolist(), centred, strict=True)).get(n, 0.0) for n in stretch.tolist()])
    np.testing.assert_allclose(made.now, now, rtol=1e-10)
    np.testing.assert_allclose(made.before, before, rtol=1e-10)
    found = made.frame_weight
    np.testing.assert_allclose(found, np.concatenate(weight) * 2 / np.count_nonzero(found), atol=1e-12)


def test_a_dropped_stretch_leaves_nothing(stack):
    """Oracle: the same without it."""
    frames, wave, follows = stack
    one, other = (Projection(wave, shape=SHAPE, follows=follows) for _ in range(2))
    one.add(np.arange(10), frames[:10])
    one.drop()
    for made in (one, other):
        made.add(np.arange(20, 50), frames[20:50])
        made.keep(np.arange(20, 50))
    np.testing.assert_array_equal(one.pairs.before, other.pairs.before)
    np.testing.assert_array_equal(one.pairs.now, other.pairs.now)


def test_a_projection_is_a_sum_over_each_stretch(stack):
    """Oracle: by numpy over the whole stack; the wave less its mean in each of two stretches, and sums of the values."""
    frames, wave, _ = stack
    stretches = [np.delete(np.arange(30), 5), np.arange(32, 60)]
    made = _projected(stack, stretches, block=7)
    total = sum(np.tensordot(wave[one] - wave[one].mean(), frames[one].astype(float), 1) for one in stretches)
    np.testing.assert_allclose(made.total, total, rtol=1e-10)
    np.testing.assert_allclose(made.level, frames[np.concatenate(stretches)].sum(axis=0), rtol=1e-12)
