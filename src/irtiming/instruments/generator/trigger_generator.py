"""Driver of the trigger generator: identify, load, arm, start, collect timestamps, stop."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from time import monotonic
from typing import final

import numpy as np

from irtiming.errors import InstrumentError, InstrumentRefused
from irtiming.gateware.event_model import COUNTER_CYCLES, Latencies
from irtiming.gateware.messages import RecordMessage
from irtiming.gateware.register_map import IDENTITY, VERSION, Channel, Command, Polarity, Status
from irtiming.instruments.generator.register_link import Patience, RegisterLink
from irtiming.instruments.generator.timestamp_stream import Stamp, TimestampStream
from irtiming.instruments.serial_line import Line, open_line
from irtiming.records.clock_exchange import ClockExchange
from irtiming.records.timestamps import Timestamps
from irtiming.records.trigger_plan import PlannedRun

_ALWAYS_RECORDED = (
    Channel.CAMERA_TRIGGER | Channel.CAMERA_TRIGGER_DELAYED | Channel.CONTROL_SLOT
    | Channel.APPLICATION_SLOT | Channel.APPLICATION_OTHER_EDGE
)  # fmt: skip
_NO_LINE, _NO_CHANNEL = Polarity(0), Channel(0)
_EMPTYING_S = 2.0  # of the device's time: a full queue needs 0.06 s


@final
@dataclass(frozen=True, kw_only=True)
class Wiring:
    """How the lines of this rig are wired.

    ``falling_edges`` are the lines whose falling edge counts. ``filter_cycles`` is for how long an input must keep
    its new level. ``camera_pulse_s`` is the length of a camera trigger; at most half of the camera period is set.
    ``also_recorded`` may name `Channel.CAMERA_INPUT` and `Channel.SPARE`.
    """

    falling_edges: Polarity = _NO_LINE
    filter_cycles: int = 0
    camera_pulse_s: float = 1e-3
    also_recorded: Channel = _NO_CHANNEL


@final
@dataclass(frozen=True, kw_only=True)
class Identity:
    """What a device says of itself."""

    version: tuple[int, int]
    clock_frequency_hz: int
    queue_depth: int
    input_latency_cycles: int
    output_latency_cycles: int


@asynccontextmanager
async def connected(
    port: str, *, wiring: Wiring | None = None, patience: Patience | None = None
) -> AsyncIterator["SerialTriggerGenerator"]:
    """Trigger generator at a serial port, for the length of an ``async with`` block.

    Parameters
    ----------
    port
        Path or name, such as ``/dev/ttyUSB1`` or ``COM3``.
    wiring
        Of the rig; `Wiring` by default.
    patience
        With its replies.

    Raises
    ------
    InstrumentError
        If the port cannot be opened, nothing answers, or it is no trigger generator that this program can drive.
    """
    generator = SerialTriggerGenerator(await open_line(port), wiring=wiring, patience=patience)
    try:
        await generator.identify()
        yield generator
    finally:
        await generator.close()


@final
class SerialTriggerGenerator:
    """The trigger generator at the other end of a line; make it by `connected`. Implements `TriggerGenerator`."""

    def __init__(self, line: Line, *, wiring: Wiring | None = None, patience: Patience | None = None) -> None:
        self._wiring = wiring or Wiring()
        self._link = RegisterLink(line, on_record=self._take, patience=patience or Patience())
        self._identity: Identity | None = None
        self._settings: dict[str, int] = {}
        self._latencies = Latencies()
        self._stream: TimestampStream | None = None
        self._is_recording = False
        self._stamps: list[Stamp] = []
        self._news = asyncio.Event()

    @property
    def name(self) -> str:
        """Of the port, for messages."""
        return self._link.name

    @property
    def identity(self) -> Identity:
        """What the device said of itself.

        Raises
        ------
        InstrumentRefused
            Before `identify`.
        """
        if self._identity is None:
            raise InstrumentRefused(f"{self.name} was not identified yet; open it by trigger_generator.connected")
        return self._identity

    @property
    def clock_frequency_hz(self) -> int:
        """Of the device's counter."""
        return self.identity.clock_frequency_hz

    async def identify(self) -> Identity:
        """Ask the device what it is.

        Raises
        ------
        InstrumentSilent
            If nothing answers.
        InstrumentRefused
            If it is no trigger generator, or one of another version of the register map.
        """
        letters = await self._link.read("IDENTITY")
        if letters != IDENTITY:
            raise InstrumentRefused(
                f"{self.name} answers, but its register 0 holds {letters:#010x}, not {IDENTITY:#010x} (IRTG): it is no trigger "
                "generator; name another port"
            )
        number = await self._link.read("VERSION")
        version = (number >> 16, number & 0xFFFF)
        if version[0] != VERSION[0] or version[1] < VERSION[1]:
            older = "the device" if version < VERSION else "irtiming"
            raise InstrumentRefused(
                f"{self.name} has version {version[0]}.{version[1]} of the registers, this program needs "
                f"{VERSION[0]}.{VERSION[1]} or a later {VERSION[0]}.x; update {older}"
            )
        self._identity = Identity(
            version=version,
            clock_frequency_hz=await self._link.read("CLOCK_FREQUENCY"),
            queue_depth=await self._link.read("QUEUE_DEPTH"),
            input_latency_cycles=await self._link.read("INPUT_LATENCY"),
            output_latency_cycles=await self._link.read("OUTPUT_LATENCY"),
        )
        return self._identity

    async def register(self, name: str) -> int:
        """Value of one register by its name in the register map, such as ``"CAMERA_PERIOD"``."""
        return await self._link.read(name)

    async def load(self, run: PlannedRun, *, clock_frequency_hz: int) -> None:
        """Set periods, delay, number of triggers and wiring; a measurement that still runs is stopped.

        Parameters
        ----------
        run
            Of a plan.
        clock_frequency_hz
            That the plan was made for.

        Raises
        ------
        InstrumentRefused
            If the plan is for another clock, or a value does not fit the device.
        InstrumentSilent
            If the device does not answer.
        """
        if clock_frequency_hz != self.clock_frequency_hz:
            raise InstrumentRefused(
                f"the plan is for a clock of {clock_frequency_hz} Hz, the trigger generator at {self.name} has "
                f"{self.clock_frequency_hz} Hz; plan again with irtiming plan --clock-hz {self.clock_frequency_hz}"
            )
        await self._halt()
        self._settings = self._settings_of(run)
        for name, value in self._settings.items():
            await self._link.write(name, value)

    async def arm(self) -> None:
        """Check that the device holds what was loaded, forget earlier timestamps and begin to record.

        Raises
        ------
        InstrumentRefused
            If nothing was loaded, or the device holds something else.
        InstrumentSilent
            If the device does not answer.
        """
        if not self._settings:
            raise InstrumentRefused(f"nothing was loaded into {self.name}; load a run before arming")
        await self._halt()
        for name, value in self._settings.items():
            held = await self._link.read(name)
            if held != value:
                raise InstrumentRefused(
                    f"{self.name} holds {name} = {held}, but {value} was loaded; was it switched off in between? Load again"
                )
        stream = TimestampStream(counter_ticks=await self.counter_ticks())
        self._latencies = Latencies(
            input_cycles=self.identity.input_latency_cycles,
            output_cycles=self.identity.output_latency_cycles,
            filter_cycles=self._settings["FILTER"],
        )
        self._stream, self._stamps, self._is_recording = stream, [], True
        await self._obey(Command.ARM, done=Status.ARMED)

    async def start(self) -> None:
        """Begin the train of camera triggers.

        Raises
        ------
        InstrumentRefused
            If the device is not armed or has made its train already.
        """
        await self._obey(Command.START, done=Status.TRIGGERING | Status.FINISHED)

    async def counter_ticks(self) -> int:
        """The device's 48-bit counter now."""
        while True:
            low = await self._link.read("COUNTER_LOW")
            high = await self._link.read("COUNTER_HIGH")
            if (
                await self._link.read("COUNTER_LOW") >= low
            ):  # no carry in between, whichever reading kept the upper half
                return high << 32 | low

    async def clock_exchange(self) -> ClockExchange:
        """The counter between two looks at this computer's clock; only the one register that is latched lies between them."""
        while True:
            before_s = monotonic()
            low = await self._link.read("COUNTER_LOW")
            after_s = monotonic()
            high = await self._link.read("COUNTER_HIGH")
            if await self._link.read("COUNTER_LOW") >= low:  # no carry in between
                return ClockExchange(before_s=before_s, ticks=high << 32 | low, after_s=after_s)

    async def has_finished(self) -> bool:
        """Whether all camera triggers are over.

        Raises
        ------
        InstrumentRefused
            If the device has left the measurement by itself.
        """
        status = await self._link.read("STATUS")
        if not status & Status.ARMED:
            raise InstrumentRefused(
                f"{self.name} stopped recording by itself after {len(self._recorded())} records: it was reset; check its power "
                "and repeat the run"
            )
        return bool(status & Status.FINISHED)

    async def stamps(self) -> AsyncIterator[Stamp]:
        """Timestamps since `arm` as they arrive, as recorded (latencies included), until `stop` or a line that is gone."""
        given = 0
        while True:
            while given < len(self._stamps):
                yield self._stamps[given]
                given += 1
            if not self._is_recording:
                return
            self._news.clear()
            with suppress(TimeoutError):
                await asyncio.wait_for(self._news.wait(), self._link.patience.poll_s)
            if self._link.gone is not None:
                raise self._link.gone

    async def stop(self) -> Timestamps:
        """End recording, fetch what still waits in the device and give all timestamps since `arm`.

        Returns
        -------
        Times at the pins; ``lost_after_ticks`` tells of every loss.

        Raises
        ------
        InstrumentError
            If the device does not answer (`captured` has what arrived), or its triggers are not those that were loaded.
        """
        stream = self._recorded()
        status = await self._halt()
        self._is_recording = False
        self._news.set()
        stream.close(
            records_written=await self._link.read("RECORDS_WRITTEN"),
            records_lost=await self._link.read("RECORDS_LOST"),
        )
        timestamps = self._timestamps()
        if timestamps.is_whole:
            self._check_train(timestamps, is_finished=bool(status & Status.FINISHED))
        return timestamps

    def captured(self) -> Timestamps:
        """What arrived so far; after an error, all that is to be had of the run. Not confirmed by `stop`, its end is lost."""
        return self._timestamps()

    async def close(self) -> None:
        """Stop the device, if it answers, and give its line back."""
        with suppress(InstrumentError):
            if self._is_recording:
                await self._link.command(Command.STOP)
        self._is_recording = False
        await self._link.close()

    def _take(self, record: RecordMessage) -> None:
        if self._stream is None or not self._is_recording:
            return  # of a measurement before this one
        stamp = self._stream.add(record)
        if stamp is not None:
            self._stamps.append(stamp)
        self._news.set()

    def _recorded(self) -> TimestampStream:
        if self._stream is None:
            raise InstrumentRefused(f"{self.name} was not armed; there are no timestamps yet")
        return self._stream

    def _timestamps(self) -> Timestamps:
        stream = self._recorded()
        return stream.timestamps(clock_frequency_hz=self.clock_frequency_hz, latencies=self._latencies)

    def _settings_of(self, run: PlannedRun) -> dict[str, int]:
        """Registers of a run in the order in which they may be written: a width before its period."""
        scheme, wiring = run.scheme, self._wiring
        pulse = round(wiring.camera_pulse_s * self.clock_frequency_hz)
        return {
            "CHOPPER_WIDTH": max(1, scheme.control_slot_period_ticks // 2),
            "CHOPPER_PERIOD": scheme.control_slot_period_ticks,
            "CAMERA_WIDTH": max(1, min(pulse, scheme.camera_period_ticks // 2)),
            "CAMERA_PERIOD": scheme.camera_period_ticks,
            "CAMERA_COUNT": scheme.samples_per_turn * run.repeats,
            "CAMERA_DELAY": run.trigger_delay_ticks,
            "POLARITY": int(wiring.falling_edges),
            "CHANNELS": int(_ALWAYS_RECORDED | wiring.also_recorded),
            "FILTER": wiring.filter_cycles,
        }

    async def _obey(self, command: Command, *, done: Status) -> None:
        """Have a command done once; where its reply is lost, the status tells whether it was."""
        for _ in range(self._link.patience.tries):
            refusal = await self._link.command(command)
            if refusal is None and not await self._link.read("STATUS") & done:
                continue
            if refusal:
                raise InstrumentRefused(f"{self.name} refuses to {command.name.lower()} ({refusal.name.lower()})")
            return
        raise InstrumentRefused(f"{self.name} answers, but does not {command.name.lower()}; repeat the run")

    async def _halt(self) -> int:
        """End whatever runs, wait until nothing is left to be sent, and return the status then."""
        await self._link.command(Command.STOP)
        limit: int | None = None
        while True:
            status = await self._link.read("STATUS")
            if status & Status.ARMED:
                await self._link.command(Command.STOP)
            elif status & Status.QUEUE_EMPTY and not status & Status.TRIGGERING:
                return status
            now = await self.counter_ticks()
            if limit is None:  # a camera pulse that runs keeps its length
                left = round(_EMPTYING_S * self.clock_frequency_hz) + await self._link.read("CAMERA_WIDTH")
                limit = now + left
            if (now - limit) % COUNTER_CYCLES < COUNTER_CYCLES // 2:
                raise InstrumentRefused(f"{self.name} does not come to rest (status {status:#x}); switch it off and on")
            await asyncio.sleep(self._link.patience.poll_s / 10)

    def _check_train(self, timestamps: Timestamps, *, is_finished: bool) -> None:
        """Refuse triggers that are not those that were loaded: a defect of the device, not of the line."""
        nominal, delayed = timestamps.camera_trigger_ticks, timestamps.camera_trigger_delayed_ticks
        period, delay, count = (self._settings[f"CAMERA_{what}"] for what in ("PERIOD", "DELAY", "COUNT"))
        regular = bool(np.all(np.diff(nominal) == period))
        complete = nominal.size == delayed.size == count or not is_finished
        if not (regular and complete and np.array_equal(delayed, nominal[: delayed.size] + delay)):
            raise InstrumentError(
                f"{self.name} stamped {nominal.size} triggers and {delayed.size} delayed ones, not the {count} that were loaded, "
                f"{period} cycles apart and {delay} cycles later, though no record was lost: it is defective; take another"
            )
