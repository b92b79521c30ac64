"""Frames of any type of pixels as the 16-bit counts of a recording."""

from collections.abc import Iterator
from typing import final

import numpy as np

from irtiming.archive.frames.source import FrameSource, FrameValues
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Pixels

_MOST = 2**16 - 1


@final
class Counts:
    """A `FrameStack` of counts: those of the file, or steps of ``step`` from ``lowest`` where it holds other numbers."""

    def __init__(self, source: FrameSource, *, lowest: float, step: float) -> None:
        self._source, self.lowest, self.step = source, lowest, step

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of frames, rows and columns."""
        return self._source.shape

    def blocks(self) -> Iterator[tuple[int, Pixels]]:
        """Index of the first frame and values (frame, row, column), block after block, in order."""
        for first, block in self._source.blocks():
            yield first, self._counts(block)

    def pick(self, indices: list[int]) -> Pixels:
        """The named frames in the order named, shape (len(indices), row, column)."""
        return self._counts(self._source.pick(indices))

    def _counts(self, values: FrameValues) -> Pixels:
        if (self.lowest, self.step) == (0.0, 1.0):
            return values.astype(np.uint16, copy=False)
        return np.rint((values - self.lowest) / self.step).astype(np.uint16)


def counts_of(source: FrameSource, *, called: str) -> Counts:
    """Frames as counts: those of 8 and 16 bits as they are; others, such as temperatures, in 65 535 steps of all their range.

    Other numbers are read twice, since their range must be known first.

    Parameters
    ----------
    source
        Frames of any type, shape (frame, row, column).
    called
        Name of the file, for messages.

    Raises
    ------
    ArchiveError
        If a value is no number.
    """
    if source.facts.dtype in ("uint8", "uint16"):
        return Counts(source, lowest=0.0, step=1.0)
    lowest, highest = np.inf, -np.inf
    for first, block in source.blocks():
        least, most = float(block.min()), float(block.max())
        if not np.isfinite(least + most):
            raise ArchiveError(
                f"has a value that is no number in frames {first} to {first + len(block) - 1}; export it without such pixels",
                where=called,
            )
        lowest, highest = min(lowest, least), max(highest, most)
    if source.facts.dtype.startswith(("int", "uint")) and highest - lowest <= _MOST:
        return Counts(source, lowest=min(lowest, 0.0) if highest <= _MOST else lowest, step=1.0)
    return Counts(source, lowest=lowest, step=(highest - lowest) / _MOST or 1.0)
