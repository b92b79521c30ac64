"""Records to timestamps: unwrapped, in order, latencies taken off, and every loss marked at its place."""

import numpy as np
import pytest

from irtiming.gateware.event_model import Latencies
from irtiming.gateware.messages import RecordMessage
from irtiming.gateware.register_map import Channel
from irtiming.instruments.generator.timestamp_stream import TimestampStream

LATENCIES = Latencies(input_cycles=2, output_cycles=1, filter_cycles=5)


def _record(number: int, time: int, channels: int = Channel.CONTROL_SLOT, *, loss: bool = False) -> RecordMessage:
    return RecordMessage(channels=channels, number=number % 2**16, time_ticks=time % 2**48, is_after_loss=loss)


def _stream(*records: RecordMessage, counter: int = 0) -> TimestampStream:
    stream = TimestampStream(counter_ticks=counter)
    for record in records:
        stream.add(record)
    return stream


def _given(stream: TimestampStream):
    return stream.timestamps(clock_frequency_hz=1000, latencies=LATENCIES)


def test_channels_of_one_cycle_are_parted_and_latencies_taken_off():
    """Oracle: by hand; an output's pin changes 1 cycle after the record, an input's 2 + 5 before."""
    both = Channel.CAMERA_TRIGGER | Channel.CAMERA_TRIGGER_DELAYED | Channel.APPLICATION_SLOT
    stream = _stream(
        _record(0, 100, both),
        _record(1, 150, Channel.APPLICATION_OTHER_EDGE),
        _record(2, 160, Channel.CAMERA_INPUT | Channel.SPARE | Channel.CONTROL_SLOT),
    )
    stream.close(records_written=3, records_lost=0)
    found = _given(stream)
    assert found.is_whole
    assert found.clock_frequency_hz == 1000
    assert found.camera_trigger_ticks.tolist() == found.camera_trigger_delayed_ticks.tolist() == [101]
    assert found.application_slot_ticks.tolist() == [93]
    assert found.application_edge_ticks.tolist() == [93, 143]
    assert [s.tolist() for s in (found.control_slot_ticks, found.camera_input_ticks, found.spare_ticks)] == [[153]] * 3


def test_the_counter_is_unwrapped_and_so_are_the_numbers():
    """Oracle: 70 000 steps of 2^33 cycles from just before the wrap on, as Python integers."""
    counter = 2**48 - 5
    times = [counter + 3 + 2**33 * k for k in range(70_000)]
    stream = _stream(*(_record(k, time) for k, time in enumerate(times)), counter=counter)
    stream.close(records_written=70_000, records_lost=0)
    found = _given(stream)
    assert found.is_whole
    assert (found.control_slot_ticks + 7).tolist() == times


@pytest.mark.parametrize(
    ("records", "counted", "lost_after"),
    [
        ([_record(0, 10), _record(1, 20)], (2, 0), []),
        ([_record(0, 10), _record(2, 30), _record(3, 40)], (4, 0), [10]),
        ([_record(1, 20), _record(2, 30)], (3, 0), [5]),
        ([_record(0, 10), _record(1, 50, loss=True)], (2, 7), [10]),
        ([_record(0, 10, loss=True)], (1, 1), [5]),
        ([_record(0, 10), _record(1, 20)], (3, 0), [20]),
        ([_record(0, 10), _record(1, 20)], (2, 1), [20]),
        ([_record(0, 10), _record(1, 20)], (1, 0), [20]),
        ([_record(0, 10), _record(1, 20)], (2 + 2**16, 0), [20]),
        ([_record(0, 10), _record(1, 9), _record(2, 30)], (3, 0), [10]),
        ([_record(0, 10), _record(0, 10), _record(1, 30)], (2, 0), [10]),
        ([_record(0, 10), _record(2, 30), _record(3, 40, loss=True)], (5, 3), [10, 30, 40]),
        ([], (0, 0), []),
        ([], (1, 0), [5]),
    ],
    ids=[
        "whole", "gap", "first gone", "queue full", "queue full at once", "last gone", "lost at the end", "too many",
        "65536 gone", "goes back", "twice", "all kinds", "nothing", "all gone",
    ],
)  # fmt: skip
def test_each_kind_of_loss_is_marked_after_the_last_known_time(records, counted, lost_after):
    """Oracle: by hand; 5 is the counter at ARM, and a record that does not go forward is not believed."""
    stream = _stream(*records, counter=5)
    stream.close(records_written=counted[0], records_lost=counted[1])
    found = _given(stream)
    assert found.lost_after_ticks.tolist() == lost_after
    assert found.is_whole == (not lost_after)
    assert np.all(np.diff(found.control_slot_ticks) > 0)


def test_a_damaged_record_whose_check_sum_fits_is_taken_back():
    """Oracle: by hand; record 1 came with the time 900 in the place of 20, and two records after it say so."""
    stream = _stream(_record(0, 10), _record(1, 900), _record(2, 30), _record(3, 40))
    stream.close(records_written=4, records_lost=0)
    found = _given(stream)
    assert (found.control_slot_ticks + 7).tolist() == [10, 30, 40]
    assert found.lost_after_ticks.tolist() == [10]


def test_until_the_counts_were_compared_the_end_counts_as_lost():
    """Oracle: the rule; nobody knows what came after the last record."""
    stream = _stream(_record(0, 10), counter=5)
    assert _given(stream).lost_after_ticks.tolist() == [10]
    stream.close(records_written=1, records_lost=0)
    assert _given(stream).is_whole


def test_a_stamp_tells_what_was_taken():
    """Oracle: by hand."""
    stream = TimestampStream(counter_ticks=5)
    assert stream.add(_record(0, 10, 0b11)) == (10, Channel.CAMERA_TRIGGER | Channel.CAMERA_TRIGGER_DELAYED, False)
    assert stream.add(_record(1, 4)) is None
    assert stream.add(_record(3, 20)) == (20, Channel.CONTROL_SLOT, True)
    assert len(stream) == 2
