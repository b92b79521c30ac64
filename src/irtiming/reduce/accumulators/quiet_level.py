"""Mean level of pixels beside the opening, which do not follow the wheel."""

from typing import final

import numpy as np

from irtiming.records.arrays import Mask
from irtiming.reduce.accumulators.weighted_rows import WeightedRows
from irtiming.reduce.frame_pass import Block
from irtiming.reduce.nonuniformity import Correction


@final
class QuietLevel:
    """Mean of the quiet pixels of each frame: ``level_dn`` (n_frame,), corrected DN; 0 where there are none.

    Parameters
    ----------
    quiet, correct
        Pixels, and the correction; both of the whole image, shape (row, column).
    n_frames
        Of the recording.
    """

    def __init__(self, quiet: Mask, correct: Correction, *, n_frames: int) -> None:
        self._n_quiet = int(quiet.sum())
        used = np.flatnonzero(quiet.any(axis=1))
        self._rows = slice(None, None, max(1, int(np.gcd.reduce(used))))
        thin = (self._rows, slice(None))
        self._sums = WeightedRows(quiet[thin].astype(float), correct.at(thin))
        self.level_dn = np.zeros(n_frames)

    def add(self, block: Block) -> None:
        """Average over some frames' quiet pixels."""
        if self._n_quiet:
            some = np.ascontiguousarray(block.whole[:, self._rows])
            self.level_dn[block.now] = self._sums.of(some).sum(axis=1) / self._n_quiet
