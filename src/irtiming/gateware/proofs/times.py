"""Proof about times: every edge on a pin becomes one event with the right time, and nothing else does."""

from typing import Any, final

from amaranth.asserts import AnySeq
from amaranth.hdl import Cat, Mux, Signal

from irtiming.gateware.proofs.bench import Bench, Parts, implies, inner_signals, opened
from irtiming.gateware.register_map import Channel, Polarity

_LONG = 259  # cycles: more than the longest filter


@final
class CyclesAreCounted(Bench):
    """The counter, of 48 bits or fewer."""

    def __init__(self, parts: Parts, *, bits: int) -> None:
        super().__init__()
        counter = parts["edge_timestamper"].Counter(bits=bits)
        self.m.submodules.counter = fragment = opened(counter)
        cycle = Signal(bits)
        self.m.d.sync += cycle.eq(cycle + 1)
        self.claim(counter.value == cycle)
        self.claim(inner_signals(fragment)["carry"] == cycle[: bits // 2].all())
        self.cover(counter.value == 5)


@final
class TimesOfEdges(Bench):
    """Any signals on the pins, any filter, polarity and channels; the filter changes only while no line has just moved."""

    def __init__(self, parts: Parts) -> None:
        super().__init__()
        m = self.m
        self._stamper = stamper = parts["edge_timestamper"].EdgeTimestamper()
        m.submodules.stamper = self._fragment = opened(stamper)
        pins = {
            Polarity.CAMERA_INPUT: stamper.camera_in,
            Polarity.CONTROL_SLOT: stamper.control_in,
            Polarity.APPLICATION_SLOT: stamper.application_in,
            Polarity.SPARE: stamper.spare_in,
        }
        own = (stamper.camera_trigger, stamper.camera_trigger_delayed)
        settings = (stamper.polarity, stamper.channels, stamper.filter, stamper.is_recording)
        for port in (*own, *pins.values(), *settings):
            m.d.comb += port.eq(AnySeq(port.shape()))
        self._filter_then = self.then(stamper.filter, "filter")
        self._is_first = Signal(init=1)
        m.d.sync += self._is_first.eq(0)
        events: dict[Channel, Any] = dict(
            zip((Channel.CAMERA_TRIGGER, Channel.CAMERA_TRIGGER_DELAYED), own, strict=True)
        )
        are_long = []
        for polarity, pin in pins.items():
            rises, falls, is_long = self._expect_edges((polarity.name or "").lower(), pin)
            is_inverted = (stamper.polarity & int(polarity)) != 0
            events[Channel[polarity.name or ""]] = Mux(is_inverted, falls, rises)
            if polarity is Polarity.APPLICATION_SLOT:
                events[Channel.APPLICATION_OTHER_EDGE] = Mux(is_inverted, rises, falls)
            are_long.append(is_long)
        self.assume(self._is_first | Cat(are_long).all() | (stamper.filter == self._filter_then))
        self._claim_records(Cat(events[channel] for channel in Channel))

    def _expect_edges(self, name: str, pin: Signal) -> tuple[Signal, Signal, Any]:
        """An edge counts when the line, two cycles late, has had its new level for exactly filter + 1 cycles."""
        m, stamper = self.m, self._stamper
        late, seen = Signal(name=f"{name}_late"), Signal(name=f"{name}_seen")
        before, level = Signal(name=f"{name}_before"), Signal(name=f"{name}_level")
        lasted_before, lasted = Signal(9, name=f"{name}_lasted_before"), Signal(9, name=f"{name}_lasted")
        rises, falls = Signal(name=f"{name}_rises"), Signal(name=f"{name}_falls")
        m.d.sync += [late.eq(pin), seen.eq(late), before.eq(seen), lasted_before.eq(lasted), rises.eq(0), falls.eq(0)]
        m.d.comb += lasted.eq(Mux(seen != before, 1, Mux(lasted_before < _LONG, lasted_before + 1, _LONG)))
        counts = (seen != level) & (lasted == stamper.filter + 1)
        with m.If(counts):
            m.d.sync += [level.eq(seen), rises.eq(seen), falls.eq(~seen)]
        detector = self._fragment.find_subfragment(name)
        inner = inner_signals(detector)
        stages = inner_signals(detector.find_subfragment("synchroniser"))
        self.claim((stages["stage0"] == late) & (stages["stage1"] == seen))
        self.claim(implies(self._is_first, ~seen & ~level))
        self.claim(inner["level"] == level)
        self.claim(inner["rising"] == rises)
        self.claim(inner["falling"] == falls)
        self.claim(implies(seen != level, inner["remaining"] + lasted == stamper.filter + 1))
        return rises, falls, lasted == _LONG

    def _claim_records(self, events: Any) -> None:
        """What happens in a cycle while recording is reported in the next one, with the number of that cycle since reset."""
        m, stamper = self.m, self._stamper
        cycle = Signal(48)
        m.d.sync += cycle.eq(cycle + 1)
        counter = inner_signals(self._fragment.find_subfragment("cycles"))
        self.claim(stamper.counter == cycle)
        self.claim(counter["carry"] == cycle[:24].all())  # carries the induction
        happened = self.then(Mux(stamper.is_recording, events & stamper.channels, 0), "happened")
        self.claim(stamper.happened == happened)
        self.claim(stamper.is_event == happened.any())
        self.claim(self._is_first | (stamper.time == self.then(cycle, "cycle")))
        self.cover((stamper.happened == 0b0101010) & (self._filter_then == 2))
