"""The trigger generator: pulses for chopper and camera, and the time of every edge, by one clock."""

from typing import final

from amaranth.hdl import Cat, Module, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from irtiming.gateware.edge_timestamper import EdgeTimestamper
from irtiming.gateware.pulse_generator import EdgeTrain, Pulse
from irtiming.gateware.register_file import RegisterFile
from irtiming.gateware.register_map import BAUD, QUEUE_DEPTH, Polarity
from irtiming.gateware.serial_link import SerialLink
from irtiming.gateware.timestamp_queue import TimestampQueue

CLOCK_FREQUENCY_HZ = 48_000_000
"""Of most boards."""


@final
class TriggerGenerator(wiring.Component):
    """All of it, in the clock domain "sync". Inputs are asynchronous and synchronised inside.

    Parameters
    ----------
    clock_frequency_hz
        Of the domain "sync".
    queue_depth
        Records that can wait for the line, a power of two.
    """

    def __init__(self, *, clock_frequency_hz: int = CLOCK_FREQUENCY_HZ, queue_depth: int = QUEUE_DEPTH) -> None:
        self.clock_frequency_hz = clock_frequency_hz
        self.bit_cycles = round(clock_frequency_hz / BAUD)
        self.queue_depth = queue_depth
        inputs = ("rx", "camera_in", "control_in", "application_in", "spare_in")
        outputs = ("chopper_out", "camera_out")
        super().__init__(dict.fromkeys(inputs, In(1)) | dict.fromkeys(outputs, Out(1)) | {"tx": Out(1, init=1)})

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for."""
        m = Module()
        m.submodules.link = link = SerialLink(bit_cycles=self.bit_cycles)
        m.submodules.queue = queue = TimestampQueue(depth=self.queue_depth)
        m.submodules.registers = registers = RegisterFile(
            clock_frequency_hz=self.clock_frequency_hz, queue_depth=self.queue_depth
        )
        m.submodules.timestamper = timestamper = EdgeTimestamper()
        is_armed = Signal()
        is_triggering, is_finished = self._add_pulses(m, registers, timestamper)
        with m.If(registers.arm):
            m.d.sync += is_armed.eq(1)
        with m.If(registers.stop):
            m.d.sync += is_armed.eq(0)
        m.d.comb += [
            link.rx.eq(self.rx),
            self.tx.eq(link.tx),
            registers.command.eq(link.command),
            registers.is_command.eq(link.is_command),
            link.reply.eq(registers.reply),
            link.is_reply.eq(registers.is_reply),
            registers.garbled_commands.eq(link.garbled),
            registers.counter.eq(timestamper.counter),
            registers.status.eq(Cat(is_armed, is_triggering, is_finished, queue.is_lossy, queue.is_empty)),
            registers.records_written.eq(queue.written),
            registers.records_lost.eq(queue.lost),
            timestamper.camera_in.eq(self.camera_in),
            timestamper.control_in.eq(self.control_in),
            timestamper.application_in.eq(self.application_in),
            timestamper.spare_in.eq(self.spare_in),
            timestamper.polarity.eq(registers.polarity),
            timestamper.channels.eq(registers.channels),
            timestamper.filter.eq(registers.filter),
            timestamper.is_recording.eq(is_armed),
            queue.write.eq(timestamper.is_event),
            queue.channels.eq(timestamper.happened),
            queue.time.eq(timestamper.time),
            queue.clear.eq(registers.arm),
            queue.pop.eq(link.pops_record),
            link.record.eq(queue.record),
            link.record_waits.eq(~queue.is_empty),
        ]
        return m

    def _add_pulses(self, m: Module, registers: RegisterFile, timestamper: EdgeTimestamper) -> tuple[Value, Value]:
        """Three trains of edges and two pulses; tells whether the camera's train runs, and whether it has ended."""
        m.submodules.chopper = chopper = EdgeTrain(is_endless=True)
        m.submodules.chopper_pulse = chopper_pulse = Pulse()
        m.submodules.nominal = nominal = EdgeTrain()
        m.submodules.delayed = delayed = EdgeTrain()
        m.submodules.camera_pulse = camera_pulse = Pulse()
        m.d.comb += [
            chopper.period.eq(registers.chopper_period),
            chopper_pulse.edge.eq(chopper.edge),
            chopper_pulse.width.eq(registers.chopper_width),
            chopper_pulse.idles_high.eq((registers.polarity & int(Polarity.CHOPPER_OUTPUT)) != 0),
            self.chopper_out.eq(chopper_pulse.pin),
            delayed.delay.eq(registers.camera_delay),
            camera_pulse.edge.eq(delayed.edge),
            camera_pulse.width.eq(registers.camera_width),
            camera_pulse.idles_high.eq((registers.polarity & int(Polarity.CAMERA_OUTPUT)) != 0),
            self.camera_out.eq(camera_pulse.pin),
            timestamper.camera_trigger.eq(nominal.edge),
            timestamper.camera_trigger_delayed.eq(delayed.edge),
        ]
        for train in (nominal, delayed):
            m.d.comb += [
                train.start.eq(registers.start),
                train.stop.eq(registers.stop),
                train.period.eq(registers.camera_period),
                train.count.eq(registers.camera_count),
            ]
        have_all_begun = Signal()
        with m.If(delayed.is_last):
            m.d.sync += have_all_begun.eq(1)
        with m.If(registers.arm):
            m.d.sync += have_all_begun.eq(0)
        is_triggering = nominal.is_running | delayed.is_running | camera_pulse.is_high
        return is_triggering, have_all_begun & ~camera_pulse.is_high
