"""Pulses at exact cycles: a train of edges, and the pulse that begins with each edge.

Both count down to -1 and look at the sign: no comparison of 32 bits lies in the path of a clock cycle.
"""

from typing import final

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

_SIGN = 32


@final
class EdgeTrain(wiring.Component):
    """Edges ``period`` cycles apart, the first one ``delay`` cycles after the cycle that follows ``start``.

    Started in cycle s, edge k comes in cycle s + 1 + delay + k period, for k below ``count``. A train that is endless
    starts itself at reset, with edge 0 in cycle 0; its ``period`` may change and holds from the next edge on.

    Attributes
    ----------
    start, stop : in
        High for one cycle. No edge comes after the cycle of ``stop``.
    delay, period, count : in, 32 bits
        Constant while the train runs; period >= 2, count >= 1.
    edge, is_last : out
        High in the cycle of an edge; of the last one.
    is_running : out
        Edges are still to come.
    """

    def __init__(self, *, is_endless: bool = False) -> None:
        self._is_endless = is_endless
        super().__init__(
            {
                "start": In(1),
                "stop": In(1),
                "delay": In(32),
                "period": In(32),
                "count": In(32),
                "edge": Out(1),
                "is_last": Out(1),
                "is_running": Out(1, init=is_endless),
            }
        )

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for."""
        m = Module()
        until_edge = Signal(33, init=-1 if self._is_endless else 0)  # cycles, less one
        until_last = Signal(33)  # edges, less one
        m.d.comb += self.edge.eq(self.is_running & until_edge[_SIGN])
        m.d.sync += until_edge.eq(until_edge - 1)
        with m.If(self.edge):
            m.d.sync += until_edge.eq(self.period - 2)
        if self._is_endless:
            return m
        m.d.comb += self.is_last.eq(self.edge & until_last[_SIGN])
        with m.If(self.edge):
            m.d.sync += [until_last.eq(until_last - 1), self.is_running.eq(~self.is_last)]
        with m.If(self.start):
            m.d.sync += [until_edge.eq(self.delay - 1), until_last.eq(self.count - 2), self.is_running.eq(1)]
        with m.If(self.stop):
            m.d.sync += self.is_running.eq(0)
        return m


@final
class Pulse(wiring.Component):
    """One pulse of ``width`` cycles on a pin for each edge: an edge in cycle n makes the pin active from cycle n + 1 on.

    Attributes
    ----------
    edge : in
        At least ``width`` + 1 cycles after the one before.
    width : in, 32 bits
        At least 1; read in the cycle of the edge.
    idles_high : in
        Polarity of the pin.
    is_high : out
        The pulse runs.
    pin : out
        A register, so that it does not glitch.
    """

    def __init__(self) -> None:
        super().__init__({"edge": In(1), "width": In(32), "idles_high": In(1), "is_high": Out(1), "pin": Out(1)})

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for."""
        m = Module()
        until_end = Signal(33)  # cycles, less one
        goes_on = Signal()
        m.d.comb += goes_on.eq(self.edge | (self.is_high & ~until_end[_SIGN]))
        m.d.sync += [until_end.eq(until_end - 1), self.is_high.eq(goes_on), self.pin.eq(goes_on ^ self.idles_high)]
        with m.If(self.edge):
            m.d.sync += until_end.eq(self.width - 2)
        return m
