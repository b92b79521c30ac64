"""Proof about the queue: what is written leaves as it came, in order, or its loss is reported three times."""

from typing import final

from amaranth.asserts import AnySeq
from amaranth.hdl import Cat, Mux, Signal

from irtiming.gateware.proofs.bench import Bench, Parts, elaborated, implies, inner_signals, opened

_LARGEST = 2**32 - 1


@final
class RecordsAreKept(Bench):
    """Any writes, pops and clears; one record, any one, is watched from its write to its pop."""

    def __init__(self, parts: Parts, *, depth: int) -> None:
        super().__init__()
        self._depth = depth
        self._queue = queue = parts["timestamp_queue"].TimestampQueue(depth=depth)
        module = elaborated(queue)
        memory = module.submodules.records
        self._into, self._out_of = memory.write_ports[0], memory.read_ports[0]
        self._probe = memory.read_port(domain="comb")  # lets the bench look at a place in the memory
        self.m.submodules.queue = fragment = opened(module)
        self._inner = inner_signals(fragment) | inner_signals(fragment.find_subfragment("losses"))
        for port in (queue.write, queue.channels, queue.time, queue.pop, queue.clear):
            self.m.d.comb += port.eq(AnySeq(port.shape()))
        self.assume(implies(queue.pop, ~queue.is_empty))
        self._waiting = Signal(range(depth + 1))
        self._is_kept, self._is_lost, self._is_after_loss = Signal(), Signal(), Signal()
        self._account()
        self._watch()

    def _account(self) -> None:
        """Room is used to the last place; what finds none is counted and flagged."""
        m, queue = self.m, self._queue
        written, lost = Signal(32), Signal(64)
        m.d.comb += [
            self._is_kept.eq(queue.write & (self._waiting < self._depth)),
            self._is_lost.eq(queue.write & (self._waiting == self._depth)),
        ]
        m.d.sync += self._waiting.eq(self._waiting + self._is_kept - queue.pop)
        with m.If(self._is_kept):
            m.d.sync += [written.eq(written + 1), self._is_after_loss.eq(0)]
        with m.If(self._is_lost & (lost != 2**64 - 1)):
            m.d.sync += lost.eq(lost + 1)
        with m.If(self._is_lost):
            m.d.sync += self._is_after_loss.eq(1)
        with m.If(queue.clear):
            m.d.sync += [self._waiting.eq(0), written.eq(0), lost.eq(0), self._is_after_loss.eq(0)]
        self.claim(queue.is_empty == (self._waiting == 0))
        self.claim(queue.written == written)
        self.claim(queue.lost == Mux(lost < _LARGEST, lost, _LARGEST))
        self.claim(queue.is_lossy == (lost != 0))
        self.claim(self._waiting <= self._depth)
        self.claim(self._inner["waiting"] == self._waiting)
        self.claim(self._inner["next_is_after_loss"] == self._is_after_loss)
        self.claim(self._inner["counted"] == Mux(lost < _LARGEST + 1, lost, _LARGEST + 1))
        self.claim((self._into.addr - self._out_of.addr - self._waiting) % self._depth == 0)

    def _watch(self) -> None:
        """Everything about one kept record, chosen freely; what holds for it holds for all."""
        m, queue = self.m, self._queue
        content = Cat(queue.channels, self._is_after_loss, queue.written[:16], queue.time)
        watched = Signal(len(content))
        is_watching, is_leaving, has_left = Signal(), Signal(), Signal()
        ahead = Signal(range(self._depth + 1))  # records that leave before it
        place = Signal(range(self._depth))
        m.d.comb += [is_leaving.eq(is_watching & queue.pop & (ahead == 0)), self._probe.addr.eq(place)]
        m.d.sync += has_left.eq(is_leaving)
        with m.If(is_watching & queue.pop):
            m.d.sync += [ahead.eq(ahead - 1), is_watching.eq(~is_leaving)]
        with m.Elif(~is_watching & AnySeq(1) & self._is_kept):
            m.d.sync += [watched.eq(content), is_watching.eq(1), place.eq(self._into.addr)]
            m.d.sync += ahead.eq(self._waiting - queue.pop)
        with m.If(queue.clear):
            m.d.sync += is_watching.eq(0)
        self.claim(implies(has_left, queue.record.as_value() == watched))
        self.claim(implies(is_watching, ahead < self._waiting))
        self.claim(implies(is_watching, (self._out_of.addr + ahead - place) % self._depth == 0))
        self.claim(implies(is_watching, self._probe.data.as_value() == watched))
        self.cover(has_left & queue.record.is_after_loss & (queue.lost == 2) & (queue.channels != watched[:7]))
