"""What is proved of the circuit, for ever and for every setting; ``make proofs`` proves all of it."""

from functools import partial

from irtiming.gateware.proofs.bench import Fault
from irtiming.gateware.proofs.claim import Claim
from irtiming.gateware.proofs.line import CalmLine
from irtiming.gateware.proofs.pulses import CameraTrain, ChopperTrain
from irtiming.gateware.proofs.queue import RecordsAreKept
from irtiming.gateware.proofs.settings import SafeSettings
from irtiming.gateware.proofs.times import CyclesAreCounted, TimesOfEdges
from irtiming.gateware.register_map import QUEUE_DEPTH

CLAIMS: tuple[Claim, ...] = (
    Claim(
        name="camera triggers",
        sentence="Started in cycle s, edge k comes in cycle s + 1 + delay + k period and in no other, as many as asked for; "
        "each makes a pulse of exactly the width. Any 32-bit settings, STOP at any time.",
        bench=CameraTrain,
        faults=(
            Fault("pulse_generator", "self.period - 2", "self.period - 1"),
            Fault("pulse_generator", "self.delay - 1", "self.delay"),
            Fault("pulse_generator", "self.count - 2", "self.count - 1"),
            Fault("pulse_generator", "self.width - 2", "self.width - 1"),
            Fault("pulse_generator", "with m.If(self.stop):", "with m.If(self.stop & ~self.edge):"),
        ),
    ),
    Claim(
        name="chopper reference",
        sentence="Edges follow each other by exactly the period, from cycle 0 on, whatever else happens; a new period holds "
        "from the next edge on, without gap or runt.",
        bench=ChopperTrain,
        faults=(
            Fault("pulse_generator", "init=-1 if self._is_endless else 0", "init=0"),
            Fault("pulse_generator", "self.period - 2", "self.period - 1"),
        ),
    ),
    Claim(
        name="counter",
        sentence="The counter is the number of cycles since reset.",
        bench=partial(CyclesAreCounted, bits=48),
        small=partial(CyclesAreCounted, bits=4),
        faults=(Fault("edge_timestamper", "low == 2**self._half - 2", "low == 2**self._half - 1"),),
    ),
    Claim(
        name="times of edges",
        sentence="A change of a pin is recorded if it lasts, with the cycle number that the latencies ask for; nothing else is. "
        "Any signals, filter, polarity and channels.",
        bench=TimesOfEdges,
        faults=(
            Fault("edge_timestamper", "with m.If(remaining == 0):", "with m.If(remaining <= 1):"),
            Fault("edge_timestamper", "with m.If(~falls):", "with m.If(falls):"),
            Fault("edge_timestamper", "with m.If(self.is_recording):", "with m.If(1):"),
        ),
    ),
    Claim(
        name="records are kept",
        sentence=f"A record leaves the queue of {QUEUE_DEPTH} unchanged and in order. It is lost only if all places are taken; "
        "then it is counted, and the next record says so. Any writes and pops, ARM at any time.",
        bench=partial(RecordsAreKept, depth=QUEUE_DEPTH),
        small=partial(RecordsAreKept, depth=2),
        faults=(
            Fault("timestamp_queue", "is_kept.eq(self.write & ~waiting[-1])", "is_kept.eq(self.write)"),
            Fault(
                "timestamp_queue",
                "is_lost.eq(self.write & waiting[-1])",
                "is_lost.eq(self.write & waiting[-1] & ~self.pop)",
            ),
            Fault("timestamp_queue", "[self.is_lossy.eq(1), next_is_after_loss.eq(1)]", "self.is_lossy.eq(1)"),
            Fault("timestamp_queue", "[self.is_lossy.eq(0), next_is_after_loss.eq(0)]", "self.is_lossy.eq(0)"),
        ),
    ),
    Claim(
        name="safe settings",
        sentence="No command, of any value and in any order, sets a width of 0, a period that does not exceed its width, or a "
        "count of 0, or changes anything between ARM and STOP; a refused one changes nothing, a reply tells the truth. "
        "No trigger leaves without a record of its cycle.",
        bench=SafeSettings,
        induction_cycles=7,
        faults=(
            Fault("register_file", "value > self._held", "value >= self._held"),
            Fault("register_file", "(value >= register.lowest) &", ""),
            Fault("register_file", "is_setting & is_busy", "is_setting & is_busy & is_command"),
            Fault("register_file", "with m.If(~(self.status & int(Status.ARMED)).any()):", "with m.If(0):"),
            Fault(
                "trigger_generator",
                "delayed.delay.eq(registers.camera_delay)",
                "nominal.delay.eq(registers.camera_delay)",
            ),
        ),
    ),
    Claim(
        name="line and queue",
        sentence="The serial link takes a record only while one waits, and holds a command still until its reply. Any signal on "
        "the line, ARM at any time.",
        bench=CalmLine,
        induction_cycles=9,
        faults=(Fault("serial_link", "(self.reply_waits | self.record_waits)", "(self.reply_waits | 1)"),),
    ),
)
