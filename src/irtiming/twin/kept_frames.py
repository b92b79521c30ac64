"""Frames that are made once: whoever reads a small recording a second time finds them in memory."""

from collections.abc import Iterator
from typing import final

import numpy as np

from irtiming.records.arrays import Pixels
from irtiming.records.recording import FrameStack

_MOST_BYTES = 64e6
_BLOCK_BYTES = 16e6
_FEW = 0.2  # of all frames: so many are made alone, and once more by the pass


@final
class KeptFrames:
    """Stack of frames that keeps what a whole pass made.

    Parameters
    ----------
    made
        Makes the frames, the same ones every time.
    one_by_one
        Whether it makes a single frame without those before it: then a few that are asked for before the pass are made alone.
    """

    def __init__(self, made: FrameStack, *, one_by_one: bool) -> None:
        self._made, self._one_by_one = made, one_by_one
        self._all: Pixels | None = None
        self._n_alone = 0

    @property
    def shape(self) -> tuple[int, int, int]:
        """Frames, rows and columns."""
        return self._made.shape

    def blocks(self) -> Iterator[tuple[int, Pixels]]:
        """Index of the first frame and values (frame, row, column), block after block, in order.

        A block is valid until the next one is asked for.
        """
        if self._all is None:
            yield from self._pass()
            return
        length = max(1, int(_BLOCK_BYTES / max(1, self._all[:1].nbytes)))
        for first in range(0, len(self._all), length):
            yield first, self._all[first : first + length].copy()

    def pick(self, indices: list[int]) -> Pixels:
        """The named frames, shape (len(indices), row, column).

        Raises
        ------
        ReductionError
            If there is no such frame.
        """
        exist = all(0 <= index < self.shape[0] for index in indices)
        self._n_alone += len(indices)
        if exist and self._all is None and not (self._one_by_one and self._n_alone < _FEW * self.shape[0]):
            for _ in self._pass():
                pass
        return self._made.pick(indices) if self._all is None or not exist else np.asarray(self._all[indices])

    def _pass(self) -> Iterator[tuple[int, Pixels]]:
        frames = np.empty(self.shape, np.uint16)
        for first, block in self._made.blocks():
            frames[first : first + len(block)] = block
            yield first, block
        self._all = frames


def kept(made: FrameStack, *, one_by_one: bool) -> FrameStack:
    """The same frames, kept where all of them need little memory; parameters as of `KeptFrames`."""
    n_frame, rows, columns = made.shape
    return KeptFrames(made, one_by_one=one_by_one) if 2 * n_frame * rows * columns <= _MOST_BYTES else made
