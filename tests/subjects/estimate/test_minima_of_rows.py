"""Rows of a camera whose filter and lag look nearly alike: which of two minima is found, and what is said of the other."""

from types import SimpleNamespace

import numpy as np
import pytest
from test_row_timing import M, _model

from irtiming.estimate import row_timing
from irtiming.estimate.harmonic_data import compress
from irtiming.physics.camera import camera
from irtiming.physics.light.row_sum import EDGE_DELAYS, harmonics
from irtiming.physics.wheel_harmonics import at_angles

OMEGA, FRAME_S = 2 * np.pi * 1.1, 14e-3
DELAY_S, LAG_S, SHARE = 3.4e-3, 2.6e-3, 0.3
MEMORY = "recursive_filter"
MODEL = _model(camera=camera("microbolometer", "snapshot"), angular_frequency_rad_per_s=OMEGA, step_rad=OMEGA * FRAME_S)


def _data(seed, *, share=SHARE, noise=60.0, n=160):
    """Rows of a camera that is read at once, 2.5 turns long, compressed."""
    truth = dict.fromkeys(MODEL.names, 0.0) | dict.fromkeys(EDGE_DELAYS, DELAY_S)
    truth |= {"time_constant": LAG_S, "recursive_filter": share}
    angle = 0.4 + OMEGA * FRAME_S * np.arange(n)
    sums = 9e4 - 600 * at_angles(harmonics(MODEL, truth), angle).T
    return [compress(angle, sums + np.random.default_rng(seed).normal(0, noise, sums.shape), n_harmonics=M)]


@pytest.mark.parametrize("seed", [2, 3, 5])
def test_the_lower_of_two_minima_is_that_of_all_harmonics(seed):
    """Oracle: the numbers that made the rows; the other minimum has a lag near the frame period, and fits as much worse."""
    data = _data(seed)
    found = row_timing.solve(data, MODEL, signs=(-1,))
    assert found.timing["recursive_filter"] == pytest.approx(SHARE, abs=3 * found.u["recursive_filter"])
    assert found.timing["time_constant"] == pytest.approx(LAG_S, abs=3 * found.u["time_constant"])
    assert found.rival.timing["time_constant"] == pytest.approx(FRAME_S, abs=3e-3)
    there = row_timing.likelihood(data, MODEL, timing=found.rival.timing).deviance
    here = row_timing.likelihood(data, MODEL, timing=found.timing).deviance
    below = min(0.0, found.rival.timing["recursive_filter"]) / row_timing.uncertainty(
        data, MODEL, timing=found.rival.timing, name="recursive_filter"
    )
    assert found.rival.higher == pytest.approx(there + below**2 - here, abs=0.05)
    assert found.rival.higher > 5


def test_a_start_in_the_wrong_minimum_is_left_where_the_search_is_made_anew():
    """Oracle: the minimum that the search without a start finds; without a search the start's own minimum is all there is."""
    data = _data(3)
    right = row_timing.solve(data, MODEL, signs=(-1,))
    stays = row_timing.solve(data, MODEL, start=right.rival.timing, signs=(-1,))
    assert stays.timing["time_constant"] == pytest.approx(right.rival.timing["time_constant"], abs=1e-5)
    assert stays.rival is None
    leaves = row_timing.solve(data, MODEL, start=right.rival.timing, signs=(-1,), is_searched=True)
    assert leaves.timing["time_constant"] == pytest.approx(right.timing["time_constant"], abs=1e-5)
    assert leaves.rival.higher == pytest.approx(right.rival.higher, abs=0.05)


def test_a_start_is_kept_where_the_other_minimum_is_hardly_lower():
    """Oracle: by hand; 0.5 of misfit is less than the 4 by which it must be: the start stays, the other is 0.5 lower."""
    data = _data(1, noise=150.0)
    lower = row_timing.solve(data, MODEL, signs=(-1,))
    assert 0 < lower.rival.higher < 4
    kept = row_timing.solve(data, MODEL, start=lower.rival.timing, signs=(-1,), is_searched=True)
    assert kept.timing["time_constant"] == pytest.approx(lower.rival.timing["time_constant"], abs=1e-4)
    assert kept.rival.higher == pytest.approx(-lower.rival.higher, abs=0.05)


def test_a_share_below_zero_adds_its_square_to_the_misfit():
    """Oracle: by hand; no camera holds less than nothing of the frame before: k is k / u beside the nearest share."""
    data = _data(4, share=-0.2, noise=20.0, n=400)
    found = row_timing.solve(data, MODEL, signs=(-1,), held={"time_constant": LAG_S})
    u = row_timing.uncertainty(data, MODEL, timing=found.timing, name="recursive_filter")
    assert found.timing["recursive_filter"] < -3 * u
    added = found.misfit - found.minimum.at.deviance
    assert added == pytest.approx((found.timing["recursive_filter"] / u) ** 2, rel=1e-6)
    assert row_timing.solve(_data(4), MODEL, signs=(-1,), held={"recursive_filter": SHARE}).u.keys() == found.u.keys()


def test_a_search_beside_an_earlier_fit_ends_at_shares_below_one_each_once(monkeypatch):
    """Oracle: by hand; a filter of 1.7 leaves each harmonic as strong as one of 1 / 1.7, a frame later, and is no camera's."""
    ends = {
        0.0: (0.04, 12.0),
        0.25: (1.7, 3.0),
        0.5: (0.04, 12.0),
    }  # share from which a search begins: where it ends, how deep
    kind = camera("microbolometer", "rolling")
    model = SimpleNamespace(camera=kind, row_px=np.arange(3), some_rows=lambda _: None)
    held_first = []

    def minimum(_, __, *, start, held):
        held_first.append(held)
        return SimpleNamespace(values=start), None

    def with_share(_, __, *, start, held):
        share, deviance = ends[start[MEMORY]]
        return SimpleNamespace(values={MEMORY: share}, at=SimpleNamespace(deviance=deviance)), held

    monkeypatch.setattr(row_timing, "_minimum", minimum)
    monkeypatch.setattr(row_timing, "_with_share", with_share)
    (found,) = row_timing._beside([], model, start={MEMORY: 0.1}, held={})
    assert found.values == {MEMORY: 0.04}
    assert held_first == [{MEMORY: share} for share in ends]
    assert row_timing._beside([], model, start={MEMORY: 0.1}, held={MEMORY: 0.1}) == []
