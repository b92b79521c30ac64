"""A Raspberry Pi Pico without its processor: the chip's PIO, DMA and pins emulated by rp2040py, the firmware run by CPython.

The modules of MicroPython that the firmware imports are made here, in terms of the emulated chip's registers.
"""

import importlib
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType, SimpleNamespace

FIRMWARE = Path(__file__).parents[2] / "src" / "irtiming" / "gateware" / "microcontroller"
MODULES = ("main", "chip", "generator", "lines", "serial_messages", "pio_programs")
PINS = {"chopper": 2, "camera": 3, "camera_nominal": 4, "control": 6, "application": 7, "camera_input": 8, "spare": 9}
SYNCHRONISER_CYCLES = 2  # of every pin, left out by the emulator
_START, _INSTRUCTIONS_BEFORE_FIRST_LOOK = 0x50200000, 3
_DMA, _DMA_TRIGGER = 0x50000000, 0x50000430
_PINS, _PADS = 0x40014000, 0x4001C000
_SIO_FUNCTION, _INPUT_WITH_PULL_UP = 5, 0x4A


def load_firmware(monkeypatch, *names):
    """The firmware's modules, imported anew; their names are free again after the test."""
    monkeypatch.syspath_prepend(str(FIRMWARE))
    for name in MODULES:
        monkeypatch.setitem(sys.modules, name, ModuleType(name))  # what monkeypatch takes away at the end
        del sys.modules[name]
    return [importlib.import_module(name) for name in names]


@dataclass
class EmulatedPico:
    """``cycle`` counts the system clock; ``changes`` holds what each output pin did as (cycle, level).

    ``zero_cycle`` is the cycle of count 0: the edge timers look at their pins for the first time.
    """

    cycles_per_access: int = 60
    cycle: int = 0
    zero_cycle: int = 0
    changes: dict = field(default_factory=lambda: {pin: [] for pin in PINS.values()})

    def __post_init__(self):
        from rp2040py import RP2040

        self.chip = RP2040()
        self.chip.simulator = SimpleNamespace()  # makes the emulator wait for `run`
        self._drives = []  # what comes from outside: cycle, pin, level
        self._arriving = []  # on its way through a synchroniser
        for pin in PINS.values():
            self.chip.gpio[pin].add_listener(lambda new, _, pin=pin: self._output(pin, int(new)))

    def drive(self, pin, changes):
        """Let the pin take levels from outside, as (cycle, level) in rising order."""
        self._drives = sorted([*self._drives, *((cycle, pin, level) for cycle, level in changes)])

    def run(self, cycles):
        """Let the system clock go on."""
        first, second = self.chip.pio
        for _ in range(cycles):
            while self._drives and self._drives[0][0] <= self.cycle:
                at, pin, level = self._drives.pop(0)
                self._arriving.append((max(at, self.cycle) + SYNCHRONISER_CYCLES, pin, level))
            while self._arriving and self._arriving[0][0] <= self.cycle:
                _, pin, level = self._arriving.pop(0)
                self.chip.gpio[pin].set_input_value(bool(level))
            first.advance(1)
            second.advance(1)
            self.chip.clock.tick(8)
            self.cycle += 1

    def _output(self, pin, level):
        if level in (0, 1):
            self.changes[pin].append((self.cycle, level))
            self._arriving.append((self.cycle + SYNCHRONISER_CYCLES, pin, level))

    def access(self, address, value=None):
        """What the processor's bus does, and the time that MicroPython takes for it."""
        self.run(self.cycles_per_access)
        if value is None:
            return self.chip.read_uint32(address)
        if address == _START and value:
            self.zero_cycle = self.cycle + _INSTRUCTIONS_BEFORE_FIRST_LOOK
        return self.chip.write_uint32(address, value & 0xFFFFFFFF)

    def install(self, monkeypatch, *, machine_name="Raspberry Pi Pico with RP2040", clock=120_000_000):
        """Give CPython the modules that MicroPython has."""
        machine = ModuleType("machine")
        machine.mem32 = _Memory(self)
        machine.freq = lambda _: None
        machine.Pin = _pin(self)
        parts = {"machine": machine, "rp2": ModuleType("rp2"), "uctypes": ModuleType("uctypes")}
        parts["rp2"].DMA = _dma(self)
        parts["uctypes"].addressof = lambda _: 0x20010004
        for name, module in parts.items():
            monkeypatch.setitem(sys.modules, name, module)
        monkeypatch.setattr(sys.implementation, "_machine", machine_name, raising=False)
        monkeypatch.setattr(time, "ticks_us", lambda: self._ticks_us(clock // 1_000_000), raising=False)
        monkeypatch.setattr(time, "ticks_diff", lambda a, b: a - b, raising=False)
        return self

    def _ticks_us(self, cycles_per_us):
        self.run(self.cycles_per_access)
        return self.cycle // cycles_per_us


class _Memory:
    def __init__(self, pico):
        self._pico = pico

    def __getitem__(self, address):
        return self._pico.access(address)

    def __setitem__(self, address, value):
        self._pico.access(address, value)


def _pin(pico):
    class Pin:
        IN, PULL_UP = 0, 1

        def __init__(self, number, mode, pull):
            assert (mode, pull) == (Pin.IN, Pin.PULL_UP)
            pico.access(_PADS + 4 + 4 * number, _INPUT_WITH_PULL_UP)
            pico.access(_PINS + 8 * number + 4, _SIO_FUNCTION)

    return Pin


def _dma(pico):
    channels = iter(range(12))

    class DMA:
        def __init__(self):
            self.channel = next(channels)
            self._at = _DMA + 0x40 * self.channel

        def pack_ctrl(self, *, size, inc_read, inc_write, ring_size, ring_sel, treq_sel):
            settings = size << 2 | inc_read << 4 | inc_write << 5 | ring_size << 6 | ring_sel << 10
            return 1 | settings | self.channel << 11 | treq_sel << 15 | 1 << 21

        def config(self, *, read, write, count, ctrl, trigger):
            assert trigger
            for offset, value in ((0, read), (4, write), (8, count), (12, ctrl)):
                pico.access(self._at + offset, value)

        @property
        def count(self):
            return pico.access(self._at + 8)

        def active(self, value):
            assert value == 1
            pico.access(_DMA_TRIGGER, 1 << self.channel)

    return DMA
