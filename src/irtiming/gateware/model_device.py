"""A trigger generator in plain Python: its registers, its refusals and its line, with the events of the integer model.

It stands in where the circuit itself would be too slow or its tools are not installed. Times on the line are right to
some bits; times of events are those of `irtiming.gateware.event_model`.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, final

import numpy as np

from irtiming.gateware.event_model import (
    CIRCUIT,
    COUNTER_CYCLES,
    PinChanges,
    Run,
    Settings,
    recorded_events,
)
from irtiming.gateware.messages import (
    BITS_PER_BYTE,
    COMMAND_BYTES,
    COMMAND_START,
    RECORD_BYTES,
    REPLY_BYTES,
    SILENCE_BITS,
    CommandMessage,
    Operation,
    RecordMessage,
    ReplyMessage,
    pack_record,
    pack_reply,
    unpack_command,
)
from irtiming.gateware.register_map import (
    ADDRESS,
    BAUD,
    OUTPUT_LATENCY_CYCLES,
    REGISTERS,
    Channel,
    Command,
    Polarity,
    Refusal,
    Register,
    Status,
    at_reset,
)
from irtiming.records.arrays import Ticks

_REGISTER = {register.address: register for register in REGISTERS}
_MOST = 2**32 - 1
_LONGEST_FILTER = 300  # cycles after which a change of a pin has been recorded or forgotten
_NO_CHANGES = np.empty(0, dtype=np.int64)


class Wheel(Protocol):
    """What turns before the inputs of a simulated device."""

    def turn(self, until_cycle: int, *, slot_period_cycles: int) -> Mapping[Channel, PinChanges]:
        """Changes of the pins from where the last call ended to before ``until_cycle``.

        Parameters
        ----------
        until_cycle
            Rises from call to call.
        slot_period_cycles
            Period of the chopper's reference, which the wheel follows with its control slots; 0 where there is none.
        """
        ...


class TriggeredCamera(Protocol):
    """What hears the camera trigger of a simulated device."""

    def trigger(self, cycles: Ticks) -> None:
        """Rising edges of the line that lie ahead of the last ones reported.

        Parameters
        ----------
        cycles
            Shape (n,): counter at each edge, in order.
        """
        ...


class SimulatedDevice(Protocol):
    """What `PseudoTerminal` serves: the model, or the compiled circuit."""

    @property
    def clock_frequency_hz(self) -> int:
        """Of the counter."""
        ...

    def exchange(self, received: bytes, *, until_cycle: int) -> bytes:
        """Take bytes of the computer, run until the counter is at least ``until_cycle``, and give the bytes sent."""
        ...


@final
@dataclass(frozen=True, kw_only=True)
class Loop:
    """A wire from the camera's output to an input, on which an edge takes some ``cycles``."""

    channel: Channel
    cycles: int = 0


@final
class ModelDevice:
    """Device at cycle 0 after its reset. ``registers`` may replace what it says of itself, to be another one.

    ``loop`` leads the camera's trigger back to an input.
    """

    def __init__(
        self, wheel: Wheel | None = None, *, camera: TriggeredCamera | None = None,
        clock_frequency_hz: int = 48_000_000, registers: Mapping[str, int] | None = None,
        loop: Loop | None = None,
    ) -> None:  # fmt: skip
        self._loop = loop
        self._wheel = wheel
        self._camera = camera
        self._clock_frequency_hz = clock_frequency_hz
        self._values = {register.name: at_reset(register, clock_frequency_hz) for register in REGISTERS}
        self._values |= registers or {}
        self._committed = dict(self._values)
        self._bit_cycles = round(clock_frequency_hz / BAUD)
        self._cycle = 0
        self._heard, self._heard_until = bytearray(), 0
        self._pins: dict[Channel, PinChanges] = {}
        self._out, self._line_free = bytearray(), 0
        self._queue: deque[tuple[int, RecordMessage]] = deque()
        self._is_armed = self._is_after_loss = False
        self._first_trigger: int | None = None
        self._train_ends: int | None = None

    @property
    def clock_frequency_hz(self) -> int:
        """Of the counter."""
        return self._clock_frequency_hz

    def exchange(self, received: bytes, *, until_cycle: int) -> bytes:
        """Take bytes of the computer at this cycle, run to another one, and give the bytes sent meanwhile.

        Parameters
        ----------
        received
            Any number of bytes.
        until_cycle
            Where to stop; a cycle in the past changes nothing.
        """
        if received:
            self._listen(received)
        if until_cycle > self._cycle:
            self._record(until_cycle)
            self._trigger(until_cycle)
            self._cycle = until_cycle
        self._send(self._cycle)
        sent = bytes(self._out)
        self._out.clear()
        return sent

    def _listen(self, received: bytes) -> None:
        if self._heard and self._cycle > self._heard_until + SILENCE_BITS * self._bit_cycles:
            self._heard.clear()
            self._count_garbled()
        self._heard_until = self._cycle + len(received) * BITS_PER_BYTE * self._bit_cycles
        for byte in received:
            if self._heard or byte == COMMAND_START:
                self._heard.append(byte)
            if len(self._heard) == COMMAND_BYTES:
                command = unpack_command(bytes(self._heard))
                self._heard.clear()
                if command is None:
                    self._count_garbled()
                else:
                    self._answer(command)

    def _count_garbled(self) -> None:
        self._values["GARBLED_COMMANDS"] = min(self._values["GARBLED_COMMANDS"] + 1, _MOST)

    def _answer(self, command: CommandMessage) -> None:
        register = _REGISTER.get(command.address)
        if register is None:
            refusal, value = Refusal.UNKNOWN_REGISTER, 0
        else:
            refusal = self._write(register, command.value) if command.operation == Operation.WRITE else Refusal.NONE
            if command.operation > Operation.WRITE:
                refusal = Refusal.BAD_VALUE
            value = self._value(register.name)
        reply = ReplyMessage(refusal=refusal, tag=command.tag, address=command.address, value=value)
        self._send(self._cycle)
        self._out += pack_reply(reply)
        message = REPLY_BYTES * BITS_PER_BYTE * self._bit_cycles + CIRCUIT.between
        self._line_free = max(self._line_free, self._cycle) + message

    def _value(self, name: str) -> int:
        if name == "STATUS":
            return int(self._status())
        if name == "COUNTER_LOW":
            self._values["COUNTER_HIGH"] = self._cycle % COUNTER_CYCLES >> 32
            return self._cycle & _MOST
        return 0 if name == "COMMAND" else self._values[name]

    def _status(self) -> Status:
        status = Status.ARMED if self._is_armed else Status(0)
        if self._train_ends is not None and self._cycle < self._train_ends:
            status |= Status.TRIGGERING
        elif self._first_trigger is not None and self._train_ends == self._full_train_ends():
            status |= Status.FINISHED
        if self._values["RECORDS_LOST"]:
            status |= Status.LOSS
        return status if self._queue else status | Status.QUEUE_EMPTY

    def _write(self, register: Register, value: int) -> Refusal:
        if register.access == "read":
            return Refusal.READ_ONLY
        if register.access == "command":
            return self._obey(value)
        if self._is_armed or self._status() & Status.TRIGGERING:
            return Refusal.BUSY
        is_period = register.name.endswith("_PERIOD")
        shortest = self._values[register.name.replace("PERIOD", "WIDTH")] + 1 if is_period else register.lowest
        if not max(register.lowest, shortest) <= value <= register.highest:
            return Refusal.BAD_VALUE
        self._values[register.name] = value
        if is_period:
            width = register.name.replace("PERIOD", "WIDTH")
            self._committed |= {register.name: value, width: self._values[width]}
        return Refusal.NONE

    def _obey(self, value: int) -> Refusal:
        is_triggering = bool(self._status() & Status.TRIGGERING)
        if value == Command.ARM:
            if self._is_armed or is_triggering:
                return Refusal.BUSY
            if any(self._values[width] != self._committed[width] for width in ("CHOPPER_WIDTH", "CAMERA_WIDTH")):
                return Refusal.BAD_VALUE
            self._queue.clear()
            self._values |= {"RECORDS_WRITTEN": 0, "RECORDS_LOST": 0}
            self._is_armed, self._is_after_loss = True, False
            self._first_trigger = self._train_ends = None
        elif value == Command.START:
            if not self._is_armed:
                return Refusal.NOT_ARMED
            if self._first_trigger is not None:
                return Refusal.BUSY
            self._first_trigger = self._cycle + 1
            self._train_ends = self._full_train_ends()
        elif value == Command.STOP:
            self._is_armed = False
            if is_triggering:
                self._train_ends = self._pulse_ends()
        else:
            return Refusal.BAD_VALUE
        return Refusal.NONE

    def _full_train_ends(self) -> int:
        """First cycle after the last pulse of a train that is not stopped."""
        delayed = self._first_delayed() + (self._values["CAMERA_COUNT"] - 1) * self._values["CAMERA_PERIOD"]
        return delayed + OUTPUT_LATENCY_CYCLES + self._values["CAMERA_WIDTH"]

    def _pulse_ends(self) -> int:
        """First cycle after the pulse that is high now; this one if none is."""
        since = self._cycle - self._first_delayed() - OUTPUT_LATENCY_CYCLES
        high = since % self._values["CAMERA_PERIOD"]
        left = self._values["CAMERA_WIDTH"] - high
        return self._cycle + (left if since >= 0 and left > 0 else 0)

    def _first_delayed(self) -> int:
        return (self._first_trigger or 0) + self._values["CAMERA_DELAY"]

    def _record(self, until_cycle: int) -> None:
        """Events of the cycles from this one to before another, into the queue and from there to the line."""
        if self._wheel is not None:
            self._see(self._wheel.turn(until_cycle, slot_period_cycles=self._committed["CHOPPER_PERIOD"]))
        if self._loop is not None and self._train_ends is not None:
            self._see({self._loop.channel: self._led_back(until_cycle, later=self._loop.cycles)})
        if self._is_armed:
            settings = self._settings(until_cycle)
            run = Run(
                armed_from_cycle=self._cycle, armed_until_cycle=until_cycle, first_trigger_cycle=self._first_trigger
            )
            events = recorded_events(settings, self._pins, run=run)
            for time, channels in zip(events.time_ticks.tolist(), events.channels.tolist(), strict=True):
                self._enqueue(time, channels)
        self._forget(until_cycle - _LONGEST_FILTER)

    def _trigger(self, until_cycle: int) -> None:
        """Tell the camera the edges of its line from this cycle to before another."""
        if self._camera is None or self._train_ends is None:
            return
        first, period = self._first_delayed() + OUTPUT_LATENCY_CYCLES, self._values["CAMERA_PERIOD"]
        begun = max(0, -((first - self._cycle) // period))
        edges = np.arange(first + begun * period, min(until_cycle, self._train_ends), period, dtype=np.int64)
        if edges.size:
            self._camera.trigger(edges)

    def _led_back(self, until_cycle: int, *, later: int) -> PinChanges:
        """Changes of the camera's line from this cycle to before another, at the other end of a wire."""
        period, width = self._values["CAMERA_PERIOD"], self._values["CAMERA_WIDTH"]
        first = self._first_delayed() + OUTPUT_LATENCY_CYCLES
        begun = np.arange(first, min(until_cycle, self._train_ends or 0), period, dtype=np.int64)
        cycle = (begun[:, None] + np.array([0, width])).ravel() + later
        level = np.tile(np.array([1, 0], dtype=np.int64), begun.size)
        inverted = int(bool(self._values["POLARITY"] & Polarity.CAMERA_OUTPUT))
        new = (cycle >= self._cycle) & (cycle < until_cycle)
        return PinChanges(cycle=cycle[new], level=level[new] ^ inverted, initial=inverted)

    def _settings(self, until_cycle: int) -> Settings:
        """Registers as the model wants them; of the train only the triggers that begin before a cycle."""
        begun = max(1, (until_cycle - (self._first_trigger or 0)) // self._values["CAMERA_PERIOD"] + 1)
        names = {name: name.upper() for name in Settings.__dataclass_fields__}
        values = {name: self._values[register] for name, register in names.items() if register in ADDRESS}
        return Settings(**(values | {"camera_count": min(values["camera_count"], begun)}), bit_cycles=self._bit_cycles)

    def _see(self, changes: Mapping[Channel, PinChanges]) -> None:
        for pin, new in changes.items():
            old = self._pins.get(pin, PinChanges(cycle=_NO_CHANGES, level=_NO_CHANGES, initial=new.initial))
            self._pins[pin] = PinChanges(
                cycle=np.concatenate([old.cycle, new.cycle]),
                level=np.concatenate([old.level, new.level]),
                initial=old.initial,
            )

    def _forget(self, before_cycle: int) -> None:
        """Leave out old changes of the pins; the level before the others is the one that passed the filter."""
        for pin, changes in self._pins.items():
            past = int(np.searchsorted(changes.cycle, before_cycle))
            if past:
                lasted = np.append(np.diff(changes.cycle), COUNTER_CYCLES)[:past]
                steady = changes.level[:past][lasted > self._values["FILTER"]]
                self._pins[pin] = PinChanges(
                    cycle=changes.cycle[past:],
                    level=changes.level[past:],
                    initial=int(steady[-1]) if steady.size else changes.initial,
                )

    def _enqueue(self, time: int, channels: int) -> None:
        written = time + CIRCUIT.write
        self._send(written)
        leaves = bool(self._queue) and max(self._queue[0][0] + CIRCUIT.take, self._line_free) == written
        if len(self._queue) - leaves == self._values["QUEUE_DEPTH"]:
            self._values["RECORDS_LOST"] = min(self._values["RECORDS_LOST"] + 1, _MOST)
            self._is_after_loss = True
            return
        number, time_ticks = self._values["RECORDS_WRITTEN"], time % COUNTER_CYCLES
        record = RecordMessage(
            channels=channels, number=number % 2**16, time_ticks=time_ticks, is_after_loss=self._is_after_loss
        )
        self._queue.append((written, record))
        self._values["RECORDS_WRITTEN"], self._is_after_loss = min(number + 1, _MOST), False

    def _send(self, until_cycle: int) -> None:
        """Put those records on the line whose first bit begins before a cycle."""
        while self._queue:
            begun = max(self._queue[0][0] + CIRCUIT.take, self._line_free)
            if begun >= until_cycle:
                return
            self._out += pack_record(self._queue.popleft()[1])
            self._line_free = begun + RECORD_BYTES * BITS_PER_BYTE * self._bit_cycles + CIRCUIT.between
