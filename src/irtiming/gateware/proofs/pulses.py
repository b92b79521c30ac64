"""Proofs about pulses: every edge of a train in its exact cycle, the exact number of them, every pulse of its exact width."""

from typing import Any, final

from amaranth.asserts import AnySeq
from amaranth.hdl import Signal

from irtiming.gateware.proofs.bench import Bench, Parts, implies, inner_signals, opened

_TIME_BITS = 66  # delay + count * period, 32 bits each


@final
class CameraTrain(Bench):
    """A train of camera triggers with any delay, period, count and width; started again and again, stopped at any time."""

    def __init__(self, parts: Parts) -> None:
        super().__init__()
        self._train = parts["pulse_generator"].EdgeTrain()
        self._pulse = parts["pulse_generator"].Pulse()
        self.m.submodules.train = fragment = opened(self._train)
        self._inner = inner_signals(fragment)
        self._is_busy = self._train.is_running | self._pulse.is_high
        self._drive()
        expected = self._expect_edges()
        expect_pulses(self, self._pulse, edge=self._train.edge, polarity_may_change=~self._is_busy)
        self.cover(expected & self._train.is_last & (self._train.count == 3) & (self._train.delay > self._train.period))

    def _drive(self) -> None:
        """START only when nothing runs, settings that stay while something runs: `settings.SafeSettings` proves both."""
        train, pulse = self._train, self._pulse
        settings = (train.delay, train.period, train.count, pulse.width)
        for port in (train.start, train.stop, *settings, pulse.idles_high):
            self.m.d.comb += port.eq(AnySeq(port.shape()))
        self.assume(implies(train.start, ~self._is_busy))
        self.assume((pulse.width >= 1) & (train.period > pulse.width) & (train.count >= 1))
        was_bound = self.then(train.start | self._is_busy, "was_bound")
        for setting in settings:
            self.assume(implies(was_bound, setting == self.then(setting, setting.name)))

    def _expect_edges(self) -> Signal:
        """Edge k at ``delay + k period`` after the start, by counting on; and how that is related to the circuit."""
        m, train = self.m, self._train
        since_start, due = Signal(_TIME_BITS), Signal(_TIME_BITS)
        done = Signal(32)
        is_expecting, expected = Signal(), Signal()
        is_last = done == train.count - 1
        m.d.comb += expected.eq(is_expecting & (since_start == due))
        m.d.sync += since_start.eq(since_start + 1)
        with m.If(expected):
            m.d.sync += [due.eq(due + train.period), done.eq(done + 1), is_expecting.eq(~is_last)]
        with m.If(train.start):
            m.d.sync += [since_start.eq(0), due.eq(train.delay), done.eq(0), is_expecting.eq(1)]
        with m.If(train.stop):
            m.d.sync += is_expecting.eq(0)
        self.claim(train.edge == expected)
        self.claim(train.is_last == (expected & is_last))
        self.claim(train.is_running == is_expecting)
        self.claim(implies(is_expecting, (since_start <= due) & (due[32:] <= done)))  # so ``due`` never wraps
        self.claim(implies(is_expecting, due - since_start == _counted(self._inner["until_edge"]) + 1))
        self.claim(implies(is_expecting, done < train.count))
        self.claim(implies(is_expecting, _counted(self._inner["until_last"]) == train.count - done - 2))
        return expected


@final
class ChopperTrain(Bench):
    """The chopper's reference: endless, from reset on; period and width may change in any cycle."""

    def __init__(self, parts: Parts) -> None:
        super().__init__()
        m = self.m
        train, pulse = parts["pulse_generator"].EdgeTrain(is_endless=True), parts["pulse_generator"].Pulse()
        m.submodules.train = fragment = opened(train)
        inner = inner_signals(fragment)
        for port in (train.start, train.stop, train.period, pulse.width, pulse.idles_high):
            m.d.comb += port.eq(AnySeq(port.shape()))
        self.assume((pulse.width >= 1) & (train.period > pulse.width))
        until_due = Signal(32)
        m.d.sync += until_due.eq(until_due - 1)
        with m.If(until_due == 0):
            m.d.sync += until_due.eq(train.period - 1)
        self.claim(train.edge == (until_due == 0))
        self.claim(_counted(inner["until_edge"]) == until_due - 1)
        expect_pulses(self, pulse, edge=train.edge, polarity_may_change=1)
        edges = Signal(2)
        with m.If(train.edge):
            m.d.sync += edges.eq(edges + 1)
        self.cover(train.edge & (edges == 3) & (self.then(train.period, "period") != train.period))


def expect_pulses(bench: Bench, pulse: Any, *, edge: Any, polarity_may_change: Any) -> None:
    """Claim that the pin is active for exactly ``width`` cycles after each edge, and at no other time.

    Parameters
    ----------
    bench
        Where to claim it; the pulse becomes part of it.
    pulse
        Its width comes from the bench.
    edge
        Begins a pulse.
    polarity_may_change
        Whether the idle level may change in this cycle.
    """
    m = bench.m
    m.submodules.pulse = fragment = opened(pulse)
    inner = inner_signals(fragment)
    m.d.comb += pulse.edge.eq(edge)
    idles_high_then = bench.then(pulse.idles_high, "idles_high")
    bench.assume(polarity_may_change | (pulse.idles_high == idles_high_then))
    left = Signal(32)
    with m.If(edge):
        m.d.sync += left.eq(pulse.width)
    with m.Elif(left != 0):
        m.d.sync += left.eq(left - 1)
    is_active = left != 0
    bench.claim(pulse.is_high == is_active)
    bench.claim(pulse.pin == (is_active ^ idles_high_then))
    bench.claim(implies(is_active, _counted(inner["until_end"]) == left - 2))


def _counted(counter: Signal) -> Any:
    """A counter that ends at -1."""
    return counter.as_signed()
