"""The serial line in Amaranth's simulator, with a computer at its other end that is written in plain Python."""

import pytest

pytest.importorskip("amaranth")

from amaranth.sim import Simulator

from irtiming.gateware.messages import (
    SILENCE_BITS,
    CommandMessage,
    RecordMessage,
    ReplyMessage,
    pack_command,
    pack_record,
    pack_reply,
)
from irtiming.gateware.serial_link import ByteReceiver, ByteSender, CommandReceiver, MessageSender, SerialLink

BIT = 8
BYTE = 10 * BIT
COMMAND = pack_command(CommandMessage(operation=1, tag=0x12, address=0x2B, value=0x89ABCDEF))
REPLY = ReplyMessage(refusal=3, tag=0xA5, address=0x5A, value=0x01020304)
RECORD = RecordMessage(channels=0x55, number=0xBEEF, time_ticks=0xFEDCBA987654, is_after_loss=True)


def _simulate(circuit, bench) -> None:
    simulator = Simulator(circuit)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()


def _levels(text: bytes, *, bit: float = BIT, stop: int = 1) -> list[int]:
    """Level of the line in each cycle while these bytes follow each other."""
    bits = [level for byte in text for level in (0, *((byte >> i) & 1 for i in range(8)), stop)]
    return [bits[int(cycle / bit)] for cycle in range(int(len(bits) * bit))]


def _bytes(levels: list[int]) -> list[tuple[int, int]]:
    """First cycle of each byte, and the byte, by the first falling edge and the middles of the bits."""
    found, cycle = [], 0
    while cycle < len(levels) - BYTE + 1:
        if levels[cycle]:
            cycle += 1
            continue
        bits = [levels[cycle + BIT // 2 + BIT * i] for i in range(10)]
        assert bits[0] == 0
        assert bits[9] == 1
        found.append((cycle, sum(bit << i for i, bit in enumerate(bits[1:9]))))
        cycle += BYTE - BIT // 2
    return found


def _received(levels: list[int]) -> list[int]:
    receiver, found = ByteReceiver(bit_cycles=BIT), []

    async def bench(ctx):
        for level in [1] * 10 + levels + [1] * 20:
            ctx.set(receiver.rx, level)
            found.extend([ctx.get(receiver.byte)] * ctx.get(receiver.is_byte))
            await ctx.tick()
        assert ctx.get(receiver.is_idle)

    _simulate(receiver, bench)
    return found


@pytest.mark.parametrize("bit", [0.96 * BIT, BIT, 1.04 * BIT])
def test_bytes_arrive_though_the_clocks_differ_by_4_percent(bit):
    """Oracle: the bytes; half a bit of play over 9.5 bits is 5 %."""
    text = bytes([0x00, 0xFF, 0x55, 0xAA, 0x01, 0x80, 0xA5])
    assert _received([level for byte in text for level in (*_levels(bytes([byte]), bit=bit), 1, 1)]) == list(text)


def test_a_short_dip_is_no_start_bit():
    """Oracle: by hand: 3 of 8 cycles are less than half a bit."""
    assert _received([0] * 3 + [1] * 9 + _levels(b"\x42")) == [0x42]


def test_a_byte_without_stop_bit_does_not_count_and_a_cut_line_sends_none():
    """Oracle: by hand: a byte with its stop bit low, then a line that stays low for 30 bits."""
    assert _received(_levels(b"\x41", stop=0) + [1] * BYTE + _levels(b"\x42")) == [0x42]
    assert _received([0] * 30 * BIT + [1] * BIT + _levels(b"\x43")) == [0x43]


def test_bytes_leave_without_a_gap():
    """Oracle: the line as 10 bits of 8 cycles a byte, each byte right after the one before."""
    sender, levels, taken = ByteSender(bit_cycles=BIT), [], []
    text = list(b"\x00\xff\x5a")

    async def bench(ctx):
        ctx.set(sender.load, 1)
        for cycle in range(10 + 4 * BYTE):
            ctx.set(sender.byte, text[len(taken)] if len(taken) < 3 else 0)
            ctx.set(sender.load, len(taken) < 3)
            levels.append(ctx.get(sender.tx))
            if ctx.get(sender.is_ready) and len(taken) < 3:
                taken.append(cycle)
            await ctx.tick()

    _simulate(sender, bench)
    assert taken == [0, BYTE, 2 * BYTE]
    assert levels == [1] + _levels(bytes(text)) + [1] * (9 + BYTE)


def _commands(levels: list[int]) -> tuple[list[bytes], int]:
    """The seven fields of commands that arrive whole, and how many are garbled."""
    receiver, found, garbled = CommandReceiver(bit_cycles=BIT), [], []

    async def bench(ctx):
        for level in [1] * 5 + levels + [1] * 20:
            ctx.set(receiver.rx, level)
            if ctx.get(receiver.is_command):
                found.append(ctx.get(receiver.command.as_value()).to_bytes(7, "little"))
            garbled.extend([1] * ctx.get(receiver.is_garbled))
            await ctx.tick()

    _simulate(receiver, bench)
    return found, len(garbled)


def test_commands_arrive_back_to_back():
    """Oracle: bytes 1 to 7 of what was sent."""
    other = pack_command(CommandMessage(operation=0, tag=0xA5, address=0xA5, value=0xA5A5A5A5))
    found, garbled = _commands(_levels(COMMAND + other + COMMAND))
    assert found == [COMMAND[1:8], other[1:8], COMMAND[1:8]]
    assert garbled == 0


@pytest.mark.parametrize("byte", range(1, 10))
def test_a_command_with_any_byte_changed_is_garbled_and_the_next_one_is_not(byte):
    """Oracle: by hand: one of the ten bytes differs in one bit; a change of the first is `test_other_bytes`."""
    broken = bytearray(COMMAND)
    broken[byte] ^= 1 << byte % 8
    assert _commands(_levels(bytes(broken) + COMMAND)) == ([COMMAND[1:8]], 1)


def test_other_bytes_before_a_command_are_skipped():
    """Oracle: by hand; none of them is the start byte, so nothing is garbled."""
    assert _commands(_levels(b"\x00\xff\x5a\xc3" + COMMAND)) == ([COMMAND[1:8]], 0)


@pytest.mark.parametrize("sent", range(1, 10))
def test_a_command_that_breaks_off_is_forgotten_after_24_bit_times(sent):
    """Oracle: by hand: the rest of it comes in time, or too late and is then no command of its own."""
    in_time = _levels(COMMAND[:sent]) + [1] * (SILENCE_BITS - 1) * BIT + _levels(COMMAND[sent:])
    assert _commands(in_time) == ([COMMAND[1:8]], 0)
    too_late = _levels(COMMAND[:sent]) + [1] * (SILENCE_BITS + 1) * BIT + _levels(COMMAND)
    assert _commands(too_late) == ([COMMAND[1:8]], 1)


def _sent(bench_of, cycles: int) -> list[tuple[int, int]]:
    sender, levels = MessageSender(bit_cycles=BIT), []

    async def bench(ctx):
        ctx.set(sender.reply.as_value(), int.from_bytes(pack_reply(REPLY)[1:8], "little"))
        for cycle in range(cycles):
            bench_of(ctx, sender, cycle)
            if ctx.get(sender.takes_reply):
                ctx.set(sender.reply_waits, 0)
            levels.append(ctx.get(sender.tx))
            pops = ctx.get(sender.pops_record)
            await ctx.tick()
            if pops:
                ctx.set(sender.record.as_value(), int.from_bytes(pack_record(RECORD)[1:10], "little"))

    _simulate(sender, bench)
    return _bytes(levels)


def test_a_reply_goes_before_the_records_that_wait_and_never_into_one():
    """Oracle: messages.py byte by byte, and the first cycle of each: no gap between messages."""

    def drive(ctx, sender, cycle):
        ctx.set(sender.record_waits, cycle < 33 * BYTE)
        if cycle in (0, 5 * BYTE, 25 * BYTE):  # both wait; a reply comes within a reply; a reply comes within a record
            ctx.set(sender.reply_waits, 1)

    found = _sent(drive, 50 * BYTE)
    reply, record = pack_reply(REPLY), pack_record(RECORD)
    assert bytes(byte for _, byte in found) == reply + reply + record + reply
    assert [cycle for cycle, _ in found] == [1 + BYTE * i for i in range(42)]


def test_records_follow_each_other():
    """Oracle: messages.py byte by byte."""

    def drive(ctx, sender, cycle):
        ctx.set(sender.record_waits, cycle < 25 * BYTE)

    found = _sent(drive, 50 * BYTE)
    assert bytes(byte for _, byte in found) == pack_record(RECORD) * 3
    assert [cycle for cycle, _ in found] == [1 + BYTE * i for i in range(36)]


def test_a_command_that_comes_while_a_reply_waits_is_dropped_and_counted():
    """Oracle: by hand: a record of 12 bytes begins within the last byte of the first of three commands of 10."""
    link, passed, garbled = SerialLink(bit_cycles=BIT), [], []

    async def bench(ctx):
        for cycle, level in enumerate(_levels(COMMAND * 3) + [1] * BYTE):
            ctx.set(link.rx, level)
            ctx.set(link.record_waits, cycle == 9 * BYTE + BIT)
            is_command = ctx.get(link.is_command)
            passed.extend([cycle] * is_command)
            await ctx.tick()
            ctx.set(link.is_reply, is_command)
        garbled.append(ctx.get(link.garbled))

    _simulate(link, bench)
    assert [round(cycle / BYTE) for cycle in passed] == [10, 30]
    assert garbled == [1]
