"""The wheel while frames are recorded: each turn must last as long as the one of its reference."""

from typing import final

import numpy as np

from irtiming.acquire.trigger_train import SPEED_TOLERANCE
from irtiming.records.timestamps import Timestamps
from irtiming.records.trigger_plan import TriggerScheme
from irtiming.units import readable_time


@final
class WheelWatch:
    """Looks at control slots as they arrive. Slot by slot a wheel is irregular, turn by turn it is not."""

    def __init__(self, scheme: TriggerScheme) -> None:
        self._scheme = scheme
        self._seen = 0

    def complaint(self, timestamps: Timestamps) -> str | None:
        """What is wrong with the slots that are new, None while they come as they must.

        Where timestamps were lost, nothing is concluded.

        Parameters
        ----------
        timestamps
            All so far.
        """
        slots, per_turn = timestamps.control_slot_ticks, self._scheme.control_slots
        turn, clock = self._scheme.turn_period_ticks, timestamps.clock_frequency_hz
        new = slots[max(0, self._seen - per_turn) :]
        self._seen = slots.size
        lost = timestamps.lost_after_ticks
        latest = max((int(ticks[-1]) for ticks in (timestamps.camera_trigger_ticks, slots) if ticks.size), default=0)
        if np.any(lost[:-1] >= (new[0] if new.size else 0)):
            return None  # the last entry only says that the run is not over
        since = latest - int(slots[-1]) if slots.size else 0
        if slots.size and since > turn // 2:
            return f"no control slot came for {readable_time(since / clock)}: the wheel stands, or its light gate sees nothing"
        if new.size <= per_turn:
            return None
        turns = new[per_turn:] - new[:-per_turn]
        worst = int(turns[int(np.argmax(np.abs(turns - turn)))])
        if abs(worst / turn - 1) <= SPEED_TOLERANCE:
            return None
        return (
            f"the wheel lost its lock: a turn lasted {readable_time(worst / clock)}, it must last "
            f"{readable_time(turn / clock)}; check the chopper and its reference line"
        )
