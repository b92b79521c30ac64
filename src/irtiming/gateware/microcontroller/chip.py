"""What the generator needs of an RP2040 or RP2350: pulses and edge times by PIO, memory filled by DMA.

MicroPython only. The registers of PIO and of the pins are written as the chips' data sheets name them, because
MicroPython has no words for starting several state machines in one cycle, for STATUS and for RXSTALL.

One count is two cycles of the system clock. All state machines that time edges are started by one write, so they count
the same counts. The crystal that drives them also drives the microsecond timer; that one tells which 2^31 counts a
31-bit time belongs to, to some microseconds.
"""

import sys
from time import ticks_diff, ticks_us

import machine
import rp2
import uctypes
from lines import WATCHED, Line
from machine import mem32
from pio_programs import CHOPPER, EDGES, TRAIN

CYCLES_PER_COUNT = 2
RING_WORDS = 1024  # edges of one line that can wait, 1.7 s of the 600 a second that a control ring gives
TRANSFERS = 0x0FFFFFFF  # of a DMA channel before it must be started again, which is done in time
_RING_SHIFT = 12  # log2 of a ring's bytes

_SET, _CLEAR = 0x2000, 0x3000  # offsets that make a write set or clear bits
_CTRL, _FDEBUG, _FLEVEL, _TXF, _RXF, _CODE = 0x00, 0x08, 0x0C, 0x10, 0x20, 0x48
_CLKDIV, _EXECCTRL, _SHIFTCTRL, _ADDR, _INSTR, _PINCTRL = 0xC8, 0xCC, 0xD0, 0xD4, 0xD8, 0xDC
_MACHINE = 0x18  # from a state machine's registers to the next one's
_PIO = (0x50200000, 0x50300000, 0x50400000)
_PULL_NOBLOCK, _SET_PIN_LOW, _SET_PIN_OUT = 0x8080, 0xE000, 0xE081
_JOIN_RX = 1 << 31
_PIO1_FUNCTION = 7
_CHOPPER_OUTPUT, _CAMERA_OUTPUT = 1, 2  # of the register POLARITY

_NOMINAL, _DELAYED, _CHOPPER = 0, 1, 2  # state machines of PIO 1


class Chip:
    """The pins, by their names: ``pins`` gives the GPIO number of each."""

    def __init__(self, pins: dict):
        is_rp2350 = "RP2350" in sys.implementation._machine
        self._pin_bank, self._override_shift = (0x40028000, 12) if is_rp2350 else (0x40014000, 8)
        clock = 150_000_000 if is_rp2350 else 120_000_000
        machine.freq(clock)
        self.counts_per_second = clock // CYCLES_PER_COUNT
        self._counts_per_us = self.counts_per_second // 1_000_000
        self._pins = pins
        watched = WATCHED if is_rp2350 else WATCHED[:4]
        self._memory = bytearray((len(watched) + 1) * RING_WORDS * 4)
        ring = (uctypes.addressof(self._memory) + RING_WORDS * 4 - 1) & -(RING_WORDS * 4)
        self._watchers = []
        for name, pio, number, line in watched:
            self._watchers.append(_Watcher(_PIO[pio], number, ring=ring, line=Line(**line)))
            _set_up_input(pins[name])
            ring += RING_WORDS * 4
        self.lines = [watcher.line for watcher in self._watchers]
        self.channels = 0x7F if is_rp2350 else 0x3B
        self._chopper_waits = None
        self._train_at, self._is_stopping = 0, False
        self._set_up_outputs()
        self._set_up_watchers()
        # One write for all that time edges: the bits 16..19 and 24 start those of PIO 2, which comes before PIO 0.
        mem32[_PIO[0] + _CTRL] = 0x0103000F if is_rp2350 else 0x0F
        self._last_us = ticks_us()
        self._elapsed_us = -1  # what the timer leaves out of a microsecond

    def now(self) -> int:
        """Count that has come for certain; the true one is some microseconds ahead."""
        us = ticks_us()
        self._elapsed_us += ticks_diff(us, self._last_us)
        self._last_us = us
        return self._elapsed_us * self._counts_per_us

    def read_edges(self) -> "list[tuple[Line, int]]":
        """Hand the lines their new edges; give each line and how many edges it lost."""
        if self._chopper_waits:
            self._send_chopper()
        now = self.now()
        return [(watcher.line, watcher.read(now)) for watcher in self._watchers]

    def set_chopper(self, *, width: int, period: int) -> None:
        """Pulses of the chopper's reference, from the end of the running period on."""
        self._chopper_waits = (width - 2, period - width - 5)
        self._send_chopper()

    def start_train(self, *, width: int, period: int, count: int, delay: int) -> None:
        """Begin the nominal and the delayed train in the same cycle."""
        base, both = _PIO[1], 1 << _NOMINAL | 1 << _DELAYED
        mem32[base + _CTRL + _CLEAR] = both
        mem32[base + _CTRL + _SET] = both << 4
        for number, waits in ((_NOMINAL, 0), (_DELAYED, delay)):
            for _ in range(4):
                _execute(base, number, _PULL_NOBLOCK)  # words that an earlier train left
            _execute(base, number, self._train_at)  # a jump to its first instruction
            for word in (width - 2, count - 1, waits, period - width - 5):
                mem32[base + _TXF + 4 * number] = word
        self._is_stopping = False
        mem32[base + _CTRL + _SET] = both

    def stop_train(self) -> None:
        """No pulse begins from now on; one that runs keeps its width."""
        for number in (_NOMINAL, _DELAYED):
            mem32[_PIO[1] + _TXF + 4 * number] = 0
        self._is_stopping = True

    def is_train_over(self) -> bool:
        """Whether all pulses are over, or the last one that will be after `stop_train`."""
        active, done = (self._train_at + TRAIN["labels"][name] for name in ("active", "done"))
        for number in (_NOMINAL, _DELAYED):
            at = mem32[_PIO[1] + _ADDR + _MACHINE * number]
            # The fifth word is there before this look: a program that is not inside a pulse begins no other one.
            is_over = at not in (active - 1, active) if self._is_stopping else at == done
            if not is_over:
                return False
        return True

    def set_polarity(self, polarity: int) -> None:
        """Which outputs idle high; all others idle low."""
        for name, bit in (("chopper", _CHOPPER_OUTPUT), ("camera", _CAMERA_OUTPUT), ("camera_nominal", 0)):
            inverted = 1 if polarity & bit else 0
            mem32[self._pin_bank + 8 * self._pins[name] + 4] = _PIO1_FUNCTION | inverted << self._override_shift

    def _set_up_outputs(self):
        base = _PIO[1]
        mem32[base + _CTRL] = 0
        self._train_at = _load(base, TRAIN, at=0)
        chopper_at = _load(base, CHOPPER, at=len(TRAIN["code"]))
        for number, name in ((_NOMINAL, "camera_nominal"), (_DELAYED, "camera"), (_CHOPPER, "chopper")):
            program, at = (CHOPPER, chopper_at) if number == _CHOPPER else (TRAIN, self._train_at)
            _set_up_input(self._pins[name])
            _set_up_machine(base, number, program=program, at=at, pin=self._pins[name])
            _execute(base, number, _SET_PIN_LOW)
            _execute(base, number, _SET_PIN_OUT)
        self.set_polarity(0)
        period = self.counts_per_second // 300
        self.set_chopper(width=period // 2, period=period)
        mem32[base + _CTRL] = 1 << _CHOPPER

    def _set_up_watchers(self):
        for base in {watcher.base for watcher in self._watchers}:
            mem32[base + _CTRL] = 0
            _load(base, EDGES, at=0)
        for (name, *_), watcher in zip(WATCHED, self._watchers):  # noqa: B905 - MicroPython's zip knows no strict
            _set_up_machine(watcher.base, watcher.number, program=EDGES, at=0, pin=self._pins[name])
            watcher.start_transfers()

    def _send_chopper(self):
        """Hand the two words over once the earlier pair has been taken."""
        base = _PIO[1]
        if not mem32[base + _FLEVEL] >> 8 * _CHOPPER & 0xF:
            for word in self._chopper_waits:
                mem32[base + _TXF + 4 * _CHOPPER] = word
            self._chopper_waits = None


class _Watcher:
    """A state machine that times the edges of one pin, and the ring in memory that its times go to."""

    def __init__(self, base, number, *, ring, line):
        self.base, self.number, self.line = base, number, line
        self._ring = ring
        self._dma = rp2.DMA()
        self._restarts = self._words_read = 0

    def start_transfers(self):
        pio = _PIO.index(self.base)
        control = self._dma.pack_ctrl(
            size=2, inc_read=False, inc_write=True, ring_size=_RING_SHIFT, ring_sel=True,
            treq_sel=8 * pio + 4 + self.number,
        )  # fmt: skip
        source = self.base + _RXF + 4 * self.number
        self._dma.config(read=source, write=self._ring, count=TRANSFERS, ctrl=control, trigger=True)

    def read(self, now):
        """Hand all new edges to the line; give how many were lost, at least one if the chip says that any was."""
        written = self._words_written()
        new = written - self._words_read
        lost = 0
        if new > RING_WORDS - 8:  # the oldest are overwritten, perhaps right now
            lost, new = new, 0
        ring, line = self._ring, self.line
        for index in range(self._words_read, self._words_read + new):
            word = mem32[ring + 4 * (index % RING_WORDS)]
            behind = (now + (word >> 1) + 1 + 0x40000000 & 0x7FFFFFFF) - 0x40000000  # X counts down from all ones
            line.edge(now - behind, word & 1)
        self._words_read = written
        stalled = mem32[self.base + _FDEBUG] & 1 << self.number
        if stalled:
            mem32[self.base + _FDEBUG] = stalled
            lost += 1
        return lost

    def _words_written(self):
        remaining = self._dma.count
        if remaining == 0:
            self._restarts += 1
            self._dma.active(1)
            remaining = TRANSFERS
        return self._restarts * TRANSFERS + TRANSFERS - remaining


def _set_up_input(number):
    machine.Pin(number, machine.Pin.IN, machine.Pin.PULL_UP)


def _load(base, program, *, at):
    """Write a program into the memory of a PIO, jumps moved; gives where it begins."""
    for index, word in enumerate(program["code"]):
        mem32[base + _CODE + 4 * (at + index)] = word + at if word >> 13 == 0 else word
    return at


def _set_up_machine(base, number, *, program, at, pin):
    """Pin of side-set, SET and JMP alike, queue of times joined to eight words, clock undivided."""
    registers = base + _MACHINE * number
    has_side_set = program["side_set"]
    mem32[base + _CTRL + _SET] = 1 << 4 + number
    mem32[registers + _CLKDIV] = 1 << 16
    mem32[registers + _EXECCTRL] = (
        pin << 24 | at + program["wrap"] << 12 | at + program["wrap_target"] << 7 | program["status_n"]
    )
    mem32[registers + _SHIFTCTRL] = _JOIN_RX if has_side_set else 0  # to join the queues or part them empties them
    mem32[registers + _SHIFTCTRL] = 0 if has_side_set else _JOIN_RX
    mem32[registers + _PINCTRL] = has_side_set << 29 | 1 << 26 | pin << 10 | pin << 5
    _execute(base, number, at)


def _execute(base, number, instruction):
    """Let a state machine that stands still do one instruction; a bare address is a jump there."""
    mem32[base + _INSTR + _MACHINE * number] = instruction
