"""Frames that are not like their neighbours along the wheel angle: by hand."""

import numpy as np
import pytest

from irtiming.errors import EstimationError
from irtiming.estimate import wild_frames

N = 400
_NOISE = 1e-3 * np.tile([1.0, -1.0, -1.0, 1.0], N // 4)  # whose spread is 1.48e-3


def _asked(residual, *, order=None):
    """Which of the frames are wild; in any order of the wheel's angles."""
    angle = 2 * np.pi * (np.arange(N) / N if order is None else np.argsort(order) / N)
    found = wild_frames.of(residual, angle, name="run")
    return np.flatnonzero(found).tolist()


@pytest.mark.parametrize(("off", "wild"), [(6e-3, []), (20e-3, [70]), (-20e-3, [70])])
def test_a_frame_far_from_its_neighbours_is_wild_to_either_side(off, wild):
    """Oracle: by hand; six times what frames differ from their neighbours by, some 2e-3."""
    residual = _NOISE.copy()
    residual[70] += off
    assert _asked(residual) == wild


def test_neighbours_are_those_along_the_angle_whatever_came_before():
    """Oracle: the same frames in another order of time; a model that is coarse bends slowly along the angle and is no frame."""
    order = np.random.default_rng(1).permutation(N)
    along = _NOISE + 0.02 * np.sin(4 * np.pi * np.arange(N) / N)
    along[70] += 30e-3
    shuffled = along[order]
    assert _asked(along) == [70]
    assert [order[k] for k in _asked(shuffled, order=np.argsort(order))] == [70]


def test_a_frame_that_is_off_by_less_than_counts_is_left():
    """Oracle: by hand; without noise, 5e-4 of the step."""
    residual = np.zeros(N)
    residual[[10, 200]] = 4.9e-4, 5.1e-4
    assert _asked(residual) == [200]


@pytest.mark.parametrize(("n", "refused"), [(20, False), (21, True)])
def test_more_than_a_twentieth_is_refused(n, refused):
    """Oracle: by hand; 20 of 400 frames may be wild."""
    residual = _NOISE.copy()
    residual[:: N // n][:n] += 0.5
    if not refused:
        assert len(_asked(residual)) == n
        return
    with pytest.raises(EstimationError, match=r"run: 21 of 400 frames differ .* at most 5% may"):
        _asked(residual)


@pytest.mark.parametrize(("scale", "refused"), [(66.0, False), (69.0, True)])
def test_sums_that_scatter_by_more_than_a_tenth_of_the_step_follow_no_wheel(scale, refused):
    """Oracle: by hand; residuals of one size to either side spread by 1.483 times that. Where half are off, the rest is zero."""
    residual = 0.4 + scale * _NOISE
    if not refused:
        assert _asked(residual) == []
        return
    with pytest.raises(EstimationError, match="scatter about the model by 0.1 of the step, at most 0.1 may be"):
        _asked(residual)
