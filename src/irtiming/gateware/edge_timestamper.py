"""From pins to events with a time: synchroniser, glitch filter, 48-bit counter, channels."""

from typing import final

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from irtiming.gateware.register_map import Channel, Polarity


@final
class EdgeDetector(wiring.Component):
    """Edges of one asynchronous pin whose new level lasts.

    A pin that changes during cycle n is taken in by the clock edge that begins cycle n + 1; ``rising`` or ``falling`` is
    high in cycle n + 3 + ``filter``, if the level stays that long.

    Attributes
    ----------
    pin : in
        Asynchronous.
    filter : in, 8 bits
        Further cycles for which a new level must last.
    rising, falling : out
        High for one cycle.
    """

    def __init__(self) -> None:
        super().__init__({"pin": In(1), "filter": In(8), "rising": Out(1), "falling": Out(1)})

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for."""
        m = Module()
        seen, level = Signal(), Signal()
        remaining = Signal(8)
        m.submodules.synchroniser = FFSynchronizer(self.pin, seen)
        m.d.sync += [self.rising.eq(0), self.falling.eq(0), remaining.eq(self.filter)]
        with m.If(seen != level):
            with m.If(remaining == 0):
                m.d.sync += [level.eq(seen), self.rising.eq(seen), self.falling.eq(~seen)]
            with m.Else():
                m.d.sync += remaining.eq(remaining - 1)
        return m


@final
class Counter(wiring.Component):
    """Cycles since reset, in two halves: the carry between them is a register, known a cycle ahead."""

    def __init__(self, *, bits: int = 48) -> None:
        self._half = bits // 2
        super().__init__({"value": Out(2 * self._half)})

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for."""
        m = Module()
        low, high, carry = Signal(self._half), Signal(self._half), Signal()
        m.d.sync += [low.eq(low + 1), carry.eq(low == 2**self._half - 2), high.eq(high + carry)]
        m.d.comb += self.value.eq(Cat(low, high))
        return m


@final
class EdgeTimestamper(wiring.Component):
    """All events of one cycle with its time, one cycle later.

    Attributes
    ----------
    camera_trigger, camera_trigger_delayed : in
        Edges of the generator's own, high in their cycle.
    camera_in, control_in, application_in, spare_in : in
        Asynchronous pins.
    polarity, channels, filter : in
        As the registers of these names.
    is_recording : in
        Events of cycles in which it is low do not count.
    counter : out, 48 bits
        Of the running cycle.
    is_event : out
        ``happened`` (7 bits as in `Channel`) and ``time`` (48 bits) hold the events of the cycle before.
    """

    def __init__(self) -> None:
        super().__init__(
            {
                "camera_trigger": In(1),
                "camera_trigger_delayed": In(1),
                "camera_in": In(1),
                "control_in": In(1),
                "application_in": In(1),
                "spare_in": In(1),
                "polarity": In(7),
                "channels": In(7),
                "filter": In(8),
                "is_recording": In(1),
                "counter": Out(48),
                "is_event": Out(1),
                "happened": Out(7),
                "time": Out(48),
            }
        )

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for."""
        m = Module()
        m.submodules.cycles = cycles = Counter()
        edges = {
            Channel.CAMERA_TRIGGER: self.camera_trigger,
            Channel.CAMERA_TRIGGER_DELAYED: self.camera_trigger_delayed,
        }
        for polarity, pin in (
            (Polarity.CAMERA_INPUT, self.camera_in),
            (Polarity.CONTROL_SLOT, self.control_in),
            (Polarity.APPLICATION_SLOT, self.application_in),
            (Polarity.SPARE, self.spare_in),
        ):
            name = (polarity.name or "").lower()
            m.submodules[name] = detector = EdgeDetector()
            m.d.comb += [detector.pin.eq(pin), detector.filter.eq(self.filter)]
            falls = (self.polarity & int(polarity)) != 0
            edge, other_edge = Signal(name=f"{name}_edge"), Signal(name=f"{name}_other_edge")
            m.d.comb += [edge.eq(detector.falling), other_edge.eq(detector.rising)]
            with m.If(~falls):
                m.d.comb += [edge.eq(detector.rising), other_edge.eq(detector.falling)]
            edges[Channel[polarity.name or ""]] = edge
            if polarity == Polarity.APPLICATION_SLOT:
                edges[Channel.APPLICATION_OTHER_EDGE] = other_edge
        counts = Signal(7)
        m.d.comb += counts.eq(Cat(edges[channel] for channel in Channel) & self.channels)
        m.d.comb += [self.counter.eq(cycles.value), self.is_event.eq(self.happened.any())]
        m.d.sync += [self.happened.eq(0), self.time.eq(cycles.value)]
        with m.If(self.is_recording):
            m.d.sync += self.happened.eq(counts)
        return m
