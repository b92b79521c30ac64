"""Sums of waves times pixel values, against sums written out."""

import numpy as np
import pytest

from irtiming.physics import wheel_waves
from irtiming.records.reduced import Opening
from irtiming.reduce.accumulators.pixel_waves import WavesOfPixels
from irtiming.reduce.nonuniformity import Correction

N, ROWS, COLUMNS = 300, 9, 11


@pytest.fixture
def opening():
    """A summed disc off the middle of a region of interest."""
    row, column = np.indices((ROWS, COLUMNS))
    summed = (row - 4) ** 2 + (column - 5) ** 2 < 12
    nothing = np.zeros((ROWS, COLUMNS))
    return Opening(
        roi=(1, 8, 1, 10),
        open_frame_dn=nothing,
        covered_frame_dn=nothing,
        mask=summed,
        summed=summed,
        weight=summed.astype(float),
        border_px=1,
        bad=np.zeros((ROWS, COLUMNS), bool),
        blackbody_is_colder=False,
    )


def test_sums_are_those_of_kept_frames_with_each_stretch_less_its_mean(opening):
    """Oracle: the definition, in double precision and one frame after the other; a dropped stretch leaves no trace."""
    random = np.random.default_rng(1)
    angle = np.sort(random.uniform(0, 2 * np.pi, N))
    frames = random.integers(0, 60_000, (N, ROWS, COLUMNS)).astype(np.uint16)
    gain = random.uniform(0.9, 1.1, (ROWS, COLUMNS))
    waves = WavesOfPixels(angle, opening, n_angles=N)
    within = frames[:, 1:8, 1:10]
    stretches = [np.arange(140), np.arange(140, 190), np.setdiff1d(np.arange(190, N), [200, 201])]
    for k, stretch in enumerate(stretches):
        for part in np.array_split(stretch, 3):
            waves.add(part, within[part])
        if k == 1:
            waves.drop()
        else:
            waves.keep(stretch)
    kept = np.concatenate([stretches[0], stretches[2]])
    drift = random.normal(size=kept.size)
    correct = Correction(gain=gain, offset_dn=0 * gain, bad=gain < 0)
    found = waves.found(correct=correct, drift_dn=drift)
    segment = np.concatenate([np.zeros(140, int), np.ones(108, int)])
    made = wheel_waves.waves(angle[kept], np.r_[found.signal_orders, found.quiet_orders], segment=segment)
    value = gain * frames[kept] - drift[:, None, None]
    want = np.einsum("kn,nrc->krc", made, value)[:, opening.summed]
    np.testing.assert_array_equal(found.row_px, np.nonzero(opening.summed)[0])
    scale = np.sqrt(N) * 60_000
    np.testing.assert_allclose(found.sums_dn / scale, want / scale, atol=2e-6)


@pytest.mark.parametrize("n", [100, 500, 1000])
def test_quiet_orders_are_told_apart_and_are_none_of_the_seen_ones(n):
    """Oracle: what evenly spaced angles can tell: products of waves of distinct orders below half their number add up to 0."""
    seen, quiet = wheel_waves.signal_orders(n), wheel_waves.quiet_orders(n)
    assert set(seen % 4) == {2}
    assert not set(seen) & set(quiet)
    assert 2 not in quiet % 4
    made = wheel_waves.waves(2 * np.pi * np.arange(n) / n, np.r_[seen, quiet], segment=np.zeros(n, int))
    np.testing.assert_allclose(made @ made.T, n / 2 * np.eye(len(made)), atol=1e-9 * n)
