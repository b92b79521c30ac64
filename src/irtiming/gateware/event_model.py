"""What the trigger generator must do, in integers: the reference that circuit, driver and twin are held against.

Written from the description of the generator, not from its circuit. A cycle is named by the counter during it. A pin that
changes during cycle n has its new level at the clock edge that begins cycle n + 1; an output that changes with the edge that
begins cycle n counts as changed during cycle n. So the changes of an output can be fed into an input as they are.

Model of one measurement, from ARM to STOP::

    events = recorded_events(settings, inputs, run=Run(armed_from_cycle=..., first_trigger_cycle=...))
    sent = through_queue(events, settings)
"""

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias, final

import numpy as np

from irtiming.gateware.messages import BITS_PER_BYTE, RECORD_BYTES, REPLY_BYTES, RecordMessage
from irtiming.gateware.register_map import (
    ADDRESS,
    BAUD,
    INPUT_LATENCY_CYCLES,
    OUTPUT_LATENCY_CYCLES,
    QUEUE_DEPTH,
    REGISTERS,
    Channel,
    Polarity,
    at_reset,
)
from irtiming.records.arrays import Ticks

COUNTER_CYCLES = 2**48
"""After so many cycles the counter begins again at 0."""

OUTPUT_CHANNELS = Channel.CAMERA_TRIGGER | Channel.CAMERA_TRIGGER_DELAYED
"""Channels of edges that the generator makes itself; all others are input pins."""

INPUT_PINS = (Channel.CAMERA_INPUT, Channel.CONTROL_SLOT, Channel.APPLICATION_SLOT, Channel.SPARE)
"""Channels that name a pin; APPLICATION_OTHER_EDGE is the other edge of APPLICATION_SLOT."""

_POLARITY = {pin: Polarity[pin.name or ""] for pin in INPUT_PINS}


@final
@dataclass(frozen=True, kw_only=True)
class Settings:
    """Registers of the generator that matter to its events; lengths in cycles, masks as in the register map."""

    chopper_width: int
    chopper_period: int
    camera_width: int
    camera_period: int
    camera_count: int
    camera_delay: int = 0
    polarity: int = 0
    channels: int
    filter: int = 0
    queue_depth: int = QUEUE_DEPTH
    bit_cycles: int


@final
@dataclass(frozen=True, kw_only=True)
class Latencies:
    """Cycles between what a pin does and what is recorded: as the registers of a device tell them."""

    input_cycles: int = INPUT_LATENCY_CYCLES
    output_cycles: int = OUTPUT_LATENCY_CYCLES
    filter_cycles: int = 0


@final
@dataclass(frozen=True, kw_only=True)
class Run:
    """One measurement: recording from cycle ``armed_from_cycle`` to the one before ``armed_until_cycle``.

    ``first_trigger_cycle`` is t0, the recorded time of the first nominal trigger; None: no START.
    """

    armed_from_cycle: int = 0
    armed_until_cycle: int = COUNTER_CYCLES
    first_trigger_cycle: int | None = None


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PinChanges:
    """Level of one pin over time, each shape (n_change,): from ``initial`` it goes to ``level[i]`` during ``cycle[i]``.

    Cycles never fall. Before the first of them the level has been ``initial`` for longer than any filter.
    """

    cycle: Ticks
    level: Ticks
    initial: int = 0


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Events:
    """Cycles with events, each shape (n_record,): rising times, and the channels of each as a mask."""

    time_ticks: Ticks
    channels: Ticks


@final
@dataclass(frozen=True, kw_only=True)
class LineTiming:
    """Cycles that the circuit takes around its queue and its line.

    A record of time t is written in cycle t + ``write`` and lost if the queue is full then. An idle line begins with
    it in cycle t + ``write`` + ``take``; from that cycle on its place is free. Between the last stop bit of a
    message and the first cycle of the next lie ``between`` cycles.
    """

    write: int
    take: int
    between: int


CIRCUIT = LineTiming(write=1, take=2, between=0)
"""Of the circuit in this folder."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Sent:
    """What went over the line: ``start_cycle`` is the first cycle of each message's first start bit, shape (n_record,)."""

    messages: tuple[RecordMessage, ...]
    start_cycle: Ticks
    written: int
    lost: int


ChopperCommits: TypeAlias = Sequence[tuple[int, int, int]]
"""First cycle in which they hold, width and period, in order of time; the first one at cycle 0 or before."""


def settings_at_reset(clock_frequency_hz: int) -> Settings:
    """Settings of a device that has just been switched on.

    Parameters
    ----------
    clock_frequency_hz
        Of its board.
    """
    value = {register.name: at_reset(register, clock_frequency_hz) for register in REGISTERS}
    names = {name.upper() for name in Settings.__dataclass_fields__} & ADDRESS.keys()
    return Settings(bit_cycles=round(clock_frequency_hz / BAUD), **{name.lower(): value[name] for name in names})


def recorded_to_edge_ticks(recorded_ticks: Ticks, channel: Channel, *, latencies: Latencies) -> Ticks:
    """The clock edge at which a pin had changed, from the time that was recorded.

    Of an input, the first clock cycle after the change; of the generator's own outputs, the cycle that begins with
    the change.

    Parameters
    ----------
    recorded_ticks
        Times of one channel, any shape.
    channel
        Which one.
    latencies
        Of the device that recorded them.

    Returns
    -------
    Ticks of the same counter, same shape.
    """
    if channel & OUTPUT_CHANNELS:
        return recorded_ticks + latencies.output_cycles
    return recorded_ticks - latencies.input_cycles - latencies.filter_cycles


def trigger_ticks(settings: Settings, run: Run) -> tuple[Ticks, Ticks]:
    """Recorded times of the train's nominal and of its delayed edges that come before STOP.

    Returns
    -------
    t0 + k C and t0 + D + k C, shapes (n,) and (m,) with m <= n <= camera_count.
    """
    if run.first_trigger_cycle is None:
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    nominal = run.first_trigger_cycle + settings.camera_period * np.arange(settings.camera_count, dtype=np.int64)
    delayed = nominal + settings.camera_delay
    return nominal[nominal < run.armed_until_cycle], delayed[delayed < run.armed_until_cycle]


def camera_pin(settings: Settings, run: Run) -> PinChanges:
    """Level of the camera's output; a pulse that STOP finds high keeps its width."""
    _, delayed = trigger_ticks(settings, run)
    begin = delayed + OUTPUT_LATENCY_CYCLES
    return _pulses(begin, begin + settings.camera_width, inverted=bool(settings.polarity & Polarity.CAMERA_OUTPUT))


def chopper_pin(commits: ChopperCommits, *, until_cycle: int, inverted: bool = False) -> PinChanges:
    """Level of the chopper's reference from reset on, for all periods that begin before ``until_cycle``.

    Parameters
    ----------
    commits
        Widths and periods; those that hold when a period begins are the period's.
    until_cycle
        Where to end.
    inverted
        POLARITY of the output: it idles high.
    """
    begins: list[Ticks] = []
    ends: list[Ticks] = []
    at = 0
    for (_, width, period), following in zip(commits, [*(c[0] for c in commits[1:]), until_cycle], strict=True):
        count = max(0, -(-(min(following, until_cycle) - at) // period))
        begins.append(at + period * np.arange(count, dtype=np.int64))
        ends.append(begins[-1] + width)
        at += count * period
    begin, end = np.concatenate(begins), np.concatenate(ends)
    return _pulses(begin + OUTPUT_LATENCY_CYCLES, end + OUTPUT_LATENCY_CYCLES, inverted=inverted)


def input_events(pin: PinChanges, filter_cycles: int) -> tuple[Ticks, Ticks]:
    """Edges of one pin that pass the glitch filter.

    Returns
    -------
    Times with which they are recorded and the level after each, shapes (n,).
    """
    seen = np.append(pin.cycle[1:] != pin.cycle[:-1], True) if pin.cycle.size else np.empty(0, dtype=bool)
    cycle, level = _changing(pin.cycle[seen], pin.level[seen], pin.initial)  # a clock edge sees the last of one cycle
    length = np.append(np.diff(cycle), COUNTER_CYCLES)[: cycle.size]
    steady = length > filter_cycles
    cycle, level = _changing(cycle[steady], level[steady], pin.initial)  # after a glitch the level is the old one
    return cycle + 1 + INPUT_LATENCY_CYCLES + filter_cycles, level


def recorded_events(settings: Settings, inputs: Mapping[Channel, PinChanges], *, run: Run) -> Events:
    """All events of one measurement, one entry for each cycle that has any.

    Parameters
    ----------
    settings
        Of the generator.
    inputs
        What each of `INPUT_PINS` does; one that is left out stays as it is.
    run
        When is recorded, and when the train starts.
    """
    nominal, delayed = trigger_ticks(settings, run)
    times, masks = [nominal, delayed], [Channel.CAMERA_TRIGGER, Channel.CAMERA_TRIGGER_DELAYED]
    for pin, changes in inputs.items():
        time, level = input_events(changes, settings.filter)
        counts = level.astype(bool) != bool(settings.polarity & _POLARITY[pin])
        times.append(time[counts])
        masks.append(pin)
        if pin == Channel.APPLICATION_SLOT:
            times.append(time[~counts])
            masks.append(Channel.APPLICATION_OTHER_EDGE)
    mask = np.concatenate(
        [np.full(t.size, m & settings.channels, dtype=np.int64) for t, m in zip(times, masks, strict=True)]
    )
    time = np.concatenate(times)
    kept = (mask != 0) & (time >= run.armed_from_cycle) & (time < run.armed_until_cycle)
    return _by_cycle(time[kept], mask[kept])


def through_queue(
    events: Events, settings: Settings, *, reply_cycles: Sequence[int] = (), timing: LineTiming = CIRCUIT
) -> Sent:
    """What the line carries of these events, and what the queue loses.

    Parameters
    ----------
    events
        Of one measurement.
    settings
        Depth of the queue and length of a bit.
    reply_cycles
        Cycles from which on a reply to a command waits for the line, rising; it goes before records.
    timing
        Of the circuit.

    Returns
    -------
    Messages in order, each with its first cycle on the line; records written and lost.
    """
    byte = BITS_PER_BYTE * settings.bit_cycles
    record, reply = RECORD_BYTES * byte + timing.between, REPLY_BYTES * byte + timing.between
    replies, waiting = deque(reply_cycles), deque[int]()
    messages: list[RecordMessage] = []
    starts: list[int] = []
    line_free, lost, after_loss = 0, 0, False
    for time, channels in zip(events.time_ticks.tolist(), events.channels.tolist(), strict=True):
        written = time + timing.write
        while waiting and waiting[0] <= written:
            waiting.popleft()
        if len(waiting) == settings.queue_depth:
            lost, after_loss = lost + 1, True
            continue
        start = max(written + timing.take, line_free)
        while replies and replies[0] <= start:
            line_free = max(replies.popleft(), line_free) + reply
            start = max(start, line_free)
        line_free = start + record
        waiting.append(start)
        starts.append(start)
        number, time = len(messages) % 2**16, time % COUNTER_CYCLES
        messages.append(RecordMessage(channels=channels, number=number, time_ticks=time, is_after_loss=after_loss))
        after_loss = False
    return Sent(messages=tuple(messages), start_cycle=np.array(starts, np.int64), written=len(messages), lost=lost)


def _pulses(begin: Ticks, end: Ticks, *, inverted: bool) -> PinChanges:
    """Pin that is active from each ``begin`` to the ``end`` after it."""
    level = np.tile(np.array([1, 0], np.int64), begin.size) ^ int(inverted)
    return PinChanges(cycle=np.column_stack([begin, end]).ravel(), level=level, initial=int(inverted))


def _changing(cycle: Ticks, level: Ticks, initial: int) -> tuple[Ticks, Ticks]:
    """Entries whose level differs from the one before."""
    differs = np.diff(level, prepend=initial) != 0
    return cycle[differs], level[differs]


def _by_cycle(time: Ticks, mask: Ticks) -> Events:
    """One entry per cycle, with the masks of all its events together."""
    order = np.argsort(time, kind="stable")
    time, mask = time[order], mask[order]
    first = np.flatnonzero(np.diff(time, prepend=-1)) if time.size else np.empty(0, np.intp)
    return Events(time_ticks=time[first], channels=np.bitwise_or.reduceat(mask, first) if time.size else mask)
