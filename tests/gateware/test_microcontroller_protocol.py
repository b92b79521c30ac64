"""The microcontroller's firmware on its serial line: bytes, registers, refusals and records, without its chip."""

import random

import numpy as np
import pytest
from emulated_pico import load_firmware
from scripted_chip import ScriptedChip

from irtiming.gateware import event_model, messages, register_map
from irtiming.gateware.messages import CommandMessage, Operation, RecordMessage, ReplyMessage
from irtiming.gateware.model_device import ModelDevice
from irtiming.gateware.register_map import ADDRESS, REGISTERS, Channel, Command, Refusal, Status

CLOCK_HZ = 60_000_000
WIDTHS = (0, 8, 16, 100, 116, 5000, 2**31)  # no gap to any period below is between 1 and 7 counts
OWN = {"INPUT_LATENCY": 1, "OUTPUT_LATENCY": 0}
LINE_OF = {Channel.CONTROL_SLOT: 2, Channel.APPLICATION_SLOT: 3, Channel.CAMERA_INPUT: 4, Channel.SPARE: 5}
AT_RESET = {r.name: register_map.at_reset(r, CLOCK_HZ) for r in REGISTERS} | OWN


class Device:
    """Firmware and script behind one line."""

    def __init__(self, monkeypatch, **clock):
        self.generator_file, self.lines_file, self.messages_file = load_firmware(
            monkeypatch, "generator", "lines", "serial_messages"
        )
        lines = [self.lines_file.Line(**settings) for *_, settings in self.lines_file.WATCHED]
        self.chip = ScriptedChip(lines, **clock)
        self.generator = self.generator_file.Generator(self.chip)

    def ask(self, operation, name, value=0):
        address = ADDRESS[name] if isinstance(name, str) else name
        message = CommandMessage(operation=operation, tag=77, address=address, value=value)
        reply = messages.unpack_reply(self.generator.receive(messages.pack_command(message), 0))
        assert (reply.tag, reply.address) == (77, address)
        return reply

    def read(self, name):
        return self.ask(Operation.READ, name).value

    def write(self, name, value):
        return Refusal(self.ask(Operation.WRITE, name, value).refusal)

    def status(self):
        return Status(self.read("STATUS"))

    def records(self):
        found = []
        while data := self.generator.next_record():
            found.append(messages.unpack_record(data))
        return found

    def work(self, counts):
        until = self.chip.now() + counts
        while self.chip.now() < until:
            self.generator.work()


@pytest.fixture
def device(monkeypatch):
    return Device(monkeypatch)


def _train(device, *, width=20, period=100, count=5, delay=0):
    for name, value in (("WIDTH", width), ("PERIOD", period), ("COUNT", count), ("DELAY", delay)):
        assert device.write(f"CAMERA_{name}", value) == Refusal.NONE


def test_check_sums_and_messages_are_those_of_the_computer(device):
    """Oracle: irtiming.gateware.messages, on random content and at the largest values."""
    own, draw = device.messages_file, random.Random(4)
    for _ in range(300):
        data = draw.randbytes(draw.randrange(40))
        assert own.check_sum(data) == messages.check_sum(data)
    for tag, address, value in [(0, 0, 0), (255, 255, 2**32 - 1), (18, 52, 0x89ABCDEF)]:
        reply = ReplyMessage(refusal=5, tag=tag, address=address, value=value)
        assert own.pack_reply(refusal=5, tag=tag, address=address, value=value) == messages.pack_reply(reply)
    for channels, number, time in [(0, 0, 0), (0x7F, 65535, 2**48 - 1), (9, 300, 0x123456789ABC)]:
        record = RecordMessage(channels=channels, number=number, time_ticks=time, is_after_loss=True)
        packed = own.pack_record(channels=channels | register_map.LOSS, number=number, time=time)
        assert packed == messages.pack_record(record)


def test_the_constants_of_the_protocol_are_those_of_the_computer(device):
    """Oracle: the register map's names and numbers."""
    own = device.generator_file
    renamed = {
        "DEPTH": "QUEUE_DEPTH",
        "WRITTEN": "RECORDS_WRITTEN",
        "LOST": "RECORDS_LOST",
        "GARBLED": "GARBLED_COMMANDS",
    }
    names = {name: renamed.get(name, name) for name in (*ADDRESS, *renamed)}
    found = {name: getattr(own, short) for short, name in names.items() if isinstance(getattr(own, short, None), int)}
    assert found | {"QUEUE_DEPTH": ADDRESS["QUEUE_DEPTH"]} == ADDRESS
    assert register_map.QUEUE_DEPTH == own.QUEUE_DEPTH
    assert all(getattr(own, refusal.name) == refusal for refusal in Refusal)
    assert all(getattr(own, command.name) == command for command in Command)
    assert list(Status) == [own.ARMED, own.TRIGGERING, own.FINISHED, own.LOSS_STATUS, own.QUEUE_EMPTY]
    assert own.LOSS == register_map.LOSS
    watched = [settings for *_, settings in device.lines_file.WATCHED]
    assert sum(line["channel"] | line.get("other_channel", 0) for line in watched) == sum(Channel)


@pytest.mark.parametrize("register", REGISTERS, ids=lambda register: register.name)
def test_every_register_reads_as_the_map_says_after_reset(device, register):
    """Oracle: the register map; the latencies are the chip's own, the counter runs."""
    if register.name.startswith("COUNTER"):
        return
    assert device.ask(Operation.READ, register.name) == ReplyMessage(
        refusal=0, tag=77, address=register.address, value=AT_RESET[register.name]
    )


def test_all_other_addresses_are_unknown(device):
    """Oracle: the addresses of the map."""
    for address in set(range(256)) - set(ADDRESS.values()):
        for operation in Operation:
            reply = device.ask(operation, address, 5)
            assert (reply.refusal, reply.value) == (Refusal.UNKNOWN_REGISTER, 0)


@pytest.mark.parametrize("register", REGISTERS, ids=lambda register: register.name)
def test_writes_are_taken_or_refused_as_the_map_says(device, register):
    """Oracle: access, lowest and highest of the map; a refused write leaves the value, a reply holds the value then."""
    before = device.read(register.name)
    if register.access == "read":
        assert device.write(register.name, before) == Refusal.READ_ONLY
        return
    for value in [v for v in (register.lowest - 1, register.highest + 1) if 0 <= v < 2**32]:
        reply = device.ask(Operation.WRITE, register.name, value)
        assert (reply.refusal, reply.value) == (Refusal.BAD_VALUE, before)
    if register.access == "setting":
        low = max(register.lowest, AT_RESET.get(register.name.replace("PERIOD", "WIDTH"), 0) + 8)
        for value in (min(low, register.highest), register.highest):
            reply = device.ask(Operation.WRITE, register.name, value)
            assert (reply.refusal, reply.value) == (Refusal.NONE, value)


@pytest.mark.parametrize("pulse", ["CHOPPER", "CAMERA"])
@pytest.mark.parametrize(("width", "period", "refusal"), [
    (8, 16, Refusal.NONE), (7, 100, Refusal.BAD_VALUE), (93, 100, Refusal.BAD_VALUE), (92, 100, Refusal.NONE),
    (100, 100, Refusal.BAD_VALUE), (200, 100, Refusal.BAD_VALUE),
])  # fmt: skip
def test_pulses_and_gaps_shorter_than_eight_counts_are_refused(device, pulse, width, period, refusal):
    """Oracle: eight counts for pulse and gap, by hand; the chip gets a pair of values only once the period came."""
    assert device.write(f"{pulse}_WIDTH", width) == Refusal.NONE
    assert device.chip.calls == []
    assert device.write(f"{pulse}_PERIOD", period) == refusal
    wanted = [("chopper", width, period)] if pulse == "CHOPPER" and refusal == Refusal.NONE else []
    assert device.chip.calls == wanted


def test_a_chip_without_a_third_pio_refuses_the_two_channels_that_it_has_no_machine_for(device):
    """Oracle: the mask of an RP2040, 0x3B, by hand."""
    device.chip.channels = 0x3B
    assert device.write("CHANNELS", 0x3B) == Refusal.NONE
    for channel in (Channel.CAMERA_INPUT, Channel.SPARE):
        assert device.write("CHANNELS", 0x3B | channel) == Refusal.BAD_VALUE
    assert device.read("CHANNELS") == 0x3B


def test_random_commands_get_the_replies_of_the_model_of_the_fpga(monkeypatch):
    """Oracle: ModelDevice, reply for reply, over 3000 random commands without a train."""
    device = Device(monkeypatch)
    model = ModelDevice(clock_frequency_hz=CLOCK_HZ, registers=OWN)
    draw = random.Random(7)
    names = [name for name in ADDRESS if not name.startswith(("COUNTER", "STATUS"))]
    values = [0, 1, 2, 3, 4, 8, 16, 100, 116, 255, 256, 5000, 2**31, 2**32 - 1]
    refusals = set()
    for number in range(3000):
        name = draw.choice([*names, *["COMMAND"] * 6, "CAMERA_PERIOD", "CHOPPER_PERIOD"])
        value = draw.choice(WIDTHS if name.endswith("WIDTH") else values)
        operation = draw.choices([0, 1, 2, 255], weights=[5, 10, 1, 1])[0]
        message = CommandMessage(operation=operation, tag=number % 256, address=ADDRESS[name], value=value)
        if name == "COMMAND" and operation == 1 and value == Command.START:
            continue  # when a train ends is compared elsewhere
        asked = messages.pack_command(message)
        reply = device.generator.receive(asked, 0)
        assert reply == model.exchange(asked, until_cycle=0), message
        refusals.add(reply[1])
    assert refusals == {Refusal.NONE, Refusal.READ_ONLY, Refusal.BUSY, Refusal.BAD_VALUE}


def test_commands_in_their_order(device):
    """Oracle: the sequence of the register map, by hand."""
    assert device.write("COMMAND", Command.START) == Refusal.NOT_ARMED
    assert device.write("COMMAND", Command.STOP) == Refusal.NONE
    _train(device, count=3, delay=250)
    assert device.write("CAMERA_WIDTH", 30) == Refusal.NONE
    assert device.write("COMMAND", Command.ARM) == Refusal.BAD_VALUE  # a width that no period has committed
    assert device.write("CAMERA_PERIOD", 100) == Refusal.NONE
    assert device.write("COMMAND", Command.ARM) == Refusal.NONE
    assert device.write("COMMAND", Command.ARM) == Refusal.BUSY
    assert device.write("FILTER", 3) == Refusal.BUSY
    assert device.read("FILTER") == 0
    assert device.write("COMMAND", Command.START) == Refusal.NONE
    assert device.chip.calls[-1] == ("train", 30, 100, 3, 250)
    assert device.status() == Status.ARMED | Status.TRIGGERING | Status.QUEUE_EMPTY
    assert device.write("COMMAND", Command.START) == Refusal.BUSY
    device.work(3000)
    assert device.status() == Status.ARMED | Status.FINISHED
    assert device.write("COMMAND", Command.START) == Refusal.BUSY
    device.records()
    assert device.write("COMMAND", Command.STOP) == Refusal.NONE
    assert device.status() == Status.FINISHED | Status.QUEUE_EMPTY
    assert device.write("COMMAND", Command.ARM) == Refusal.NONE
    assert device.status() == Status.ARMED | Status.QUEUE_EMPTY
    assert device.read("COMMAND") == 0


def test_stop_ends_train_and_recording(device):
    """Oracle: by hand: pulses begun before STOP are recorded, none after; the train does not count as finished."""
    _train(device, width=20, period=5000, count=50)
    device.write("COMMAND", Command.ARM)
    device.write("COMMAND", Command.START)
    device.work(12_000)
    begun = device.chip.now() + 1 - device.chip.first_trigger
    assert device.write("COMMAND", Command.STOP) == Refusal.NONE
    assert device.status() & (Status.ARMED | Status.FINISHED) == 0
    device.chip.edges.append((device.chip._count + 8000, 2, 1))  # an input goes on
    device.work(20_000)
    assert device.status() == Status(0)
    times = [record.time_ticks for record in device.records()]
    assert times == [device.chip.first_trigger + 5000 * k for k in range(-(-begun // 5000))]
    assert len(times) == 3
    assert device.status() == Status.QUEUE_EMPTY


def test_broken_commands_are_counted_and_forgotten(device):
    """Oracle: by hand: garbage is skipped, a wrong check sum and a break count one each, and the next command works."""
    whole = messages.pack_command(CommandMessage(operation=0, tag=1, address=0))
    wrong = whole[:-1] + bytes([whole[-1] ^ 1])
    receive = device.generator.receive
    assert receive(b"\x00\x03\x5a" + whole, 0)[0] == messages.REPLY_START
    assert device.read("GARBLED_COMMANDS") == 0
    assert receive(wrong, 0) == b""
    assert device.read("GARBLED_COMMANDS") == 1
    assert receive(whole[:4], 1000) == b""
    assert receive(whole[4:], 1050) == receive(whole, 1050)  # within the silence
    assert receive(whole[:4], 2000) == b""
    assert receive(b"", 2051) == b""
    assert device.read("GARBLED_COMMANDS") == 2
    assert receive(whole * 3, 2060) == receive(whole, 2060) * 3
    assert b"".join(receive(bytes([byte]), 2061) for byte in whole) == receive(whole, 2061)


def test_the_millisecond_clock_may_wrap(device):
    """Oracle: MicroPython's clock goes from 2^30 - 1 to 0; half a command before, half after is one command."""
    whole = messages.pack_command(CommandMessage(operation=0, tag=1, address=0))
    assert device.generator.receive(whole[:5], 2**30 - 2) == b""
    assert len(device.generator.receive(whole[5:], 3)) == 10


def test_control_c_after_a_return_stops_the_program_but_not_within_a_command(device):
    """Oracle: the two bytes with which tools for MicroPython begin; as parts of a value they are numbers."""
    value = CommandMessage(operation=1, tag=0x0D, address=3, value=0x030D030D)
    assert device.generator.receive(messages.pack_command(value), 0)
    assert device.generator.receive(b"\x03\r\r", 0) == b""
    with pytest.raises(KeyboardInterrupt):
        device.generator.receive(b"\r\x03", 0)


def test_the_counter_is_read_in_two_parts_that_belong_together(device):
    """Oracle: by hand; the upper part is that of the moment when the lower was read."""
    device.chip._count = 2**32 - 20
    low = device.read("COUNTER_LOW")
    device.chip._count = 2**35
    assert (device.read("COUNTER_HIGH") << 32 | low) == 2**32 + 20


def _script(draw, *, count, span):
    """Edges of all input lines as (raw count, line, level), some of them glitches, some at the same count."""
    moments = {line: sorted(draw.sample(range(4000, 4000 + span), count)) for line in LINE_OF.values()}
    moments[3] = sorted({*moments[3][::2], *moments[2][::2]})  # the same counts on two lines
    return {line: [(moment, i % 2 ^ 1) for i, moment in enumerate(times)] for line, times in moments.items()}


@pytest.mark.parametrize("seed", range(6))
def test_records_are_those_of_the_event_model(monkeypatch, seed):
    """Oracle: event_model.recorded_events and the numbering of its queue; record for record, byte for byte."""
    draw = random.Random(seed)
    device = Device(monkeypatch, counts_per_look=draw.choice([13, 40, 700]))
    polarity, channels, glitch = (
        draw.randrange(0x60),
        draw.choice([0x7F, 0x3B, draw.randrange(0x80)]),
        draw.choice([0, 5, 60]),
    )
    width, period = 20, draw.randrange(60, 400)
    count, delay = draw.randrange(1, 80), draw.choice([0, 3, 700])
    _train(device, width=width, period=period, count=count, delay=delay)
    for name, value in (("POLARITY", polarity & 0x5D), ("CHANNELS", channels), ("FILTER", glitch)):
        assert device.write(name, value) == Refusal.NONE
    script = _script(draw, count=150, span=20_000)
    device.chip.edges = sorted((moment, line, level) for line, edges in script.items() for moment, level in edges)
    assert device.write("COMMAND", Command.ARM) == Refusal.NONE
    armed_from = device.chip._count
    device.work(draw.choice([0, 3000]))
    assert device.write("COMMAND", Command.START) == Refusal.NONE
    found = []
    while len(found) < 3 or device.chip._count < 40_000 + count * period:
        device.generator.work()
        found += device.records()
        if device.chip._count > 60_000 + count * period:
            break
    settings = event_model.Settings(
        chopper_width=1, chopper_period=2, camera_width=width, camera_period=period, camera_count=count,
        camera_delay=delay, polarity=polarity & 0x5D, channels=channels, filter=glitch, bit_cycles=1,
    )  # fmt: skip
    later = 1 + register_map.INPUT_LATENCY_CYCLES  # the FPGA's synchroniser; the script's counts are behind this chip's
    pins = {
        channel: event_model.PinChanges(
            cycle=np.array([moment - later for moment, _ in script[line]], np.int64),
            level=np.array([level for _, level in script[line]], np.int64),
        )
        for channel, line in LINE_OF.items()
    }
    run = event_model.Run(armed_from_cycle=armed_from, first_trigger_cycle=device.chip.first_trigger)
    events = event_model.recorded_events(settings, pins, run=run)
    timing = event_model.LineTiming(write=0, take=0, between=-(10**9))
    wanted = event_model.through_queue(events, settings, timing=timing)
    assert wanted.written > 0 or not channels
    assert tuple(found) == wanted.messages
    assert device.read("RECORDS_WRITTEN") == wanted.written
    assert device.read("RECORDS_LOST") == 0


def test_a_line_waits_until_it_is_sure(device):
    """Oracle: by hand, with a filter of 5: an edge at 10 counts once the level is known to have been kept through 15."""
    line = device.lines_file.Line(channel=8, other_channel=32, polarity=8)
    line.set_up(channels=0x7F, polarity=0, filter_counts=5, shift=100)
    line.edge(10, 1)
    line.settle(15)
    assert line.events == []
    line.settle(16)
    assert line.events == [(115, 8)]
    line.edge(30, 0)
    line.edge(35, 1)  # kept for 5 counts only: a glitch
    line.settle(1000)
    assert len(line.events) == 1
    line.edge(2000, 0)
    line.edge(2006, 1)
    assert line.events[1:] == [(2105, 32)]


def test_the_inverted_camera_output_is_recorded_at_its_active_edges(device):
    """Oracle: t0 + k C; the watched pin falls where the pulse begins."""
    _train(device, count=4)
    device.write("POLARITY", register_map.Polarity.CAMERA_OUTPUT)
    assert device.chip.calls == [("polarity", 2)]
    device.chip.edges = [(3, 1, 1)]  # the pin idles high from here on
    device.work(200)
    device.write("COMMAND", Command.ARM)
    device.write("COMMAND", Command.START)
    device.chip.edges = [(at, line, level ^ (line == 1)) for at, line, level in device.chip.edges]
    device.work(4000)
    both = Channel.CAMERA_TRIGGER | Channel.CAMERA_TRIGGER_DELAYED
    assert [(r.time_ticks - device.chip.first_trigger, r.channels) for r in device.records()] == [
        (100 * k, both) for k in range(4)
    ]


def test_a_full_queue_loses_records_and_tells_it_three_times(device):
    """Oracle: by hand: 512 records wait, 88 of 600 are lost; then a record with the loss bit and an unbroken number."""
    _train(device, count=600)
    device.write("COMMAND", Command.ARM)
    device.write("COMMAND", Command.START)
    device.work(70_000)
    assert (device.read("RECORDS_WRITTEN"), device.read("RECORDS_LOST")) == (512, 88)
    first = device.records()
    assert [record.number for record in first] == list(range(512))
    assert not any(record.is_after_loss for record in first)
    device.chip.edges = [(device.chip._count + 50 * k, 2, k % 2) for k in range(1, 5)]
    device.work(4000)
    assert [(record.number, record.is_after_loss) for record in device.records()] == [(512, True), (513, False)]
    assert device.status() == Status.ARMED | Status.FINISHED | Status.LOSS | Status.QUEUE_EMPTY
    device.write("COMMAND", Command.STOP)
    assert device.status() & Status.LOSS
    device.write("COMMAND", Command.ARM)
    assert (device.status(), device.read("RECORDS_LOST")) == (Status.ARMED | Status.QUEUE_EMPTY, 0)


def test_edges_lost_in_the_chip_count_if_their_line_is_recorded(device):
    """Oracle: by hand; line 2 is recorded, line 4 (camera input) is not at reset; before ARM nothing counts."""
    device.chip.lost = {2: 9}
    device.write("COMMAND", Command.ARM)
    assert device.read("RECORDS_LOST") == 0
    device.chip.lost = {4: 5}
    device.work(100)
    assert device.read("RECORDS_LOST") == 0
    device.chip.lost = {2: 3}
    device.chip.edges = [(device.chip._count + 100, 2, 1)]
    device.work(4000)
    assert device.read("RECORDS_LOST") == 3
    assert [record.is_after_loss for record in device.records()] == [True]
