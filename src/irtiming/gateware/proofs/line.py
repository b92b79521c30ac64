"""Proofs about what lies between the serial line and the rest: what `settings` and `queue` assume of it."""

from typing import final

from amaranth.asserts import AnySeq

from irtiming.gateware.proofs.bench import Bench, Parts, implies
from irtiming.gateware.proofs.settings import REPLY_CYCLES

_BIT_CYCLES = 24  # of the slowest board's clock


@final
class CalmLine(Bench):
    """The serial link and the queue, with any signal on the line, any writes, an ARM at any time."""

    def __init__(self, parts: Parts) -> None:
        super().__init__()
        m = self.m
        m.submodules.queue = queue = parts["timestamp_queue"].TimestampQueue(depth=4)
        m.submodules.link = link = parts["serial_link"].SerialLink(bit_cycles=_BIT_CYCLES)
        for port in (link.rx, queue.write, queue.channels, queue.time, queue.clear):
            m.d.comb += port.eq(AnySeq(port.shape()))
        age = self.age(link.is_command, cycles=REPLY_CYCLES)
        m.d.comb += [
            link.reply.as_value().eq(AnySeq(len(link.reply.as_value()))),
            link.is_reply.eq(age == REPLY_CYCLES),
            link.record.eq(queue.record),
            link.record_waits.eq(~queue.is_empty),
            queue.pop.eq(link.pops_record),
        ]
        self.claim(implies(age != 0, ~link.is_command))
        self.claim(implies(age != 0, link.command.as_value() == self.then(link.command.as_value(), "command")))
        self.claim(implies(queue.pop, ~queue.is_empty))
        self.cover(queue.pop)
