"""From records as they arrive to the timestamps of each channel: unwrapped, in order, and every loss marked."""

from array import array
from typing import NamedTuple, final

import numpy as np

from irtiming.gateware.event_model import COUNTER_CYCLES, Latencies, recorded_to_edge_ticks
from irtiming.gateware.messages import RecordMessage
from irtiming.gateware.register_map import Channel
from irtiming.records.arrays import Ticks, read_only
from irtiming.records.timestamps import Timestamps

_NUMBERS = 2**16
"""Records are numbered modulo this."""


class Stamp(NamedTuple):
    """Events of one cycle: unwrapped time as it was recorded, and their channels."""

    ticks: int
    channels: Channel
    is_after_loss: bool


@final
class TimestampStream:
    """Records of one measurement, from ARM on.

    A loss shows in five ways: a gap in the numbers, the loss bit, a time that does not go forward, fewer records than the
    device says it wrote, and its count of lost ones. A record whose time does not go forward is not believed; but if the next
    one says so too, the one before them is not, for one damaged record in 65 536 has a check sum that fits.

    Until `close` has compared the counts, the end counts as lost. ``counter_ticks`` is the device's counter shortly
    before ARM: times are unwrapped from there.
    """

    def __init__(self, *, counter_ticks: int) -> None:
        self._begin_ticks = counter_ticks
        self._ticks, self._numbers, self._channels = array("q"), array("q"), array("q")  # for NumPy to copy at once
        self._lost_after: list[int] = []
        self._doubter: RecordMessage | None = None  # the record just before, if it was not believed
        self._saw_full_queue = False
        self._is_closed = False

    def __len__(self) -> int:
        """Records that were taken so far."""
        return len(self._ticks)

    def add(self, record: RecordMessage) -> Stamp | None:
        """Take the next record; None where it is not believed, which counts as a loss."""
        doubter, self._doubter = self._doubter, None
        if not self._forward(record):
            self._mark_loss()
            if doubter is None or not self._overrules(doubter, record):
                self._doubter = record
                return None
            self._forget_last()
            self._take(doubter)
        return self._take(record)

    def _take(self, record: RecordMessage) -> Stamp:
        gap = (record.number - self._next_number) % _NUMBERS
        if gap or record.is_after_loss:
            self._mark_loss()
        self._saw_full_queue |= record.is_after_loss
        self._numbers.append(self._next_number + gap)
        self._ticks.append(self._last_ticks + self._forward(record))
        self._channels.append(record.channels)
        return Stamp(self._last_ticks, Channel(record.channels), bool(gap) or record.is_after_loss)

    def close(self, *, records_written: int, records_lost: int) -> None:
        """Compare with what the device counted, after the last record."""
        if records_written != self._next_number or (records_lost and not self._saw_full_queue):
            self._mark_loss()
        self._is_closed = True

    def timestamps(self, *, clock_frequency_hz: int, latencies: Latencies) -> Timestamps:
        """Times of the edges at the pins, channel by channel.

        Parameters
        ----------
        clock_frequency_hz, latencies
            Of the device.
        """
        ticks = np.array(self._ticks, dtype=np.int64)
        channels = np.array(self._channels, dtype=np.int64)

        def at_pin(channel: Channel) -> Ticks:
            return recorded_to_edge_ticks(ticks[(channels & channel) != 0], channel, latencies=latencies)

        lost_after = self._lost_after if self._is_closed else [*self._lost_after, self._last_ticks]
        edges = np.concatenate([at_pin(Channel.APPLICATION_SLOT), at_pin(Channel.APPLICATION_OTHER_EDGE)])
        return Timestamps(
            clock_frequency_hz=clock_frequency_hz,
            camera_trigger_ticks=read_only(at_pin(Channel.CAMERA_TRIGGER)),
            camera_trigger_delayed_ticks=read_only(at_pin(Channel.CAMERA_TRIGGER_DELAYED)),
            control_slot_ticks=read_only(at_pin(Channel.CONTROL_SLOT)),
            application_slot_ticks=read_only(at_pin(Channel.APPLICATION_SLOT)),
            application_edge_ticks=read_only(np.sort(edges)),
            camera_input_ticks=read_only(at_pin(Channel.CAMERA_INPUT)),
            spare_ticks=read_only(at_pin(Channel.SPARE)),
            lost_after_ticks=read_only(np.unique(np.array(lost_after, dtype=np.int64))),
        )

    @property
    def _last_ticks(self) -> int:
        return self._ticks[-1] if self._ticks else self._begin_ticks

    @property
    def _next_number(self) -> int:
        return self._numbers[-1] + 1 if self._numbers else 0

    def _forward(self, record: RecordMessage) -> int:
        """Ticks from the last record; 0 where time does not go forward."""
        return _apart(self._last_ticks, record.time_ticks)

    def _overrules(self, doubter: RecordMessage, record: RecordMessage) -> bool:
        """Whether two records that follow each other say that the last one's time cannot be."""
        before = [self._begin_ticks, *self._ticks[-2:-1]][-1]
        return bool(
            self._ticks and _apart(before, doubter.time_ticks) and _apart(doubter.time_ticks, record.time_ticks)
        )

    def _forget_last(self) -> None:
        """Take back the last record: the one after it says that its time cannot be."""
        del self._ticks[-1], self._numbers[-1], self._channels[-1]
        self._lost_after = [ticks for ticks in self._lost_after if ticks <= self._last_ticks]
        self._mark_loss()

    def _mark_loss(self) -> None:
        """Note that something was lost after the last record."""
        self._lost_after.append(self._last_ticks)


def _apart(ticks: int, later_ticks: int) -> int:
    """Cycles from one value of the counter to a later one; 0 where it is not later."""
    forward = (later_ticks - ticks) % COUNTER_CYCLES
    return forward if forward < COUNTER_CYCLES // 2 else 0
