"""Sums of each frame over the rows of the opening, with and without its blurred border."""

from typing import final

import numpy as np

from irtiming.records.reduced import Opening
from irtiming.reduce.accumulators.weighted_rows import WeightedRows
from irtiming.reduce.frame_pass import Block
from irtiming.reduce.nonuniformity import Correction
from irtiming.reduce.opening import dead_pixels


@final
class RowSums:
    """Row sums: ``summed_dn`` and ``mask_dn`` (n_frame, n_row) over the summed pixels and over the mask, corrected DN.

    ``row_px`` (n_row,) are the image rows; ``hopeless_row_px`` those whose dead pixels no others can stand in for.

    Parameters
    ----------
    opening, correct
        Whose pixels are summed, and the correction of the whole image.
    n_frames
        Of the recording.
    """

    def __init__(self, opening: Opening, correct: Correction, *, n_frames: int) -> None:
        box = np.s_[slice(*opening.roi[:2]), slice(*opening.roi[2:])]
        hopeless = dead_pixels.hopeless_rows(opening.summed, opening.bad)
        self.hopeless_row_px = np.flatnonzero(hopeless)
        self.row_px = np.flatnonzero(opening.summed.any(axis=1) & ~hopeless)
        mask_weight = dead_pixels.row_weights(opening.mask, opening.bad)
        self._rows = self.row_px - opening.roi[0]
        self._summed = WeightedRows(opening.weight[box], correct.within(opening.roi))
        self._mask = WeightedRows(mask_weight[box], correct.within(opening.roi))
        self.n_summed = opening.n_summed(self.row_px)
        self.n_mask = opening.mask[self.row_px].sum(axis=1).astype(float)
        self.summed_dn, self.mask_dn = np.zeros((2, n_frames, self.row_px.size))

    def add(self, block: Block) -> None:
        """Sum the rows of some frames."""
        self.summed_dn[block.now] = self._summed.of(block.part)[:, self._rows]
        self.mask_dn[block.now] = self._mask.of(block.part)[:, self._rows]
