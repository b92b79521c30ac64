"""How frames and strobe edges are paired by their rhythm: by hand, and against a sum over all pairings."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.reduce.events import strobe

N, SPARE = 40, 3


@pytest.fixture
def irregular():
    """Edges whose period wanders by 20 us, and stamps of all frames but two, from edge 2 on, on a clock that is 1e-4 fast."""
    random = np.random.default_rng(3)
    edge_s = np.cumsum(10e-3 + 20e-6 * random.standard_normal(N + SPARE))
    number = np.delete(np.arange(N), [7, 20])
    stamp_s = 5.0 + 1.0001 * (edge_s[number + 2] + 1e-6 * random.standard_normal(number.size))
    return stamp_s, edge_s, number


def test_stamps_single_out_the_pairing_that_they_follow(irregular):
    """Oracle: NumPy's straight line through stamps less edges, at each of four pairings; medians of what is left."""
    stamp_s, edge_s, number = irregular
    found = strobe._by_pattern(stamp_s, edge_s, number, spare=SPARE)
    spreads = []
    for first in range(SPARE + 1):
        beside = stamp_s - edge_s[number + first]
        left = beside - np.polyval(np.polyfit(number, beside, 1), number)
        spreads.append(1.4826 * np.median(np.abs(left - np.median(left))))
    assert found.first == 2 == np.argmin(spreads)
    assert (found.scatter_s, found.second_s) == pytest.approx(np.sort(spreads)[:2], rel=1e-6)
    assert 0.3e-6 < found.scatter_s < 3e-6
    assert found.ahead == pytest.approx(number.size / 2 * np.log(found.second_s / found.scatter_s))
    assert found.ahead > 10


def test_a_regular_camera_pairs_nothing():
    """Oracle: by hand; edges 10 ms apart look alike from every first one, but for the noise of the stamps."""
    edge_s, number = 10e-3 * np.arange(N + SPARE), np.arange(N)
    stamp_s = edge_s[:N] + 1e-6 * np.random.default_rng(4).standard_normal(N)
    assert strobe._by_pattern(stamp_s, edge_s, number, spare=SPARE).ahead < 1e-6


@pytest.mark.parametrize(("edges", "says"), [(None, "holds 0 edges for 5 frames"), (7, "holds 7 edges for 5 frames")])
def test_fewer_edges_than_tell_a_rhythm_are_refused(edges, says):
    """Oracle: by hand; eight are needed."""
    ticks = None if edges is None else 1000 * np.arange(edges)
    recording = SimpleNamespace(name="run", camera_input_ticks=ticks, frames=SimpleNamespace(shape=(5, 2, 2)))
    with pytest.raises(ReductionError, match=f"{says}, at least 8 are needed"):
        strobe.place(recording)
