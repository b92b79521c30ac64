"""The registers behind the serial line: what a command reads, changes, and why it is refused."""

from typing import final

from amaranth.hdl import Module, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from irtiming.gateware.messages import Operation
from irtiming.gateware.register_map import ADDRESS, REGISTERS, Command, Refusal, Register, Status, at_reset
from irtiming.gateware.serial_link import COMMAND, REPLY

_SETTINGS = tuple(register for register in REGISTERS if register.access == "setting")
_WIDTH_OF = {"CHOPPER_PERIOD": "CHOPPER_WIDTH", "CAMERA_PERIOD": "CAMERA_WIDTH"}


def _bits(register: Register) -> int:
    return register.highest.bit_length()


@final
class RegisterFile(wiring.Component):
    """Does one command in five cycles.

    The ports named like a setting hold its value; those of widths, the one that came with the last period
    (``held_chopper_width``, ``held_camera_width`` are what reads back).

    Attributes
    ----------
    command, is_command : in
        ``command`` must hold still until ``is_reply``.
    reply, is_reply : out
        ``is_reply`` is high for one cycle.
    arm, start, stop : out
        High for one cycle.
    status, counter, records_written, records_lost, garbled_commands : in
        What the registers of these names show.
    """

    def __init__(self, *, clock_frequency_hz: int, queue_depth: int) -> None:
        self._at_reset = {r.name: at_reset(r, clock_frequency_hz) for r in REGISTERS}
        self._at_reset["QUEUE_DEPTH"] = queue_depth
        settings = {r.name.lower(): Out(_bits(r), init=self._at_reset[r.name]) for r in _SETTINGS}
        held = {f"held_{w.lower()}": Out(32, init=self._at_reset[w]) for w in _WIDTH_OF.values()}
        super().__init__(
            {
                "command": In(COMMAND),
                "is_command": In(1),
                "reply": Out(REPLY),
                "is_reply": Out(1),
                "arm": Out(1),
                "start": Out(1),
                "stop": Out(1),
                "status": In(len(Status)),
                "counter": In(48),
                "records_written": In(32),
                "records_lost": In(32),
                "garbled_commands": In(32),
                **settings,
                **held,
            }
        )

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for."""
        m = Module()
        refusal = self._refusal(m)
        command, reply = self.command, self.reply
        m.d.sync += [self.is_reply.eq(0), self.arm.eq(0), self.start.eq(0), self.stop.eq(0)]
        m.d.comb += [reply.tag.eq(command.tag), reply.address.eq(command.address)]
        with m.FSM():
            with m.State("IDLE"), m.If(self.is_command):
                m.next = "COMPARE"
            with m.State("COMPARE"):  # the registers of `_refusal` take the new command
                m.next = "JUDGE"
            with m.State("JUDGE"):
                m.d.sync += reply.refusal.eq(refusal)
                m.next = "DO"
            with m.State("DO"):
                with m.If((command.operation == Operation.WRITE) & (reply.refusal == Refusal.NONE)):
                    self._write(m)
                m.next = "READ"
            with m.State("READ"):
                self._read(m)
                m.d.sync += self.is_reply.eq(1)
                m.next = "IDLE"
        return m

    def _held(self, name: str) -> Value:
        """The register that reads back under this name of a setting."""
        return getattr(self, f"held_{name.lower()}" if name in _WIDTH_OF.values() else name.lower())

    def _refusal(self, m: Module) -> Signal:
        """Why the command is refused, from comparisons made in the cycle before."""
        value, address = self.command.value, self.command.address
        is_known, is_setting, is_command, is_in_range = Signal(), Signal(), Signal(), Signal()
        exceeds_width, widths_are_committed = Signal(), Signal()
        is_busy = (self.status & int(Status.ARMED | Status.TRIGGERING)) != 0
        m.d.sync += [is_known.eq(0), is_setting.eq(0), is_command.eq(address == ADDRESS["COMMAND"])]
        m.d.sync += [is_in_range.eq(0), exceeds_width.eq(1)]
        m.d.sync += widths_are_committed.eq(
            (self.held_chopper_width == self.chopper_width) & (self.held_camera_width == self.camera_width)
        )
        with m.Switch(address):
            for register in REGISTERS:
                with m.Case(register.address):
                    m.d.sync += [is_known.eq(1), is_setting.eq(register.access == "setting")]
                    m.d.sync += is_in_range.eq((value >= register.lowest) & (value <= register.highest))
                    if register.name in _WIDTH_OF:
                        m.d.sync += exceeds_width.eq(value > self._held(_WIDTH_OF[register.name]))
        refusal = Signal(Refusal)
        with m.If(~is_known):
            m.d.comb += refusal.eq(Refusal.UNKNOWN_REGISTER)
        with m.Elif(self.command.operation > max(Operation)):
            m.d.comb += refusal.eq(Refusal.BAD_VALUE)
        with m.Elif(self.command.operation == Operation.READ):
            m.d.comb += refusal.eq(Refusal.NONE)
        with m.Elif(~is_setting & ~is_command):
            m.d.comb += refusal.eq(Refusal.READ_ONLY)
        with m.Elif(is_setting & is_busy):
            m.d.comb += refusal.eq(Refusal.BUSY)
        with m.Elif(~is_in_range | ~exceeds_width):
            m.d.comb += refusal.eq(Refusal.BAD_VALUE)
        with m.Elif(is_command):
            self._refuse_command(m, refusal, is_busy=is_busy, widths_are_committed=widths_are_committed)
        return refusal

    def _refuse_command(self, m: Module, refusal: Signal, *, is_busy: Value, widths_are_committed: Value) -> None:
        with m.Switch(self.command.value[:2]):
            with m.Case(Command.ARM):
                with m.If(is_busy):
                    m.d.comb += refusal.eq(Refusal.BUSY)
                with m.Elif(~widths_are_committed):
                    m.d.comb += refusal.eq(Refusal.BAD_VALUE)
            with m.Case(Command.START):
                with m.If(~(self.status & int(Status.ARMED)).any()):
                    m.d.comb += refusal.eq(Refusal.NOT_ARMED)
                with m.Elif((self.status & int(Status.TRIGGERING | Status.FINISHED)).any()):
                    m.d.comb += refusal.eq(Refusal.BUSY)

    def _write(self, m: Module) -> None:
        """A setting, or the three commands; a period takes its width along."""
        value = self.command.value
        with m.Switch(self.command.address):
            for register in _SETTINGS:
                with m.Case(register.address):
                    m.d.sync += self._held(register.name).eq(value)
                    if register.name in _WIDTH_OF:
                        width = _WIDTH_OF[register.name]
                        m.d.sync += getattr(self, width.lower()).eq(self._held(width))
            with m.Case(ADDRESS["COMMAND"]):
                m.d.sync += [
                    self.arm.eq(value[:2] == Command.ARM),
                    self.start.eq(value[:2] == Command.START),
                    self.stop.eq(value[:2] == Command.STOP),
                ]

    def _read(self, m: Module) -> None:
        """The value that the register has now, into the reply."""
        counter_high = Signal(16)
        sources: dict[str, Value | int] = {r.name: self._at_reset[r.name] for r in REGISTERS if r.access == "read"}
        sources |= {r.name: self._held(r.name) for r in _SETTINGS}
        sources |= {
            "COMMAND": 0,
            "STATUS": self.status,
            "RECORDS_WRITTEN": self.records_written,
            "RECORDS_LOST": self.records_lost,
            "COUNTER_LOW": self.counter[:32],
            "COUNTER_HIGH": counter_high,
            "GARBLED_COMMANDS": self.garbled_commands,
        }
        m.d.sync += self.reply.value.eq(0)
        with m.Switch(self.command.address):
            for name, source in sources.items():
                with m.Case(ADDRESS[name]):
                    m.d.sync += self.reply.value.eq(source)
                    if name == "COUNTER_LOW":
                        m.d.sync += counter_high.eq(self.counter[32:])
