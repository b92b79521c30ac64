"""Weighted sums over rows: against the correction carried out on every pixel."""

import numpy as np
import pytest

from irtiming.reduce.accumulators.weighted_rows import WeightedRows
from irtiming.reduce.nonuniformity import Correction


@pytest.mark.parametrize("every", [1, 3])
@pytest.mark.parametrize("is_none", [False, True])
def test_rows_are_sums_of_weighted_corrected_values(is_none, every):
    """Oracle: correct, weigh, add up; weights of none, of one, and of those that stand in for a bad neighbour.

    Of all rows, or of every third from the first on.
    """
    rng = np.random.default_rng(3)
    weight = np.array([[0.0, 1.0, 1.5, 0.0, 1.5], [1.0, 1.0, 1.0, 1.0, 1.0], [0.0, 0.0, 0.0, 0.5, 2.0]])
    gain = np.ones((3, 5)) if is_none else rng.uniform(0.5, 2.0, (3, 5))
    offset = np.zeros((3, 5)) if is_none else rng.normal(0, 100, (3, 5))
    correct = Correction(gain=gain, offset_dn=offset, bad=np.zeros((3, 5), bool), is_none=is_none)
    frames = rng.integers(1000, 9000, (4, 2 * every + 1, 5)).astype(np.uint16)
    expected = np.sum(weight * (offset + gain * frames[:, ::every]), axis=2)
    np.testing.assert_allclose(WeightedRows(weight, correct, every=every).of(frames), expected, rtol=1e-6)
