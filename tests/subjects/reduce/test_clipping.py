"""Values that pile up at an end of a range."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.reduce import clipping

OPENING = np.ones((10, 12), bool)


def _recording(change, *, noise=5.0):
    open_ = (np.arange(60) % 5 < 2)[:, None, None]
    frames = 3000 + 4000 * open_ + np.random.default_rng(1).normal(0, noise, (60, 10, 12))
    frames = np.rint(change(frames)).astype(np.uint16)
    return SimpleNamespace(name="run", frames=SimpleNamespace(shape=frames.shape, pick=lambda which: frames[which]))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda v: np.minimum(v, 6000), "values are 6000 DN, the largest of all"),
        (lambda v: np.maximum(v, 3500), "values are 3500 DN, the smallest of all"),
    ],
)
def test_clipped_values_are_refused_with_their_number(change, says):
    """Oracle: where they were clipped."""
    with pytest.raises(ReductionError, match=says):
        clipping.refuse(_recording(change), OPENING)


@pytest.mark.parametrize("noise", [0.0, 1.0, 5.0])
def test_whole_values_are_let_pass(noise):
    """Oracle: nothing was clipped; without noise both plateaus are single numbers, with a dead pixel one more."""

    def with_dead(values):
        values[:, :, :2] = 9000
        return values

    clipping.refuse(_recording(lambda v: v, noise=noise), OPENING)
    clipping.refuse(_recording(with_dead, noise=noise), OPENING)
