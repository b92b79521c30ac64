"""Proof about settings: none that is accepted makes a circuit that misbehaves, and none changes while a measurement runs."""

from typing import final

from amaranth.asserts import AnySeq
from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from irtiming.gateware.messages import Operation
from irtiming.gateware.proofs.bench import Bench, Parts, elaborated, implies, inner_signals, opened
from irtiming.gateware.register_map import ADDRESS, REGISTERS, Refusal, Status

REPLY_CYCLES = 5
"""From a command to its reply."""

_COMMITTED = {"chopper_width": "chopper_period", "camera_width": "camera_period"}
_WRITTEN_BY = {f"held_{width}": width for width in _COMMITTED} | _COMMITTED


@final
class AnyLine(wiring.Component):
    """In the place of the serial link: any commands, one at a time, that hold still until their reply; see `line`."""

    def __init__(self, parts: Parts) -> None:
        link = parts["serial_link"]
        super().__init__(
            {
                "rx": In(1),
                "tx": Out(1),
                "command": Out(link.COMMAND),
                "is_command": Out(1),
                "reply": In(link.REPLY),
                "is_reply": In(1),
                "record": In(parts["timestamp_queue"].RECORD),
                "record_waits": In(1),
                "pops_record": Out(1),
                "garbled": Out(32),
                "awaits_reply": Out(1),
            }
        )

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for."""
        m = Module()
        kept = Signal.like(self.command.as_value())
        m.d.comb += [
            self.is_command.eq(AnySeq(1) & ~self.awaits_reply),
            self.command.as_value().eq(kept),
            self.pops_record.eq(AnySeq(1) & self.record_waits),
            self.garbled.eq(AnySeq(32)),
        ]
        with m.If(self.is_command):
            m.d.comb += self.command.as_value().eq(AnySeq(kept.shape()))
            m.d.sync += [kept.eq(self.command.as_value()), self.awaits_reply.eq(1)]
        with m.Elif(self.is_reply):
            m.d.sync += self.awaits_reply.eq(0)
        return m


@final
class SafeSettings(Bench):
    """The whole generator; any commands in place of the serial line, any signals on the pins."""

    def __init__(self, parts: Parts) -> None:
        super().__init__()
        self._line = line = AnyLine(parts)
        top = parts["trigger_generator"]
        vars(top)["SerialLink"] = lambda bit_cycles: line
        generator = top.TriggerGenerator(queue_depth=4)
        module = elaborated(generator)
        self.m.submodules.generator = fragment = opened(module)
        self._inside = inside = module.submodules
        self._registers = registers = inside.registers
        self._judge = inner_signals(fragment.find_subfragment("registers"))
        for pin in (generator.camera_in, generator.control_in, generator.application_in, generator.spare_in):
            self.m.d.comb += pin.eq(AnySeq(1))
        self._is_busy = (registers.status & int(Status.ARMED | Status.TRIGGERING)) != 0
        self._is_running = inside.nominal.is_running | inside.delayed.is_running | inside.camera_pulse.is_high
        self._claim_safe_values()
        self._claim_stillness()
        self._claim_honest_replies()
        self._claim_wiring()
        self.cover(inside.camera_pulse.is_high & (registers.status == int(Status.ARMED | Status.TRIGGERING)))
        self.cover(registers.is_reply & (registers.camera_period == 3) & (registers.camera_width == 2))

    def _claim_safe_values(self) -> None:
        """What the pulse generators are promised of their inputs."""
        r = self._registers
        self.claim((r.chopper_width >= 1) & (r.chopper_period > r.chopper_width))
        self.claim((r.camera_width >= 1) & (r.camera_period > r.camera_width) & (r.camera_count >= 1))
        self.claim((r.held_chopper_width >= 1) & (r.held_camera_width >= 1))
        self.claim(implies(r.start, ~self._is_running & r.status[0]))
        self.claim(implies(r.arm, ~self._is_busy))
        self.claim(implies(r.arm, (r.held_chopper_width == r.chopper_width) & (r.held_camera_width == r.camera_width)))

    def _claim_stillness(self) -> None:
        """From ARM to STOP, and as long as a train runs, no setting changes."""
        r = self._registers
        was_bound = self.then(self._is_busy | r.arm | r.start, "was_bound")
        for name, port in self._settings().items():
            self.claim(implies(was_bound, port == self.then(port, name, init=port.init)))

    def _claim_honest_replies(self) -> None:
        """A refused command changes nothing; the reply to a setting holds what the register now is."""
        m, r = self.m, self._registers
        age = self.age(r.is_command, cycles=REPLY_CYCLES)
        self.claim(r.is_reply == (age == REPLY_CYCLES))
        self.claim(self._line.awaits_reply == (age != 0))
        self.claim(self._judge["fsm_state"] == Mux(age == REPLY_CYCLES, 0, age))
        is_write = r.command.operation == Operation.WRITE
        is_done = is_write & (r.reply.refusal == Refusal.NONE)
        for name, port in self._settings().items():
            before = Signal.like(port, name=f"{name}_before")
            with m.If(r.is_command):
                m.d.sync += before.eq(port)
            is_named = r.command.address == ADDRESS[_WRITTEN_BY.get(name, name).upper()]
            self.claim(implies(r.is_reply & ~(is_done & is_named), port == before))
            if name not in _COMMITTED:
                self.claim(implies(r.is_reply & is_named, r.reply.value == port))
                self.claim(implies(r.is_reply & is_named & is_done, port == r.command.value))

    def _claim_wiring(self) -> None:
        """Nominal and delayed train differ by the delay alone; no trigger leaves without a record of its cycle."""
        r, inside = self._registers, self._inside
        nominal, delayed, queue = inside.nominal, inside.delayed, inside.queue
        self.claim((nominal.delay == 0) & (delayed.delay == r.camera_delay))
        for train in (nominal, delayed):
            self.claim((train.period == r.camera_period) & (train.count == r.camera_count))
            self.claim((train.start == r.start) & (train.stop == r.stop))
        self.claim((inside.camera_pulse.edge == delayed.edge) & (inside.camera_pulse.width == r.camera_width))
        self.claim((inside.chopper_pulse.edge == inside.chopper.edge) & (inside.chopper.period == r.chopper_period))
        is_armed = r.status[0]
        self.claim(implies(nominal.is_running | delayed.is_running, is_armed))
        happened = self.then(Cat(nominal.edge, delayed.edge) & r.channels[:2], "happened")
        self.claim(implies(happened.any(), queue.write))
        self.claim(queue.channels[:2] == happened)
        self.claim(queue.time == self.then(inside.timestamper.counter, "counter"))

    def _settings(self) -> dict[str, Signal]:
        """All that a command may change; widths twice: as written, and as they hold since the last period."""
        names = [register.name.lower() for register in REGISTERS if register.access == "setting"]
        return {name: getattr(self._registers, name) for name in dict.fromkeys((*names, *_WRITTEN_BY))}
