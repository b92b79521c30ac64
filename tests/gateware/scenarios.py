"""Measurements of the compiled circuit, beside what the integer model says of them.

Read by the tests and by benchmarks/gateware_scenarios.py. A command that begins in cycle b (its first start bit) does its
work in a cycle that follows from the length of a bit: `done_cycle`. With that the model has no free number: records, their
first cycles on the line, losses and both output pins must be equal.
"""

from dataclasses import dataclass, fields

import numpy as np

from irtiming.gateware.compiled import CompiledCircuit, Outcome
from irtiming.gateware.event_model import (
    INPUT_PINS,
    PinChanges,
    Run,
    Sent,
    Settings,
    camera_pin,
    chopper_pin,
    recorded_events,
    settings_at_reset,
    through_queue,
    trigger_ticks,
)
from irtiming.gateware.messages import (
    CommandMessage,
    RecordMessage,
    ReplyMessage,
    pack_command,
    unpack_record,
    unpack_reply,
)
from irtiming.gateware.register_map import ADDRESS, Channel, Command, Polarity, Refusal, Status

ALL = int(sum(Channel))
FIRST_CYCLE = 20
NAMES = (
    "polarity", "channels", "filter", "chopper_width", "chopper_period", "camera_width", "camera_period",
    "camera_count", "camera_delay",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """Settings are written, then ARM, START and STOP begin in these cycles, with reads of registers between.

    ``started`` is None for a measurement without triggers. All lists are in order.
    """

    settings: Settings
    armed: int
    started: int | None
    stopped: int
    reads: tuple[int, ...]
    inputs: dict[Channel, PinChanges]


@dataclass(frozen=True, kw_only=True)
class Played:
    """What a circuit did."""

    outcome: Outcome
    replies: list[ReplyMessage]
    records: list[RecordMessage]
    record_starts: list[int]


def command_cycles(bit_cycles: int) -> int:
    """Length of a command on the line."""
    return 100 * bit_cycles


def done_cycle(begin: int, bit_cycles: int) -> int:
    """Cycle in which a command arms, starts or stops; from the next one on it holds.

    The middle of the tenth stop bit, 3 cycles into the receiver, 5 through the registers.
    """
    return begin + 99 * bit_cycles + bit_cycles // 2 + 3 + 5


def reply_cycle(begin: int, bit_cycles: int) -> int:
    """Cycle in which the reply to a command begins, if the line is free."""
    return done_cycle(begin, bit_cycles) + 3


def write(name: str, value: int) -> bytes:
    """Command that writes a register."""
    return pack_command(CommandMessage(operation=1, tag=0, address=ADDRESS[name], value=value))


def read(name: str) -> bytes:
    """Command that reads a register."""
    return pack_command(CommandMessage(operation=0, tag=1, address=ADDRESS[name]))


def commands(scenario: Scenario) -> list[tuple[int, bytes]]:
    """Cycle in which each command of the scenario begins, and its bytes; settings come back to back."""
    length = command_cycles(scenario.settings.bit_cycles)
    found = [
        (FIRST_CYCLE + length * i, write(name.upper(), getattr(scenario.settings, name)))
        for i, name in enumerate(NAMES)
    ]
    orders = [(scenario.armed, Command.ARM), (scenario.started, Command.START), (scenario.stopped, Command.STOP)]
    found += [(at, write("COMMAND", order)) for at, order in orders if at is not None]
    return sorted(found + [(at, read("COUNTER_LOW")) for at in scenario.reads])


def end_cycle(scenario: Scenario) -> int:
    """First cycle in which every record has been sent and the last pulse is over."""
    settings = scenario.settings
    drained = (settings.queue_depth + 2 + len(scenario.reads)) * 120 * settings.bit_cycles
    return scenario.stopped + 2 * command_cycles(settings.bit_cycles) + max(drained, settings.camera_width)


def play(scenario: Scenario, circuit: CompiledCircuit) -> Played:
    """Let a circuit that was just reset play the scenario, then read STATUS, RECORDS_WRITTEN and RECORDS_LOST."""
    end, length = end_cycle(scenario), command_cycles(scenario.settings.bit_cycles)
    last = [(end + 2 * length * i, read(name)) for i, name in enumerate(("STATUS", "RECORDS_WRITTEN", "RECORDS_LOST"))]
    outcome = circuit.run(end + 7 * length, inputs=scenario.inputs, commands=dict([*commands(scenario), *last]))
    replies, records, starts, at = [], [], [], 0
    while at < len(outcome.line):
        size = 10 if outcome.line[at] == 0x5A else 12
        message = outcome.line[at : at + size]
        unpacked = unpack_reply(message) or unpack_record(message)
        assert unpacked is not None, f"byte {at} begins no message: {message!r}"
        if isinstance(unpacked, ReplyMessage):
            replies.append(unpacked)
        else:
            records.append(unpacked)
            starts.append(int(outcome.line_cycle[at]))
        at += size
    return Played(outcome=outcome, replies=replies, records=records, record_starts=starts)


def expected(scenario: Scenario) -> tuple[Run, Sent]:
    """What the model says."""
    bit = scenario.settings.bit_cycles
    run = Run(
        armed_from_cycle=done_cycle(scenario.armed, bit) + 1,
        armed_until_cycle=done_cycle(scenario.stopped, bit) + 1,
        first_trigger_cycle=None if scenario.started is None else done_cycle(scenario.started, bit) + 1,
    )
    events = recorded_events(scenario.settings, scenario.inputs, run=run)
    replies = [reply_cycle(begin, bit) for begin, _ in commands(scenario)]
    return run, through_queue(events, scenario.settings, reply_cycles=replies)


def assert_equal(scenario: Scenario, played: Played) -> Sent:
    """Hold what the circuit did against the model, message by message and pin by pin."""
    run, sent = expected(scenario)
    settings, bit = scenario.settings, scenario.settings.bit_cycles
    assert [reply.refusal for reply in played.replies] == [Refusal.NONE] * len(played.replies)
    assert played.records == list(sent.messages)
    assert played.record_starts == sent.start_cycle.tolist()
    _, delayed = trigger_ticks(settings, run)
    status = Status.QUEUE_EMPTY | (Status.LOSS if sent.lost else Status(0))
    if delayed.size == settings.camera_count:
        status |= Status.FINISHED
    assert [reply.value for reply in played.replies[-3:]] == [status, sent.written, sent.lost]
    settled = reply_cycle(FIRST_CYCLE, bit)  # POLARITY comes first: from here on the outputs idle as they should
    end = end_cycle(scenario)
    commit = done_cycle(FIRST_CYCLE + NAMES.index("chopper_period") * command_cycles(bit), bit)
    reset = settings_at_reset(bit * 1_000_000)
    commits = [
        (0, reset.chopper_width, reset.chopper_period), (commit, settings.chopper_width, settings.chopper_period),
    ]  # fmt: skip
    inverted = bool(settings.polarity & Polarity.CHOPPER_OUTPUT)
    for done, wanted in (
        (played.outcome.camera_out, camera_pin(settings, run)),
        (played.outcome.chopper_out, chopper_pin(commits, until_cycle=end, inverted=inverted)),
    ):
        assert _within(done, settled, end) == _within(wanted, settled, end)
    return sent


def _within(pin: PinChanges, first: int, until: int) -> list[tuple[int, int]]:
    inside = (pin.cycle >= first) & (pin.cycle < until)
    return list(zip(pin.cycle[inside].tolist(), pin.level[inside].tolist(), strict=True))


def random_scenario(rng: np.random.Generator, *, bit_cycles: int, queue_depth: int) -> Scenario:
    """Any settings with short periods; edges that coincide, glitches, bursts beyond what the queue holds."""
    settings = _random_settings(rng, bit_cycles=bit_cycles, queue_depth=queue_depth)
    length = command_cycles(bit_cycles)
    armed = FIRST_CYCLE + length * len(NAMES) + int(rng.integers(0, 300))
    gap = 125 * bit_cycles  # longer than a record: a command that comes while a reply waits would be dropped
    started = armed + gap + int(rng.integers(0, 300)) if rng.random() < 0.9 else None
    first_read = (started or armed) + gap
    stopped = first_read + int(rng.integers(0, 4000))
    reads = tuple(range(first_read, stopped - gap, gap + int(rng.integers(0, 1000)))) if rng.random() < 0.5 else ()
    triggers = np.empty(0, np.int64)
    if started is not None:
        run = Run(first_trigger_cycle=done_cycle(started, bit_cycles) + 1)
        triggers = (
            np.concatenate(trigger_ticks(settings, run)) - 3 - settings.filter
        )  # a pin that changes then coincides
    window = (armed, stopped + 2 * length)
    inputs = {pin: _random_pin(rng, window, triggers, filter_cycles=settings.filter) for pin in INPUT_PINS}
    return Scenario(settings=settings, armed=armed, started=started, stopped=stopped, reads=reads, inputs=inputs)


def _random_settings(rng: np.random.Generator, *, bit_cycles: int, queue_depth: int) -> Settings:
    camera_period, chopper_period = (int(period) for period in np.exp(rng.uniform(np.log(2), np.log(1000), 2)))
    near = int(rng.choice([0, 1, camera_period - 1, camera_period, camera_period + 1, 3 * camera_period]))
    return Settings(
        chopper_width=int(rng.integers(1, chopper_period)),
        chopper_period=chopper_period,
        camera_width=int(rng.choice([1, camera_period - 1, rng.integers(1, camera_period)])),
        camera_period=camera_period,
        camera_count=int(rng.integers(1, 20)),
        camera_delay=near if rng.random() < 0.5 else int(rng.integers(0, 3000)),
        polarity=int(rng.integers(0, 96)),
        channels=ALL if rng.random() < 0.6 else int(rng.integers(0, 128)),
        filter=int(rng.choice([0, 0, 1, 2, 3, rng.integers(0, 30), 255])),
        queue_depth=queue_depth,
        bit_cycles=bit_cycles,
    )


def _random_pin(
    rng: np.random.Generator, window: tuple[int, int], triggers: np.ndarray, *, filter_cycles: int
) -> PinChanges:
    """Toggles: at random, together with the generator's own edges, as glitches about as long as the filter, in bursts."""
    toggles = [rng.integers(*window, rng.integers(0, 8))]
    if triggers.size:
        toggles.append(rng.choice(triggers, min(4, triggers.size), replace=False))
    toggles += [
        at + np.cumsum(rng.integers(1, filter_cycles + 3, rng.integers(1, 5)))
        for at in rng.integers(*window, rng.integers(0, 6))
    ]
    if rng.random() < 0.4:
        toggles.append(rng.integers(*window) + np.cumsum(rng.integers(1, 2 * filter_cycles + 4, rng.integers(5, 60))))
    cycle = np.sort(np.concatenate(toggles))
    cycle = cycle[(cycle >= window[0]) & (cycle < window[1])]
    return PinChanges(cycle=cycle, level=(np.arange(cycle.size) + 1) % 2)


def coincident(sent: Sent) -> int:
    """Records of more than one channel."""
    return sum(message.channels.bit_count() > 1 for message in sent.messages)


assert {field.name for field in fields(Settings)} == {*NAMES, "queue_depth", "bit_cycles"}
