"""Judge of frames in which the camera may correct itself: by the level of the opening, of quiet pixels, and by repeats."""

from typing import final

import numpy as np

from irtiming.records.arrays import Array, Mask
from irtiming.reduce.accumulators.limits import Limits
from irtiming.reduce.accumulators.quiet_level import QuietLevel
from irtiming.reduce.accumulators.repeats import Repeats
from irtiming.reduce.accumulators.row_sums import RowSums
from irtiming.reduce.frame_pass import Block
from irtiming.reduce.shutter import FrameLevels, Watch


@final
class ShutterJudge:
    """Judgement of the frames so far; that of a frame is final when enough frames after it are known.

    Shapes (n_frame,): ``suspicious``, ``event`` and ``zone`` as `shutter.Watch.judge` says; ``levels`` they come from.

    Parameters
    ----------
    watch
        How frames are judged.
    expected_dn
        Level of the opening that each frame's wheel angle demands, shape (n_frame,), DN; nan where the angle is unknown.
    rows, quiet, limits, repeats
        What tells of each frame; fed before the judge.
    """

    def __init__(
        self, watch: Watch, expected_dn: Array, *, rows: RowSums, quiet: QuietLevel, limits: Limits, repeats: Repeats
    ) -> None:  # fmt: skip
        self._watch, self._expected, self._rows = watch, expected_dn, rows
        self._is_known = np.isfinite(expected_dn)
        self.levels = FrameLevels(
            beside_dn=np.full(expected_dn.size, np.nan),
            quiet_dn=quiet.level_dn,
            band_dn=quiet.band_dn,
            repeated=repeats.is_repeated,
            dead=limits.is_dead,
        )
        self.suspicious, self.event, self.zone = np.zeros((3, expected_dn.size), bool)

    @property
    def reach(self) -> int:
        """By how many frames a frame's judgement looks ahead."""
        return self._watch.reach

    def add(self, block: Block) -> None:
        """Compare the levels of some frames with what their wheel angles demand."""
        now = block.now
        level = self._rows.mask_dn[now].sum(axis=1) / self._rows.n_mask.sum()
        self.levels.beside_dn[now] = level - self.levels.quiet_dn[now] - self._expected[now]

    def decide(self, first: int, end: int, *, n_read: int) -> tuple[Mask, Mask]:
        """Judge frames ``first`` to ``end`` (excluded) of the ``n_read`` that have been read: good ones, those near an event."""
        window = slice(max(0, first - self.reach), min(n_read, end + self.reach))
        inside = slice(first - window.start, end - window.start)
        at_end = window.stop == self._expected.size
        judged = self._watch.judge(self.levels.of(window), at_start=window.start == 0, at_end=at_end)
        for mine, found in zip((self.suspicious, self.event, self.zone), judged, strict=True):
            mine[first:end] = found[inside]
        now = slice(first, end)
        return self._is_known[now] & ~self.suspicious[now] & ~self.zone[now], self.zone[now]
