"""What may go wrong between a simulated camera and its client."""

from dataclasses import dataclass
from typing import final

import numpy as np


@final
@dataclass(kw_only=True)
class CameraFaults:
    """Faults of a camera, its cable and its clock; all may be changed while it runs.

    Triggers are counted from 0 since the acquisition began. ``triggers_missed`` make neither a frame nor a gap in the
    block identifiers; of ``frames_lost`` every packet is lost, and resends too; after each of ``frames_spurious`` comes
    another frame without a request. A ``frozen`` camera repeats the pixels of its last frame. While it is
    ``unplugged`` it is silent. Per-mille numbers are chances of each packet; `resend_honoured` is whether the camera
    sends again what it is asked for. Without ``has_timestamps`` all are 0.
    """

    packets_lost_per_mille: float = 0.0
    packets_doubled_per_mille: float = 0.0
    packets_late_per_mille: float = 0.0
    resend_honoured: bool = True
    triggers_missed: frozenset[int] = frozenset()
    frames_lost: frozenset[int] = frozenset()
    frames_spurious: frozenset[int] = frozenset()
    frozen: bool = False
    unplugged: bool = False
    has_timestamps: bool = True
    seed: int = 0

    @property
    def harms_packets(self) -> bool:
        """Whether packets can come to harm one by one."""
        return max(self.packets_lost_per_mille, self.packets_doubled_per_mille, self.packets_late_per_mille) > 0

    def arriving(self, packets: list[int], *, index: tuple[int, int]) -> list[int]:
        """What becomes of packets on their way: some missing, twice, or some places later.

        Parameters
        ----------
        packets
            In the order in which they are sent.
        index
            Fixes the chances, together with the seed: which block, and which attempt.
        """
        random = np.random.default_rng([self.seed, *index])
        chance = 1000 * random.random((3, len(packets)))
        place = np.arange(len(packets), dtype=np.float64)
        place[chance[2] < self.packets_late_per_mille] += 1.5 + random.integers(0, 8)
        arrived = chance[0] >= self.packets_lost_per_mille
        times = np.where(arrived, 1 + (chance[1] < self.packets_doubled_per_mille), 0)
        order = np.argsort(place, kind="stable")
        return [packets[index] for index in np.repeat(order, times[order])]
