"""What a trigger generator stamped during one run: times of its own triggers and of the wheel's edges."""

from dataclasses import dataclass
from typing import final

from irtiming.records.arrays import Ticks
from irtiming.records.short_repr import short_repr


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Timestamps:
    """One run's timestamps: values of one unwrapped counter, each stream in order, shapes (n_edge,).

    Times are those of the edges at the pins: the latencies of the device are taken off. ``camera_trigger_ticks`` are
    nominal triggers, ``camera_trigger_delayed_ticks`` the edges that the camera got. ``lost_after_ticks`` has one entry
    for every hole: the last time that is known before records were lost; empty if nothing was.
    """

    __repr__ = short_repr

    clock_frequency_hz: int
    camera_trigger_ticks: Ticks
    camera_trigger_delayed_ticks: Ticks
    control_slot_ticks: Ticks
    application_slot_ticks: Ticks
    application_edge_ticks: Ticks
    camera_input_ticks: Ticks
    spare_ticks: Ticks
    lost_after_ticks: Ticks

    @property
    def is_whole(self) -> bool:
        """Whether every record of the run arrived."""
        return self.lost_after_ticks.size == 0
