"""The whole circuit over its pins and its line, in Amaranth's simulator: no other tool is needed."""

from dataclasses import dataclass

import numpy as np
import pytest

pytest.importorskip("amaranth")

from amaranth.hdl import Cat
from amaranth.sim import Simulator

from irtiming.gateware.event_model import PinChanges, Run, Settings, camera_pin, chopper_pin, recorded_events
from irtiming.gateware.messages import (
    CommandMessage,
    RecordMessage,
    ReplyMessage,
    pack_command,
    unpack_record,
    unpack_reply,
)
from irtiming.gateware.register_file import RegisterFile
from irtiming.gateware.register_map import (
    ADDRESS,
    REGISTERS,
    Channel,
    Command,
    Polarity,
    Refusal,
    Status,
    at_reset,
)
from irtiming.gateware.trigger_generator import TriggerGenerator

FREQUENCY_HZ = 2_000_000
BIT = 2
COMMAND_CYCLES = 10 * 10 * BIT
ALL = int(sum(Channel))
PINS = {
    Channel.CAMERA_INPUT: "camera_in",
    Channel.CONTROL_SLOT: "control_in",
    Channel.APPLICATION_SLOT: "application_in",
    Channel.SPARE: "spare_in",
}


@dataclass
class _Outcome:
    replies: list[ReplyMessage]
    records: list[RecordMessage]
    camera: list[tuple[int, int]]
    chopper: list[tuple[int, int]]

    def values(self) -> list[tuple[int, int]]:
        return [(reply.refusal, reply.value) for reply in self.replies]

    def events(self) -> list[tuple[int, int]]:
        return [(record.time_ticks, record.channels) for record in self.records]


def _write(name: str | int, value: int) -> bytes:
    address = ADDRESS[name] if isinstance(name, str) else name
    return pack_command(CommandMessage(operation=1, tag=address ^ 0xFF, address=address, value=value))


def _read(name: str | int) -> bytes:
    address = ADDRESS[name] if isinstance(name, str) else name
    return pack_command(CommandMessage(operation=0, tag=address ^ 0xFF, address=address))


def _order(command: Command) -> bytes:
    return _write("COMMAND", command)


def _settings(**settings: int) -> list[bytes]:
    """Writes of CAMERA_WIDTH=..., in an order in which each width comes before its period."""
    return [_write(register.name, settings[register.name]) for register in REGISTERS if register.name in settings]


def _simulate(
    commands: list[bytes | int],
    *,
    inputs: dict[Channel, PinChanges] | None = None,
    queue_depth: int = 16,
    rest: int = 600,
) -> _Outcome:
    """Send commands, each right after the one before; a number among them is a pause in cycles."""
    circuit = TriggerGenerator(clock_frequency_hz=FREQUENCY_HZ, queue_depth=queue_depth)
    line = [1] * 10
    for command in commands:
        text, pause = (b"", command) if isinstance(command, int) else (command, 0)
        line += [
            level for byte in text for bit in (0, *((byte >> i) & 1 for i in range(8)), 1) for level in [bit] * BIT
        ]
        line += [1] * pause
    line += [1] * rest
    changes: dict[int, list[tuple[str, int]]] = {}
    for channel, pin in (inputs or {}).items():
        for cycle, level in zip(pin.cycle.tolist(), pin.level.tolist(), strict=True):
            changes.setdefault(cycle, []).append((PINS[channel], level))
    seen = np.zeros(len(line), np.int8)
    outputs = Cat(circuit.tx, circuit.camera_out, circuit.chopper_out)

    for cycle in np.flatnonzero(np.diff(line, prepend=-1)).tolist():
        changes.setdefault(cycle, []).append(("rx", line[cycle]))

    async def bench(ctx):
        ticks = aiter(ctx.tick().sample(outputs))
        for cycle in range(len(line)):
            for pin, level in changes.get(cycle, ()):
                ctx.set(getattr(circuit, pin), level)
            *_, seen[cycle] = await anext(ticks)

    simulator = Simulator(circuit)
    simulator.add_clock(1 / FREQUENCY_HZ)
    simulator.add_testbench(bench)
    simulator.run()
    replies, records = _messages(_bytes((seen & 1).tolist()))
    return _Outcome(replies, records, _changes(seen >> 1 & 1), _changes(seen >> 2))


def _changes(levels: np.ndarray) -> list[tuple[int, int]]:
    at = np.flatnonzero(np.diff(levels)) + 1
    return list(zip(at.tolist(), levels[at].tolist(), strict=True))


def _pairs(pin: PinChanges, until: int) -> list[tuple[int, int]]:
    return [pair for pair in zip(pin.cycle.tolist(), pin.level.tolist(), strict=True) if pair[0] < until]


def _bytes(levels: list[int]) -> bytes:
    found, cycle = bytearray(), 0
    while (cycle := next((c for c in range(cycle, len(levels) - 10 * BIT) if not levels[c]), -1)) >= 0:
        bits = [levels[cycle + BIT // 2 + BIT * i] for i in range(10)]
        assert bits[9] == 1
        found.append(sum(bit << i for i, bit in enumerate(bits[1:9])))
        cycle += 10 * BIT - 1
    return bytes(found)


def _messages(text: bytes) -> tuple[list[ReplyMessage], list[RecordMessage]]:
    replies, records, at = [], [], 0
    while at < len(text):
        if text[at] == 0x5A:
            replies.append(unpack_reply(text[at : at + 10]))
        else:
            records.append(unpack_record(text[at : at + 12]))
        at += 10 if text[at] == 0x5A else 12
    assert None not in [*replies, *records]
    return replies, records


def test_every_register_reads_as_at_reset():
    """Oracle: register_map.at_reset; the counter is that of a cycle within the command's last byte and the reply."""
    outcome = _simulate([_read(register.name) for register in REGISTERS])
    assert [reply.address for reply in outcome.replies] == [register.address for register in REGISTERS]
    assert all(reply.tag == reply.address ^ 0xFF for reply in outcome.replies)
    for number, (register, (refusal, value)) in enumerate(zip(REGISTERS, outcome.values(), strict=True)):
        wanted = 16 if register.name == "QUEUE_DEPTH" else at_reset(register, FREQUENCY_HZ)
        if register.name == "COUNTER_LOW":
            end = 10 + (number + 1) * COMMAND_CYCLES
            assert end - BIT < value < end + 10
        else:
            assert (register.name, refusal, value) == (register.name, Refusal.NONE, wanted)


@pytest.mark.parametrize("register", [r for r in REGISTERS if r.access == "setting"], ids=lambda r: r.name)
def test_a_setting_takes_its_lowest_and_highest_value_and_no_other(register):
    """Oracle: the bounds in the register map; a refused write replies with the value that the register kept."""
    first = max(register.lowest, 2)
    commands = [_write(f"{register.name.split('_')[0]}_WIDTH", 1)] if register.name.endswith("_PERIOD") else []
    tried = [first, register.lowest - 1, register.highest, register.highest + 1, register.lowest]
    possible = [value for value in tried if 0 <= value < 2**32]
    outcome = _simulate([*commands, *(_write(register.name, value) for value in possible), _read(register.name)])
    held, wanted = first, []
    for value in possible:
        is_good = register.lowest <= value <= register.highest
        held = value if is_good else held
        wanted.append((Refusal.NONE if is_good else Refusal.BAD_VALUE, held))
    assert outcome.values()[len(commands) :] == [*wanted, (Refusal.NONE, held)]


def test_a_period_must_exceed_the_width_that_was_written():
    """Oracle: by hand."""
    steps = [
        ("CAMERA_WIDTH", 100, Refusal.NONE, 100),
        ("CAMERA_PERIOD", 100, Refusal.BAD_VALUE, FREQUENCY_HZ // 30),
        ("CAMERA_PERIOD", 101, Refusal.NONE, 101),
        ("CAMERA_WIDTH", 2**31, Refusal.NONE, 2**31),
        ("CAMERA_PERIOD", 2**31 - 1, Refusal.BAD_VALUE, 101),
        ("CAMERA_PERIOD", 2**31 + 1, Refusal.NONE, 2**31 + 1),
        ("CHOPPER_WIDTH", 50, Refusal.NONE, 50),
        ("CHOPPER_PERIOD", 50, Refusal.BAD_VALUE, FREQUENCY_HZ // 300),
        ("CHOPPER_PERIOD", 51, Refusal.NONE, 51),
    ]
    outcome = _simulate([_write(name, value) for name, value, *_ in steps])
    assert outcome.values() == [(refusal, value) for *_, refusal, value in steps]


def test_what_cannot_be_is_refused():
    """Oracle: by hand, from the description of the registers."""
    other_operation = pack_command(CommandMessage(operation=2, tag=1, address=ADDRESS["FILTER"], value=9))
    other_operation_nowhere = pack_command(CommandMessage(operation=255, tag=1, address=0x7F, value=9))
    outcome = _simulate([
        _read(0x7F), _write(0x7F, 1), other_operation, other_operation_nowhere, _read("FILTER"),
        _write("IDENTITY", 1), _write("COUNTER_HIGH", 1), _write("COMMAND", 0), _write("COMMAND", 4),
        _write("COMMAND", 2**31 + 1), _read("COMMAND"), _read("GARBLED_COMMANDS"),
    ])  # fmt: skip
    assert outcome.values() == [
        (Refusal.UNKNOWN_REGISTER, 0), (Refusal.UNKNOWN_REGISTER, 0), (Refusal.BAD_VALUE, 0),
        (Refusal.UNKNOWN_REGISTER, 0), (Refusal.NONE, 0), (Refusal.READ_ONLY, 0x49525447), (Refusal.READ_ONLY, 0),
        (Refusal.BAD_VALUE, 0), (Refusal.BAD_VALUE, 0), (Refusal.BAD_VALUE, 0), (Refusal.NONE, 0), (Refusal.NONE, 0),
    ]  # fmt: skip


def test_garbled_commands_are_counted_and_get_no_reply():
    """Oracle: by hand: a wrong check sum, one that breaks off, and the reply to the read that follows."""
    good = _read("GARBLED_COMMANDS")
    outcome = _simulate([good[:9] + bytes([good[9] ^ 1]), good[:4], 25 * BIT, good])
    assert outcome.values() == [(Refusal.NONE, 2)]


def test_the_order_of_commands():
    """Oracle: by hand, from the description of COMMAND and STATUS."""
    small = _settings(CAMERA_WIDTH=5, CAMERA_PERIOD=10, CAMERA_COUNT=2)
    steps = [
        (_order(Command.START), Refusal.NOT_ARMED, 0),
        (_order(Command.STOP), Refusal.NONE, 0),
        (_order(Command.ARM), Refusal.NONE, 0),
        (_order(Command.ARM), Refusal.BUSY, 0),
        (_read("STATUS"), Refusal.NONE, Status.ARMED | Status.QUEUE_EMPTY),
        (_order(Command.START), Refusal.NONE, 0),
        (_read("STATUS"), Refusal.NONE, Status.ARMED | Status.FINISHED | Status.QUEUE_EMPTY),
        (_order(Command.START), Refusal.BUSY, 0),
        (_order(Command.ARM), Refusal.BUSY, 0),
        (_order(Command.STOP), Refusal.NONE, 0),
        (_read("STATUS"), Refusal.NONE, Status.FINISHED | Status.QUEUE_EMPTY),
        (_order(Command.START), Refusal.NOT_ARMED, 0),
        (_order(Command.ARM), Refusal.NONE, 0),
        (_read("STATUS"), Refusal.NONE, Status.ARMED | Status.QUEUE_EMPTY),
        (_order(Command.STOP), Refusal.NONE, 0),
        (_write("CHOPPER_WIDTH", 7), Refusal.NONE, 7),
        (_order(Command.ARM), Refusal.BAD_VALUE, 0),
        (_write("CHOPPER_PERIOD", 20), Refusal.NONE, 20),
        (_write("CAMERA_WIDTH", 7), Refusal.NONE, 7),
        (_order(Command.ARM), Refusal.BAD_VALUE, 0),
        (_write("CAMERA_WIDTH", 5), Refusal.NONE, 5),
        (_order(Command.ARM), Refusal.NONE, 0),
    ]
    commands = [
        part
        for command, *_ in steps
        for part in (command, COMMAND_CYCLES if command != _order(Command.START) else 4 * COMMAND_CYCLES)
    ]
    outcome = _simulate([*small, *commands])
    assert outcome.values()[len(small) :] == [(refusal, value) for _, refusal, value in steps]


def test_no_setting_changes_while_armed_or_while_a_pulse_runs():
    """Oracle: each setting, refused with the value that it has; a pulse of 4000 cycles outlasts STOP."""
    names = [register.name for register in REGISTERS if register.access == "setting"]
    before = _settings(CAMERA_WIDTH=4000, CAMERA_PERIOD=5000)
    armed = [_order(Command.ARM), *(_write(name, 3) for name in names), _order(Command.START), _order(Command.STOP)]
    after = [_write("FILTER", 3), _order(Command.ARM), _read("STATUS"), 4000, _read("STATUS"), _write("FILTER", 3)]
    outcome = _simulate([*before, *armed, *after])
    held = {register.name: at_reset(register, FREQUENCY_HZ) for register in REGISTERS}
    held |= {"CAMERA_WIDTH": 4000, "CAMERA_PERIOD": 5000}
    values = outcome.values()[len(before) + 1 :]
    assert values[: len(names)] == [(Refusal.BUSY, held[name]) for name in names]
    assert values[len(names) + 2 :] == [
        (Refusal.BUSY, 0),
        (Refusal.BUSY, 0),
        (Refusal.NONE, Status.TRIGGERING),  # the record waits behind the replies
        (Refusal.NONE, Status.FINISHED | Status.QUEUE_EMPTY),  # the train had one trigger only
        (Refusal.NONE, 3),
    ]


def _model(settings: dict[str, int], run: Run) -> tuple[Settings, Run]:
    reset = {register.name: at_reset(register, FREQUENCY_HZ) for register in REGISTERS} | settings
    names = [name for name in Settings.__dataclass_fields__ if name.upper() in reset and name != "queue_depth"]
    return Settings(bit_cycles=BIT, **{name: reset[name.upper()] for name in names}), run


@pytest.mark.parametrize(("delay", "polarity"), [(0, Polarity.CAMERA_OUTPUT), (299, 0), (1234, 0x7F & ~0x20)])
def test_a_measurement_is_that_of_the_model(delay, polarity):
    """Oracle: the integer model; coincident edges of all pins, a glitch, polarities, delays beyond the period."""
    settings = {
        "CAMERA_WIDTH": 299, "CAMERA_PERIOD": 300, "CAMERA_COUNT": 6, "CAMERA_DELAY": delay, "POLARITY": int(polarity),
        "CHANNELS": ALL, "FILTER": 3,
    }  # fmt: skip
    before = [*_settings(**settings), _order(Command.ARM), _order(Command.START)]
    begin = 10 + COMMAND_CYCLES * len(before)
    edges = np.array([300, 400, 403, 700, 704, 900, 1301], np.int64) + begin
    inputs = {
        pin: PinChanges(cycle=edges[i:] + (i == 3), level=(np.arange(edges.size - i) + 1) % 2)
        for i, pin in enumerate(PINS)
    }
    outcome = _simulate([*before, 3200, _order(Command.STOP)], inputs=inputs, rest=3000)
    first = outcome.records[0].time_ticks
    assert begin - BIT < first < begin + 20
    model, run = _model(settings, Run(armed_from_cycle=first - COMMAND_CYCLES, first_trigger_cycle=first))
    events = recorded_events(model, inputs, run=run)
    assert outcome.events() == list(zip(events.time_ticks.tolist(), events.channels.tolist(), strict=True))
    assert len(outcome.events()) > 12
    assert [record.number for record in outcome.records] == list(range(len(outcome.records)))
    assert outcome.camera[-12:] == _pairs(camera_pin(model, run), 2**31)


def test_a_change_of_the_chopper_makes_no_runt_and_no_gap():
    """Oracle: the integer model of the pin: the last pulse of the old kind is followed by the first of the new one."""
    slow = _settings(CHOPPER_WIDTH=100, CHOPPER_PERIOD=900)
    fast = _settings(CHOPPER_WIDTH=299, CHOPPER_PERIOD=300)
    outcome = _simulate([*slow, 7000, _write("CHOPPER_WIDTH", 3), 2000, *fast, 1500], rest=500)
    first, second = (10 + COMMAND_CYCLES * n + pause for n, pause in ((2, 0), (5, 9000)))
    reset = FREQUENCY_HZ // 300
    commits = [(0, reset // 2, reset), (first, 100, 900), (second, 299, 300)]
    until = 10 + COMMAND_CYCLES * 5 + 10_500
    assert outcome.chopper == _pairs(chopper_pin(commits, until_cycle=until + 500), until + 500)
    assert len(outcome.chopper) > 15


def test_stop_ends_the_train_and_recording_but_not_the_pulse():
    """Oracle: by hand: pulses of 900 at a period of 1000, STOP within the third."""
    settings = {"CAMERA_WIDTH": 900, "CAMERA_PERIOD": 1000, "CAMERA_COUNT": 9, "CAMERA_DELAY": 0, "CHANNELS": ALL}
    before = [*_settings(**settings), _order(Command.ARM), _order(Command.START), 2000, _order(Command.STOP)]
    end = 10 + COMMAND_CYCLES * (len(before) - 1) + 2000
    inputs = {
        Channel.CONTROL_SLOT: PinChanges(cycle=np.array([end - 20, end + 20]), level=np.array([1, 0])),
        Channel.APPLICATION_SLOT: PinChanges(cycle=np.array([end + 20]), level=np.array([1])),
    }
    status = [300, _read("STATUS"), 500, _read("STATUS"), _read("RECORDS_WRITTEN")]
    outcome = _simulate([*before, *status], inputs=inputs, rest=1000)
    first = outcome.records[0].time_ticks
    both = Channel.CAMERA_TRIGGER | Channel.CAMERA_TRIGGER_DELAYED
    wanted = [(first, both), (first + 1000, both), (first + 2000, both), (end - 20 + 3, Channel.CONTROL_SLOT)]
    assert outcome.events() == wanted
    pulses = [(first + 1000 * k + at, level) for k in range(3) for at, level in ((1, 1), (901, 0))]
    assert outcome.camera == pulses
    assert outcome.values()[-3:] == [
        (Refusal.NONE, Status.TRIGGERING | Status.QUEUE_EMPTY),
        (Refusal.NONE, Status.QUEUE_EMPTY),
        (Refusal.NONE, 4),
    ]


def test_losses_are_told_three_times_and_forgotten_by_arm():
    """Oracle: by hand: 17 edges in a burst: one goes on the line, 4 wait, 12 are lost; the next one tells."""
    begin = 10 + 2 * COMMAND_CYCLES
    edges = np.concatenate([begin + 300 + 10 * np.arange(17), [begin + 2500]])
    pin = PinChanges(cycle=edges, level=(np.arange(edges.size) + 1) % 2)
    read = [_read("STATUS"), _read("RECORDS_WRITTEN"), _read("RECORDS_LOST")]
    again = [_order(Command.STOP), _order(Command.ARM), *read]
    commands = [_write("CHANNELS", Channel.APPLICATION_SLOT | Channel.APPLICATION_OTHER_EDGE), _order(Command.ARM)]
    outcome = _simulate(
        [*commands, 3500, *read, *again], inputs={Channel.APPLICATION_SLOT: pin}, queue_depth=4, rest=1000
    )
    assert [record.time_ticks for record in outcome.records] == [*(edges[:5] + 3).tolist(), begin + 2500 + 3]
    assert [record.is_after_loss for record in outcome.records] == [False] * 5 + [True]
    assert [record.number for record in outcome.records] == list(range(6))
    armed = Status.ARMED | Status.QUEUE_EMPTY
    values = [value for _, value in outcome.values()]
    assert values[2:5] == [armed | Status.LOSS, 6, 12]
    assert values[7:] == [armed, 0, 0]


def test_numbers_of_32_and_48_bits_read_whole():
    """Oracle: by hand; the upper half of the counter is that of the cycle in which the lower half was read."""
    registers = RegisterFile(clock_frequency_hz=FREQUENCY_HZ, queue_depth=16)
    found = []

    async def bench(ctx):
        ctx.set(registers.records_written, 0xFFFF0001)
        ctx.set(registers.records_lost, 0xFFFFFFFF)
        ctx.set(registers.garbled_commands, 0x80000002)
        for counter, name in (
            (0xABCD_FFFFFFFF, "COUNTER_LOW"),
            (0xABCE_00000000, "COUNTER_HIGH"),
            (0xABCE_00000001, "COUNTER_LOW"),
            (0xFFFF_00000000, "COUNTER_HIGH"),
            (0, "RECORDS_WRITTEN"),
            (0, "RECORDS_LOST"),
            (0, "GARBLED_COMMANDS"),
        ):
            ctx.set(registers.counter, counter)
            ctx.set(registers.command.address, ADDRESS[name])
            ctx.set(registers.is_command, 1)
            while not ctx.get(registers.is_reply):
                await ctx.tick()
                ctx.set(registers.is_command, 0)
            found.append(ctx.get(registers.reply.value))
            await ctx.tick()

    simulator = Simulator(registers)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()
    assert found == [0xFFFFFFFF, 0xABCD, 1, 0xABCE, 0xFFFF0001, 0xFFFFFFFF, 0x80000002]
