"""One pass over frames: who gets which frame when, told by lists."""

import numpy as np
import pytest

from irtiming.records.choices import Choices
from irtiming.reduce import frame_pass

ROI = (1, 4, 2, 6)


class _Recording:
    """Numbered frames: all pixels of frame k have the value k, in blocks of any length."""

    def __init__(self, n, block):
        self.values = np.tile(np.arange(n, dtype=np.uint16)[:, None, None], (1, 5, 7))
        self.values += np.arange(35, dtype=np.uint16).reshape(5, 7) * 1000
        self.frames, self.shape, self._block = self, self.values.shape, block

    def blocks(self):
        for first in range(0, len(self.values), self._block):
            block = self.values[first : first + self._block].copy()
            yield first, block
            block[:] = 9  # a block is valid until the next one only


class _Every:
    def __init__(self):
        self.seen, self.parts = [], []

    def add(self, block):
        self.seen.extend(range(block.now.start, block.now.stop))
        self.parts.append(block.part.copy())


class _Judge(_Every):
    """Frames in ``bad`` are bad, those in ``near`` at an event; both are known ``reach`` frames later."""

    def __init__(self, n, bad=(), near=(), reach=0):
        super().__init__()
        self.reach, self.n = reach, n
        self.bad, self.near = np.isin(np.arange(n), [*bad, *near]), np.isin(np.arange(n), near)

    def decide(self, first, end, *, n_read):
        assert first == end or end == n_read == self.n or end <= n_read - self.reach
        return ~self.bad[first:end], self.near[first:end]


class _Good:
    def __init__(self):
        self.now, self.kept, self.dropped = [], [], []

    def add(self, index, frames):
        assert frames.shape[1:] == (3, 4)
        assert np.array_equal(frames[:, 0, 0] - 9000, index)
        self.now.extend(index.tolist())

    def keep(self, index):
        assert self.now == index.tolist()
        self.kept.append(self.now)
        self.now = []

    def drop(self):
        self.dropped.append(self.now)
        self.now = []


def _run(n, judge, *, block):
    recording, every, good, told = _Recording(n, block), _Every(), _Good(), []
    feeding = frame_pass.Accumulators(every=(every,), judge=judge, good=(good,))
    found = frame_pass.run(recording, ROI, feeding=feeding, progress=told.append, choices=Choices())
    assert every.seen == judge.seen == list(range(n))
    assert np.array_equal(np.concatenate(every.parts), recording.values[:, 1:4, 2:6])
    assert told == [*range(block, n, block), n]
    return found, good


@pytest.mark.parametrize("block", [1, 7, 50, 500])
@pytest.mark.parametrize("reach", [0, 5, 60, 400])
def test_good_frames_come_once_and_in_order_whatever_is_held_back(block, reach):
    """Oracle: the lists by hand; events leave stretches of 98, 20 and 161 frames, the second of them too short."""
    near = [*range(100, 110), *range(130, 138)]
    judge = _Judge(300, bad=[3, 50, 299], near=near, reach=reach)
    found, good = _run(300, judge, block=block)
    first, second = ([k for k in range(a, b) if k not in (3, 50, 299)] for a, b in ((0, 100), (138, 300)))
    assert good.kept == [first, second]
    assert good.dropped == [list(range(110, 130))]
    assert found.short.tolist() == [[110, 130]]
    assert np.flatnonzero(found.segment == 0).tolist() == first
    assert np.flatnonzero(found.segment == 1).tolist() == second
    assert np.sum(found.segment < 0) == 300 - len(first) - len(second)


@pytest.mark.parametrize("n", [59, 60])
def test_sixty_frames_are_a_stretch(n):
    """Oracle: the limit in the module, on both of its sides."""
    found, good = _run(n, _Judge(n), block=16)
    assert len(good.kept) == (n == 60)
    assert len(good.dropped) == (n == 59)
    assert found.short.tolist() == ([] if n == 60 else [[0, 59]])
    assert set(found.segment.tolist()) == {0 if n == 60 else -1}
