"""The integer model of the trigger generator, against hand-computed cases and a simulator that goes cycle by cycle."""

from collections import deque
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from irtiming.gateware.event_model import (
    INPUT_PINS,
    Events,
    Latencies,
    LineTiming,
    PinChanges,
    Run,
    Settings,
    camera_pin,
    chopper_pin,
    input_events,
    recorded_events,
    recorded_to_edge_ticks,
    settings_at_reset,
    through_queue,
    trigger_ticks,
)
from irtiming.gateware.messages import RecordMessage
from irtiming.gateware.register_map import Channel, Polarity

ALL = int(sum(Channel))
SMALL = Settings(
    chopper_width=2, chopper_period=5, camera_width=3, camera_period=10, camera_count=4, channels=ALL, queue_depth=4,
    bit_cycles=1,
)  # fmt: skip
QUICK = LineTiming(write=0, take=1, between=0)
CONTROL, APPLICATION = Channel.CONTROL_SLOT, Channel.APPLICATION_SLOT


def _pin(*changes: tuple[int, int], initial: int = 0) -> PinChanges:
    cycle, level = np.array(changes, np.int64).reshape(-1, 2).T
    return PinChanges(cycle=cycle, level=level, initial=initial)


def _pairs(events: Events) -> list[tuple[int, int]]:
    return list(zip(events.time_ticks.tolist(), events.channels.tolist(), strict=True))


def test_settings_at_reset_are_those_of_the_paper_on_a_48_mhz_board():
    """Oracle: 300 chopper pulses, 30 triggers a second and 48 cycles per bit of 1 Mbaud, by hand."""
    wanted = Settings(
        chopper_width=80_000, chopper_period=160_000, camera_width=800_000, camera_period=1_600_000, camera_count=1,
        channels=0b0011011, bit_cycles=48,
    )  # fmt: skip
    assert settings_at_reset(48_000_000) == wanted


def test_a_train_with_a_delay_longer_than_its_period():
    """Oracle: t0 + k C and t0 + D + k C by hand; the pin changes a cycle later and keeps its width."""
    wide = replace(SMALL, camera_delay=25)
    nominal, delayed = trigger_ticks(wide, Run(first_trigger_cycle=100))
    assert nominal.tolist() == [100, 110, 120, 130]
    assert delayed.tolist() == [125, 135, 145, 155]
    pin = camera_pin(wide, Run(first_trigger_cycle=100))
    assert pin.cycle.tolist() == [126, 129, 136, 139, 146, 149, 156, 159]
    assert (pin.initial, pin.level.tolist()) == (0, [1, 0] * 4)


def test_no_start_no_trigger():
    """Oracle: an armed generator that is never started makes no edge of its own."""
    assert [t.size for t in trigger_ticks(SMALL, Run())] == [0, 0]
    assert camera_pin(SMALL, Run()).cycle.size == 0


def test_stop_begins_no_pulse_and_cuts_none():
    """Oracle: by hand; cycle 135 is the first that is no longer armed, so its edge is lost and that of 125 whole."""
    wide = replace(SMALL, camera_delay=25, polarity=int(Polarity.CAMERA_OUTPUT))
    run = Run(first_trigger_cycle=100, armed_until_cycle=127)
    assert [t.tolist() for t in trigger_ticks(wide, run)] == [[100, 110, 120], [125]]
    pin = camera_pin(wide, run)
    assert (pin.initial, pin.cycle.tolist(), pin.level.tolist()) == (1, [126, 129], [0, 1])
    assert trigger_ticks(wide, replace(run, armed_until_cycle=135))[1].tolist() == [125]
    assert trigger_ticks(wide, replace(run, armed_until_cycle=136))[1].tolist() == [125, 135]


def test_without_delay_both_trigger_channels_share_a_record():
    """Oracle: the mask of both channels by hand."""
    events = recorded_events(SMALL, {}, run=Run(first_trigger_cycle=7))
    assert _pairs(events) == [(7, 3), (17, 3), (27, 3), (37, 3)]


def test_an_input_edge_is_recorded_three_cycles_after_the_cycle_of_the_change():
    """Oracle: n + 1 + 2 + filter by hand."""
    for filter_cycles in (0, 1, 7):
        time, level = input_events(_pin((50, 1), (90, 0)), filter_cycles)
        assert time.tolist() == [53 + filter_cycles, 93 + filter_cycles]
        assert level.tolist() == [1, 0]


def test_the_filter_drops_what_is_too_short_and_keeps_what_is_just_long_enough():
    """Oracle: by hand; a level of three cycles passes a filter of two and not one of three."""
    glitch = _pin((50, 1), (53, 0))
    assert input_events(glitch, 2)[0].tolist() == [55, 58]
    assert input_events(glitch, 3)[0].tolist() == []
    bouncing = _pin((50, 1), (51, 0), (52, 1), (60, 0), (61, 1), (70, 0))
    assert input_events(bouncing, 2)[0].tolist() == [57, 75]
    within_a_cycle = _pin((50, 1), (50, 0))
    assert input_events(within_a_cycle, 0)[0].tolist() == []


def test_polarity_names_the_edge_and_the_application_gate_has_both():
    """Oracle: by hand; masks of control slot 8, application slot 16 and its other edge 32."""
    inputs = {CONTROL: _pin((10, 1), (20, 0)), APPLICATION: _pin((30, 1), (40, 0))}
    assert _pairs(recorded_events(SMALL, inputs, run=Run())) == [(13, 8), (33, 16), (43, 32)]
    falling = replace(SMALL, polarity=int(Polarity.CONTROL_SLOT | Polarity.APPLICATION_SLOT))
    assert _pairs(recorded_events(falling, inputs, run=Run())) == [(23, 8), (33, 32), (43, 16)]
    masked = replace(SMALL, channels=int(Channel.APPLICATION_SLOT))
    assert _pairs(recorded_events(masked, inputs, run=Run())) == [(33, 16)]


def test_events_of_one_cycle_make_one_record_and_only_armed_cycles_count():
    """Oracle: by hand; a trigger at 23 and edges that arrive with time 23, armed from 23 up to but not including 33."""
    inputs = {CONTROL: _pin((10, 1), (15, 0), (20, 1), (25, 0), (30, 1)), APPLICATION: _pin((20, 1))}
    run = Run(armed_from_cycle=23, armed_until_cycle=33, first_trigger_cycle=23)
    assert _pairs(recorded_events(SMALL, inputs, run=run)) == [(23, 1 | 2 | 8 | 16)]
    assert _pairs(recorded_events(SMALL, inputs, run=replace(run, armed_until_cycle=34)))[-1] == (33, 1 | 2 | 8)


def test_the_chopper_goes_on_from_reset_and_changes_at_the_end_of_a_period():
    """Oracle: by hand; 3 of 10 from cycle 0 on, 2 of 5 from cycle 12 on, so that the period from 10 to 20 is the last old one."""
    pin = chopper_pin([(0, 3, 10), (12, 2, 5)], until_cycle=30)
    assert pin.cycle.reshape(-1, 2).tolist() == [[1, 4], [11, 14], [21, 23], [26, 28]]
    assert (pin.initial, pin.level.tolist()) == (0, [1, 0] * 4)
    exactly = chopper_pin([(0, 3, 10), (20, 2, 5)], until_cycle=21, inverted=True)
    assert exactly.cycle.reshape(-1, 2).tolist() == [[1, 4], [11, 14], [21, 23]]
    assert (exactly.initial, exactly.level.tolist()) == (1, [0, 1] * 3)
    skipped = chopper_pin([(0, 3, 10), (2, 4, 6), (5, 2, 5)], until_cycle=16)
    assert skipped.cycle.reshape(-1, 2).tolist() == [[1, 4], [11, 13], [16, 18]]


@given(n=st.integers(0, 2**40), filter_cycles=st.integers(0, 255))
def test_recorded_times_go_back_to_the_clock_edge_after_the_change(n, filter_cycles):
    """Oracle: a law; an input's edge tick is the cycle after that of the change, an output's the cycle of the change."""
    latencies = Latencies(filter_cycles=filter_cycles)
    time, _ = input_events(_pin((n, 1)), filter_cycles)
    assert recorded_to_edge_ticks(time, CONTROL, latencies=latencies).tolist() == [n + 1]
    made = camera_pin(SMALL, Run(first_trigger_cycle=n)).cycle[::2]
    recorded = trigger_ticks(SMALL, Run(first_trigger_cycle=n))[1]
    for channel in (Channel.CAMERA_TRIGGER, Channel.CAMERA_TRIGGER_DELAYED):
        assert recorded_to_edge_ticks(recorded, channel, latencies=latencies).tolist() == made.tolist()


def test_the_camera_line_seen_by_an_input_comes_three_cycles_and_one_after_its_own_record():
    """Oracle: by hand; 1 cycle of the output and 3 of the input."""
    seen = recorded_events(SMALL, {Channel.CAMERA_INPUT: camera_pin(SMALL, Run(first_trigger_cycle=7))}, run=Run())
    assert _pairs(seen) == [(11, 4), (21, 4), (31, 4), (41, 4)]


def test_a_full_queue_loses_and_the_next_record_says_so():
    """Oracle: by hand; messages of 120 cycles, a queue of one: the third record finds the second waiting, the fourth does not."""
    events = Events(time_ticks=np.array([10, 20, 30, 131, 132]), channels=np.array([1, 2, 4, 8, 16]))
    sent = through_queue(events, replace(SMALL, queue_depth=1), timing=QUICK)
    assert [(m.number, m.time_ticks, m.channels, m.is_after_loss) for m in sent.messages] == [
        (0, 10, 1, False),
        (1, 20, 2, False),
        (2, 131, 8, True),
    ]
    assert sent.start_cycle.tolist() == [11, 131, 251]
    assert (sent.written, sent.lost) == (3, 2)


def test_a_reply_goes_first_at_a_message_boundary():
    """Oracle: by hand; 100 cycles of a reply that waits since cycle 50 push the second record from 131 to 231."""
    events = Events(time_ticks=np.array([10, 20]), channels=np.array([1, 2]))
    assert through_queue(events, SMALL, reply_cycles=[50], timing=QUICK).start_cycle.tolist() == [11, 231]


def test_numbers_and_times_wrap_as_wide_as_their_fields():
    """Oracle: 16 and 48 bits."""
    time = 2**48 - 70_000 * 200 + 200 * np.arange(70_001)
    sent = through_queue(Events(time_ticks=time, channels=np.ones_like(time)), SMALL)
    assert [(m.number, m.time_ticks) for m in (sent.messages[0], sent.messages[65_536], sent.messages[-1])] == [
        (0, 2**48 - 14_000_000), (0, 2**48 - 892_800), (70_000 - 65_536, 0),
    ]  # fmt: skip
    assert (sent.written, sent.lost) == (70_001, 0)


def test_a_run_of_the_paper_has_its_events():
    """Oracle: counts by hand (1000 triggers with a delay, 9900 slots, 198 edges on the slots)."""
    paper = replace(settings_at_reset(48_000_000), camera_period=1_584_000, camera_count=1000, camera_delay=1_200_000)
    slots = 160_000 * np.arange(9_900)
    cycle = np.column_stack([slots, slots + 80_000]).ravel()
    level = np.tile([1, 0], slots.size)
    edges = slots[::50]
    inputs = {
        CONTROL: PinChanges(cycle=cycle, level=level),
        APPLICATION: PinChanges(cycle=np.column_stack([edges, edges + 4_000_000]).ravel(), level=np.tile([1, 0], 198)),
    }
    events = recorded_events(paper, inputs, run=Run(first_trigger_cycle=500))
    sent = through_queue(events, paper)
    assert (sent.written, sent.lost) == (2000 + 9900, 0)
    assert np.count_nonzero(events.channels == CONTROL | APPLICATION) == 198


def _measurement(seed: int):
    """Small settings, a run, levels of each pin and replies, within some hundred cycles: events crowd and the queue loses."""
    random = np.random.default_rng(seed)

    def one_of(lowest: int, highest: int) -> int:
        return int(random.integers(lowest, highest + 1))

    period = one_of(2, 40)
    scheme = replace(
        SMALL,
        camera_period=period,
        camera_width=one_of(1, period - 1),
        camera_count=one_of(1, 12),
        camera_delay=one_of(0, 90),
        polarity=one_of(0, int(sum(Polarity))),
        channels=one_of(0, ALL) | one_of(0, ALL),
        filter=one_of(0, 5),
        queue_depth=one_of(1, 3),
    )
    begin = one_of(0, 60)
    start = one_of(begin, begin + 60)
    stops = (
        begin + one_of(0, 400),
        start + period * one_of(0, 12),
        start + scheme.camera_delay + period * one_of(0, 12),
    )
    run = Run(
        armed_from_cycle=begin,
        armed_until_cycle=stops[one_of(0, 2)],
        first_trigger_cycle=start if one_of(0, 7) else None,
    )
    inputs = {}
    for pin in INPUT_PINS:
        cycle = 10 + np.cumsum(random.integers(0, 9, 60))
        inputs[pin] = PinChanges(cycle=cycle, level=random.integers(0, 2, 60), initial=one_of(0, 1))
    return scheme, run, inputs, sorted(one_of(0, 600) for _ in range(one_of(0, 3)))


@pytest.mark.parametrize("seeds", [range(first, first + 50) for first in range(0, 300, 50)], ids=str)
def test_the_model_is_what_a_machine_that_goes_cycle_by_cycle_does(seeds):
    """Oracle: the machine below: counters, shift registers and a queue, one cycle at a time."""
    for seed in seeds:
        _compare(*_measurement(seed))


def _compare(scheme, run, inputs, replies):
    events = recorded_events(scheme, inputs, run=run)
    timing = LineTiming(write=1, take=2, between=3)
    sent = through_queue(events, scheme, reply_cycles=replies, timing=timing)
    records, levels, messages, starts, lost = _machine(scheme, run, inputs, replies, timing)
    assert _pairs(events) == records
    assert (list(sent.messages), sent.start_cycle.tolist(), sent.lost) == (messages, starts, lost)
    assert _level_in_each_cycle(camera_pin(scheme, run), 600) == levels[:600]


def _level_in_each_cycle(pin: PinChanges, cycles: int) -> list[int]:
    level, there = pin.initial, []
    changes = dict(zip(pin.cycle.tolist(), pin.level.tolist(), strict=True))
    for cycle in range(cycles):
        level = changes.get(cycle, level)
        there.append(level)
    return there


def _machine(scheme, run, inputs, replies, timing):
    """Records, level of the camera's output in each cycle, messages with their starts, and the number of lost ones."""
    lines = {pin: _level_in_each_cycle(changes, 3_000) for pin, changes in inputs.items()}
    held = {pin: deque([changes.initial] * 3, maxlen=3) for pin, changes in inputs.items()}
    accepted, since = {pin: changes.initial for pin, changes in inputs.items()}, dict.fromkeys(inputs, 0)
    until = {0: None, 1: None}  # cycles to the next nominal and the next delayed edge
    left = {0: scheme.camera_count, 1: scheme.camera_count}
    idle, high = int(bool(scheme.polarity & Polarity.CAMERA_OUTPUT)), 0
    records, levels, messages, starts = [], [], [], []
    written_soon, queue, replies = deque(), deque(), deque(replies)
    busy, lost, after_loss = 0, 0, False
    for cycle in range(3_000):
        levels.append(1 - idle if high else idle)
        high = max(0, high - 1)
        armed, mask = run.armed_from_cycle <= cycle < run.armed_until_cycle, 0
        if cycle == run.first_trigger_cycle:
            until = {0: 0, 1: scheme.camera_delay}
        for edge in (0, 1):
            if until[edge] == 0 and left[edge] and cycle < run.armed_until_cycle:
                mask |= (Channel.CAMERA_TRIGGER, Channel.CAMERA_TRIGGER_DELAYED)[edge]
                left[edge] -= 1
                until[edge] = scheme.camera_period
                high = scheme.camera_width if edge == 1 else high
            until[edge] = None if until[edge] is None else until[edge] - 1
        for pin in inputs:
            held[pin].append(lines[pin][cycle - 1] if cycle else inputs[pin].initial)
            since[pin] = since[pin] + 1 if held[pin][0] != accepted[pin] else 0
            if since[pin] > scheme.filter:
                accepted[pin], since[pin] = held[pin][0], 0
                if accepted[pin] != bool(scheme.polarity & pin):
                    mask |= pin
                elif pin == APPLICATION:
                    mask |= Channel.APPLICATION_OTHER_EDGE
        mask &= scheme.channels
        if armed and mask:
            records.append((cycle, int(mask)))
            written_soon.append((cycle + timing.write, cycle, int(mask)))
        if busy:
            busy -= 1
        elif replies and replies[0] <= cycle:
            replies.popleft()
            busy = 10 * 10 * scheme.bit_cycles + timing.between - 1
        elif queue and queue[0][0] + timing.take <= cycle:
            messages.append(queue.popleft()[1])
            starts.append(cycle)
            busy = 12 * 10 * scheme.bit_cycles + timing.between - 1
        if written_soon and written_soon[0][0] == cycle:
            _, time, channels = written_soon.popleft()
            if len(queue) == scheme.queue_depth:
                lost, after_loss = lost + 1, True
            else:
                message = RecordMessage(
                    channels=channels, number=len(messages) + len(queue), time_ticks=time, is_after_loss=after_loss
                )
                queue.append((cycle, message))
                after_loss = False
    return records, levels, messages, starts, lost
