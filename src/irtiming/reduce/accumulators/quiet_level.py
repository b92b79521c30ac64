"""Mean level of pixels beside the opening, which do not follow the wheel."""

from typing import final

import numpy as np

from irtiming.records.arrays import Mask
from irtiming.reduce import row_bands
from irtiming.reduce.accumulators.weighted_rows import WeightedRows
from irtiming.reduce.frame_pass import Block
from irtiming.reduce.nonuniformity import Correction


@final
class QuietLevel:
    """Mean of the quiet pixels of each frame: ``level_dn`` (n_frame,), corrected DN; 0 where there are none.

    ``band_dn`` (n_frame, n_band) are the means of bands of rows, 0 where too few are quiet: a shutter that is closed while a
    part of the rows is read, or rows that got lost, show there, and hardly in the mean of the frame.

    Parameters
    ----------
    quiet, correct
        Pixels, and the correction; both of the whole image, shape (row, column).
    n_frames
        Of the recording.
    fewest
        Pixels of a band that count, lest noise does.
    """

    def __init__(self, quiet: Mask, correct: Correction, *, n_frames: int, fewest: int = 1) -> None:
        self._n_quiet = int(quiet.sum())
        used = np.flatnonzero(quiet.any(axis=1))
        every = max(1, int(np.gcd.reduce(used)))
        thin = (slice(None, None, every), slice(None))
        self._sums = WeightedRows(quiet[thin].astype(float), correct.at(thin), every=every)
        counts = quiet[thin].sum(axis=1)
        self._bands = row_bands.starts(counts.size)
        in_band = np.add.reduceat(counts, self._bands)
        self._in_band = np.where(in_band >= fewest, in_band, np.inf)
        self.level_dn, self.band_dn = np.zeros(n_frames), np.zeros((n_frames, self._bands.size))

    def add(self, block: Block) -> None:
        """Average over some frames' quiet pixels."""
        if self._n_quiet:
            sums = self._sums.of(block.whole)
            self.level_dn[block.now] = sums.sum(axis=1) / self._n_quiet
            self.band_dn[block.now] = np.add.reduceat(sums, self._bands, axis=1) / self._in_band
