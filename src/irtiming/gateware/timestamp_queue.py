"""Records that wait for the line, in block memory, and the account of those that found no room."""

from typing import final

from amaranth.hdl import Module, Signal
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from irtiming.errors import GatewareError

RECORD = data.StructLayout({"channels": 7, "is_after_loss": 1, "number": 16, "time": 48})
"""Bytes 1 to 9 of a record's message."""


def require_depth(depth: int) -> None:
    """Nothing, if a queue can hold so many records.

    Parameters
    ----------
    depth
        Of the queue.

    Raises
    ------
    GatewareError
        If not.
    """
    if depth < 2 or depth & (depth - 1):
        raise GatewareError(f"a queue of {depth} records; its depth must be a power of two, 2 or more")


@final
class SaturatingCounter(wiring.Component):
    """Counts cycles in which ``event`` is high; stays at its largest value."""

    def __init__(self, *, bits: int = 32) -> None:
        self._bits = bits
        super().__init__({"event": In(1), "clear": In(1), "count": Out(bits)})

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for."""
        m = Module()
        counted = Signal(self._bits + 1)
        is_over = counted[self._bits]
        m.d.comb += self.count.eq(counted[: self._bits] | is_over.replicate(self._bits))
        with m.If(self.event & ~is_over):
            m.d.sync += counted.eq(counted + 1)
        with m.If(self.clear):
            m.d.sync += counted.eq(0)
        return m


@final
class TimestampQueue(wiring.Component):
    """First in, first out. A record that comes while ``depth`` others wait is lost, and never in silence.

    Attributes
    ----------
    write : in
        The events of one cycle, ``channels`` (7 bits) at ``time`` (48 bits), are to be kept.
    pop : in
        Only while not ``is_empty``: the oldest record leaves; from the next cycle on ``record`` holds it until the next pop.
    clear : in
        Empties the queue, forgets losses, numbers records from 0.
    is_empty : out
        No record waits.
    record : out
        The record that left last.
    written, lost : out, 32 bits
        Records since ``clear``; ``lost`` stays at its largest value.
    is_lossy : out
        A record was lost since ``clear``.
    """

    def __init__(self, *, depth: int) -> None:
        self.depth = depth
        super().__init__(
            {
                "write": In(1),
                "channels": In(7),
                "time": In(48),
                "pop": In(1),
                "clear": In(1),
                "is_empty": Out(1),
                "record": Out(RECORD),
                "written": Out(32),
                "lost": Out(32),
                "is_lossy": Out(1),
            }
        )

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for."""
        require_depth(self.depth)
        m = Module()
        m.submodules.records = records = Memory(shape=RECORD, depth=self.depth, init=[])
        m.submodules.losses = losses = SaturatingCounter()
        into, out_of = records.write_port(), records.read_port()
        waiting = Signal(range(self.depth + 1))  # its highest bit is set only when the queue is full
        is_kept, is_lost, next_is_after_loss = Signal(), Signal(), Signal()
        m.d.comb += [
            is_kept.eq(self.write & ~waiting[-1]),
            is_lost.eq(self.write & waiting[-1]),
            into.en.eq(is_kept),
            into.data.channels.eq(self.channels),
            into.data.is_after_loss.eq(next_is_after_loss),
            into.data.number.eq(self.written[:16]),
            into.data.time.eq(self.time),
            out_of.en.eq(self.pop),
            self.record.eq(out_of.data),
            self.is_empty.eq(waiting == 0),
            losses.event.eq(is_lost),
            losses.clear.eq(self.clear),
            self.lost.eq(losses.count),
        ]
        m.d.sync += waiting.eq(waiting + is_kept - self.pop)
        with m.If(is_kept):
            m.d.sync += [self.written.eq(self.written + 1), into.addr.eq(into.addr + 1), next_is_after_loss.eq(0)]
        with m.If(is_lost):
            m.d.sync += [self.is_lossy.eq(1), next_is_after_loss.eq(1)]
        with m.If(self.pop):
            m.d.sync += out_of.addr.eq(out_of.addr + 1)
        with m.If(self.clear):
            m.d.sync += [waiting.eq(0), self.written.eq(0), into.addr.eq(0), out_of.addr.eq(0)]
            m.d.sync += [self.is_lossy.eq(0), next_is_after_loss.eq(0)]
        return m
