"""A device, a wheel in closed form and lines that come to harm, for the tests of the drivers."""

import asyncio
import random
from collections.abc import Callable, Mapping

import numpy as np
import pytest

from irtiming.gateware.event_model import PinChanges
from irtiming.gateware.messages import RecordMessage
from irtiming.gateware.model_device import ModelDevice
from irtiming.gateware.register_map import Channel
from irtiming.instruments.generator.message_stream import MessageStream
from irtiming.records.trigger_plan import PlannedRun, TriggerScheme

CLOCK_HZ = 48_000_000


class SteadyWheel:
    """Slots and edges at whole cycles in closed form, a little irregular; it stands still unless driven at its speed."""

    def __init__(self, slot_period: int = 48_000, slots: int = 10):
        self.slot_period, self.slots, self.cycle = slot_period, slots, 0

    def turn(self, until_cycle: int, *, slot_period_cycles: int) -> Mapping[Channel, PinChanges]:
        begin, self.cycle = self.cycle, max(self.cycle, until_cycle)
        if slot_period_cycles != self.slot_period:
            return {}
        turn = self.slot_period * self.slots
        k = np.arange(begin // self.slot_period - 1, until_cycle // self.slot_period + 2)
        slot = k * self.slot_period + k * 7919 % 97
        q = np.arange(begin // (turn // 4) - 1, until_cycle // (turn // 4) + 2)
        edge = q * (turn // 4) + q * 104729 % 89
        return {
            Channel.CONTROL_SLOT: self._pin(np.concatenate([slot, slot + self.slot_period // 2]), k.size, begin),
            Channel.APPLICATION_SLOT: self._pin(edge, (q + 1) % 2, begin),
        }

    def _pin(self, cycle, level, begin):
        levels = np.repeat([1, 0], level) if np.isscalar(level) else level
        order = np.argsort(cycle, kind="stable")
        cycle, levels = cycle[order], levels[order]
        inside = (cycle >= begin) & (cycle < self.cycle)
        before = levels[cycle < begin]
        return PinChanges(cycle=cycle[inside], level=levels[inside], initial=int(before[-1]) if before.size else 0)


class MemoryLine:
    """A device right behind the driver: time goes on as fast as the driver reads. Keeps what the device truly sent."""

    name = "memory"

    def __init__(self, device: ModelDevice, *, to_device=bytes, to_computer=bytes, step_cycles: int = 240_000):
        self.device, self.to_device, self.to_computer, self.step = device, to_device, to_computer, step_cycles
        self.waiting, self.cycle, self.is_open = bytearray(), 0, True
        self._clean = MessageStream()
        self.records: list[RecordMessage] = []

    def write(self, data: bytes) -> None:
        self.waiting += data

    async def read(self) -> bytes:
        while True:
            await asyncio.sleep(0)
            self.cycle += self.step
            received, self.waiting = bytes(self.waiting), bytearray()
            sent = self.device.exchange(self.to_device(received), until_cycle=self.cycle)
            for message in self._clean.feed(sent):
                if isinstance(message, RecordMessage):
                    self.records = [*self.records, message] if message.number else [message]
            if arrived := self.to_computer(sent):
                return arrived

    async def close(self) -> None:
        self.is_open = False


class Harm:
    """Bytes of one direction, some of them changed or dropped; the same for the same seed."""

    def __init__(self, seed: int, *, garbled: float = 0.0, dropped: float = 0.0):
        self.random = random.Random(seed)
        self.garbled, self.dropped = garbled, dropped

    def __call__(self, data: bytes) -> bytes:
        kept = (byte for byte in data if self.random.random() >= self.dropped)
        return bytes(self.random.randrange(256) if self.random.random() < self.garbled else byte for byte in kept)


@pytest.fixture(scope="session")
def steady_wheel() -> Callable[..., SteadyWheel]:
    return SteadyWheel


@pytest.fixture(scope="session")
def memory_line() -> Callable[..., MemoryLine]:
    return MemoryLine


@pytest.fixture(scope="session")
def harm() -> Callable[..., Harm]:
    return Harm


@pytest.fixture(scope="session")
def short_run() -> PlannedRun:
    """100 turns a second, ten control slots, 16 triggers that sample the turn in steps of a sixteenth; delay 1.7 periods."""
    scheme = TriggerScheme(turn_period_ticks=480_000, camera_period_ticks=510_000, control_slots=10)
    return PlannedRun(scheme=scheme, trigger_delay_ticks=867_001, repeats=1, is_after_correction=True)
