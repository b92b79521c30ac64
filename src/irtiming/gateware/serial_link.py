"""The serial line: bytes, commands that arrive, replies and records that leave."""

from typing import final

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import data, wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.crc.catalog import CRC16_IBM_3740
from amaranth.lib.wiring import In, Out

from irtiming.gateware.messages import (
    COMMAND_BYTES,
    COMMAND_START,
    RECORD_BYTES,
    RECORD_START,
    REPLY_BYTES,
    REPLY_START,
    SILENCE_BITS,
)
from irtiming.gateware.timestamp_queue import RECORD, SaturatingCounter

COMMAND = data.StructLayout({"operation": 8, "tag": 8, "address": 8, "value": 32})
"""Bytes 1 to 7 of a command's message."""

REPLY = data.StructLayout({"refusal": 8, "tag": 8, "address": 8, "value": 32})
"""Bytes 1 to 7 of a reply's message."""

_CHECK_SUM_BYTES = 2


@final
class ByteReceiver(wiring.Component):
    """Bytes with one start bit, 8 data bits and one stop bit; one whose stop bit is low does not count.

    Attributes
    ----------
    rx : in
        Asynchronous; idles high.
    byte, is_byte : out
        ``is_byte`` is high for one cycle, in the middle of the stop bit.
    is_idle : out
        No byte is under way.
    """

    def __init__(self, *, bit_cycles: int) -> None:
        self._bit_cycles = bit_cycles
        super().__init__({"rx": In(1), "byte": Out(8), "is_byte": Out(1), "is_idle": Out(1)})

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for."""
        m = Module()
        level = Signal(init=1)
        until_sample = Signal(range(self._bit_cycles))
        bits_left = Signal(range(9))
        m.submodules.synchroniser = FFSynchronizer(self.rx, level, init=1)
        m.d.sync += [until_sample.eq(until_sample - 1), self.is_byte.eq(0)]
        with m.FSM() as fsm:
            m.d.comb += self.is_idle.eq(fsm.ongoing("IDLE"))
            with m.State("IDLE"):
                m.d.sync += [until_sample.eq(self._bit_cycles // 2 - 1), bits_left.eq(8)]
                with m.If(~level):
                    m.next = "START"
            with m.State("START"), m.If(until_sample == 0):
                m.d.sync += until_sample.eq(self._bit_cycles - 1)
                m.next = "DATA"
                with m.If(level):  # shorter than half a bit: a glitch
                    m.next = "IDLE"
            with m.State("DATA"), m.If(until_sample == 0):
                m.d.sync += until_sample.eq(self._bit_cycles - 1)
                with m.If(bits_left == 0):
                    m.d.sync += self.is_byte.eq(level)
                    m.next = "IDLE"
                    with m.If(~level):
                        m.next = "CUT"
                with m.Else():
                    m.d.sync += [self.byte.eq(Cat(self.byte[1:], level)), bits_left.eq(bits_left - 1)]
            with m.State("CUT"), m.If(level):  # until then the line is low for longer than a byte
                m.next = "IDLE"
        return m


@final
class ByteSender(wiring.Component):
    """The counterpart of `ByteReceiver`; bytes may follow each other without a gap.

    Attributes
    ----------
    byte, load : in
        Taken in a cycle in which ``load`` and ``is_ready`` are high; the start bit begins in the next one.
    is_ready : out
        The line is idle, or in the last cycle of a stop bit.
    tx : out
        The line.
    """

    def __init__(self, *, bit_cycles: int) -> None:
        self._bit_cycles = bit_cycles
        super().__init__({"byte": In(8), "load": In(1), "is_ready": Out(1), "tx": Out(1, init=1)})

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for."""
        m = Module()
        rest = Signal(9)
        bits_left = Signal(range(10))
        until_next = Signal(range(self._bit_cycles))
        m.d.comb += self.is_ready.eq((until_next == 0) & (bits_left == 0))
        with m.If(until_next != 0):
            m.d.sync += until_next.eq(until_next - 1)
        with m.Elif(bits_left != 0):
            m.d.sync += [self.tx.eq(rest[0]), rest.eq(rest[1:]), bits_left.eq(bits_left - 1)]
            m.d.sync += until_next.eq(self._bit_cycles - 1)
        with m.Elif(self.load):
            m.d.sync += [self.tx.eq(0), rest.eq(Cat(self.byte, 1)), bits_left.eq(9)]
            m.d.sync += until_next.eq(self._bit_cycles - 1)
        return m


@final
class CommandReceiver(wiring.Component):
    """Commands that arrive whole, and those that do not.

    Attributes
    ----------
    rx : in
        The line.
    command : out
        Holds still from ``is_command`` until the next byte.
    is_command, is_garbled : out
        High for one cycle: a command has arrived; one had a wrong check sum or broke off.
    """

    def __init__(self, *, bit_cycles: int) -> None:
        self._bit_cycles = bit_cycles
        super().__init__({"rx": In(1), "command": Out(COMMAND), "is_command": Out(1), "is_garbled": Out(1)})

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for."""
        m = Module()
        m.submodules.bytes = receiver = ByteReceiver(bit_cycles=self._bit_cycles)
        m.submodules.check_sum = check_sum = CRC16_IBM_3740().create()
        m.d.comb += [receiver.rx.eq(self.rx), check_sum.data.eq(receiver.byte)]
        silence_cycles = SILENCE_BITS * self._bit_cycles
        until_forgotten = Signal(range(silence_cycles))
        received = Signal(range(COMMAND_BYTES))  # bytes of the command that is under way
        fields, is_low_byte_right = self.command.as_value(), Signal()
        m.d.sync += [self.is_command.eq(0), self.is_garbled.eq(0)]
        with m.If(receiver.is_byte):
            m.d.sync += received.eq(received + 1)
        with m.If(receiver.is_byte), m.Switch(received):
            with m.Case(0):
                m.d.comb += [check_sum.start.eq(1), check_sum.valid.eq(1)]
                with m.If(receiver.byte != COMMAND_START):
                    m.d.sync += received.eq(0)
            with m.Case(COMMAND_BYTES - 2):
                m.d.sync += is_low_byte_right.eq(receiver.byte == check_sum.crc[:8])
            with m.Case(COMMAND_BYTES - 1):
                is_right = is_low_byte_right & (receiver.byte == check_sum.crc[8:])
                m.d.sync += [self.is_command.eq(is_right), self.is_garbled.eq(~is_right), received.eq(0)]
            with m.Default():
                m.d.comb += check_sum.valid.eq(1)
                m.d.sync += fields.eq(Cat(fields[8:], receiver.byte))
        with m.If((received == 0) | ~receiver.is_idle):
            m.d.sync += until_forgotten.eq(silence_cycles - 1)
        with m.Elif(until_forgotten != 0):
            m.d.sync += until_forgotten.eq(until_forgotten - 1)
        with m.Else():
            m.d.sync += [received.eq(0), self.is_garbled.eq(1)]
        return m


@final
class MessageSender(wiring.Component):
    """Replies and records, a reply first. Messages and their bytes follow each other without a gap.

    A record leaves the queue in the very cycle in which it is found to wait, the one before the line begins with it: a queue
    that is cleared meanwhile cannot give what it no longer has.

    Attributes
    ----------
    reply, reply_waits : in
        Held until ``takes_reply``, which is high in the cycle in which the line begins with it.
    record, record_waits : in
        ``record`` is read in the cycle after ``pops_record``.
    tx : out
        The line.
    """

    def __init__(self, *, bit_cycles: int) -> None:
        self._bit_cycles = bit_cycles
        super().__init__(
            {
                "reply": In(REPLY),
                "reply_waits": In(1),
                "takes_reply": Out(1),
                "record": In(RECORD),
                "record_waits": In(1),
                "pops_record": Out(1),
                "tx": Out(1, init=1),
            }
        )

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for."""
        m = Module()
        m.submodules.bytes = sender = ByteSender(bit_cycles=self._bit_cycles)
        m.submodules.check_sum = check_sum = CRC16_IBM_3740().create()
        rest = Signal(RECORD.size)
        left = Signal(range(RECORD_BYTES))  # bytes of ``rest`` after the next one
        m.d.comb += [self.tx.eq(sender.tx), check_sum.data.eq(sender.byte), sender.byte.eq(rest[:8])]
        with m.FSM():
            with m.State("IDLE"), m.If(sender.is_ready & (self.reply_waits | self.record_waits)):
                m.d.comb += [sender.load.eq(1), sender.byte.eq(Mux(self.reply_waits, REPLY_START, RECORD_START))]
                m.d.comb += [check_sum.start.eq(1), check_sum.valid.eq(1)]
                m.d.comb += self.pops_record.eq(~self.reply_waits)
                m.next = "TAKE RECORD"
                with m.If(self.reply_waits):
                    m.next = "TAKE REPLY"
            with m.State("TAKE REPLY"):
                m.d.comb += self.takes_reply.eq(1)
                m.d.sync += [rest.eq(self.reply), left.eq(REPLY_BYTES - 4)]
                m.next = "FIELDS"
            with m.State("TAKE RECORD"):
                m.d.sync += [rest.eq(self.record), left.eq(RECORD_BYTES - 4)]
                m.next = "FIELDS"
            with m.State("FIELDS"), m.If(sender.is_ready):
                m.d.comb += [sender.load.eq(1), check_sum.valid.eq(1)]
                m.d.sync += [rest.eq(rest[8:]), left.eq(left - 1)]
                with m.If(left == 0):
                    m.next = "TAKE CHECK SUM"
            with m.State("TAKE CHECK SUM"):
                m.d.sync += [rest.eq(check_sum.crc), left.eq(1)]
                m.next = "CHECK SUM"
            with m.State("CHECK SUM"), m.If(sender.is_ready):
                m.d.comb += sender.load.eq(1)
                m.d.sync += [rest.eq(rest[8:]), left.eq(left - 1)]
                with m.If(left == 0):
                    m.next = "IDLE"
        return m


@final
class SerialLink(wiring.Component):
    """Commands in, replies and records out, over one line each way.

    Attributes
    ----------
    rx, tx
        The lines.
    command, is_command : out
        Whole commands; never one while a reply waits.
    reply, is_reply : in
        ``is_reply`` is high for one cycle, at most some bit times after ``is_command``.
    record, record_waits, pops_record
        As in `MessageSender`.
    garbled : out, 32 bits
        Commands that were not whole, or came while a reply waited.
    """

    def __init__(self, *, bit_cycles: int) -> None:
        self._bit_cycles = bit_cycles
        super().__init__(
            {
                "rx": In(1),
                "tx": Out(1, init=1),
                "command": Out(COMMAND),
                "is_command": Out(1),
                "reply": In(REPLY),
                "is_reply": In(1),
                "record": In(RECORD),
                "record_waits": In(1),
                "pops_record": Out(1),
                "garbled": Out(32),
            }
        )

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for."""
        m = Module()
        m.submodules.receiver = receiver = CommandReceiver(bit_cycles=self._bit_cycles)
        m.submodules.sender = sender = MessageSender(bit_cycles=self._bit_cycles)
        m.submodules.garbled = garbled = SaturatingCounter()
        m.d.comb += [
            receiver.rx.eq(self.rx),
            self.tx.eq(sender.tx),
            self.command.eq(receiver.command),
            self.is_command.eq(receiver.is_command & ~sender.reply_waits),
            garbled.event.eq(receiver.is_garbled | (receiver.is_command & sender.reply_waits)),
            self.garbled.eq(garbled.count),
            sender.record.eq(self.record),
            sender.record_waits.eq(self.record_waits),
            self.pops_record.eq(sender.pops_record),
        ]
        with m.If(sender.takes_reply):
            m.d.sync += sender.reply_waits.eq(0)
        with m.If(self.is_reply):
            m.d.sync += [sender.reply.eq(self.reply), sender.reply_waits.eq(1)]
        return m
