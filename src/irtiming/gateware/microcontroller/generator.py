"""The trigger generator behind its serial line: registers, refusals, queue of records.

Runs on MicroPython and on CPython. Tests hold it against irtiming.gateware.register_map and messages. The chip
(chip.py) gives it the edges of the pins and makes its pulses; it must have what `Chip` has:
``counts_per_second``, ``channels`` (those that it can record), ``lines``, ``now``, ``read_edges``, ``set_chopper``,
``start_train``, ``stop_train``, ``is_train_over`` and ``set_polarity``.
"""

from collections import deque

from serial_messages import CommandReader, pack_record, pack_reply

IDENTITY, VERSION, CLOCK_FREQUENCY, DEPTH, INPUT_LATENCY, OUTPUT_LATENCY = range(6)
COMMAND, STATUS, WRITTEN, LOST, COUNTER_LOW, COUNTER_HIGH, GARBLED = range(0x10, 0x17)
CHOPPER_WIDTH, CHOPPER_PERIOD = 0x20, 0x21
CAMERA_WIDTH, CAMERA_PERIOD, CAMERA_COUNT, CAMERA_DELAY = range(0x28, 0x2C)
POLARITY, CHANNELS, FILTER = range(0x30, 0x33)

ARM, START, STOP = 1, 2, 3
ARMED, TRIGGERING, FINISHED, LOSS_STATUS, QUEUE_EMPTY = 1, 2, 4, 8, 16
NONE, UNKNOWN_REGISTER, READ_ONLY, BUSY, BAD_VALUE, NOT_ARMED = range(6)
WRITE = 1
LOSS = 0x80
QUEUE_DEPTH = 512
INPUT_LATENCY_COUNTS = 1  # the chip's synchroniser: two cycles of its clock
SHORTEST_COUNTS = 8  # of a pulse and of the gap after it, so that every edge is timed to one count

_LARGEST = 0xFFFFFFFF
_WIDTH_OF = {CHOPPER_PERIOD: CHOPPER_WIDTH, CAMERA_PERIOD: CAMERA_WIDTH}
_READ_ONLY = set(range(IDENTITY, OUTPUT_LATENCY + 1)) | set(range(STATUS, GARBLED + 1))
_LIMITS = {
    COMMAND: (1, 3),
    CHOPPER_WIDTH: (1, _LARGEST),
    CHOPPER_PERIOD: (2, _LARGEST),
    CAMERA_WIDTH: (1, _LARGEST),
    CAMERA_PERIOD: (2, _LARGEST),
    CAMERA_COUNT: (1, _LARGEST),
    CAMERA_DELAY: (0, _LARGEST),
    POLARITY: (0, 0x5F),
    CHANNELS: (0, 0x7F),
    FILTER: (0, 255),
}


class Generator:
    """Answers commands and turns edges into records."""

    def __init__(self, chip):
        clock = chip.counts_per_second
        self._chip = chip
        self._reader = CommandReader()
        self._fixed = {
            IDENTITY: 0x49525447,
            VERSION: 1 << 16,
            CLOCK_FREQUENCY: clock,
            DEPTH: QUEUE_DEPTH,
            INPUT_LATENCY: INPUT_LATENCY_COUNTS,
            OUTPUT_LATENCY: 0,
            COMMAND: 0,
        }
        self._settings = {
            CHOPPER_WIDTH: clock // 300 // 2,
            CHOPPER_PERIOD: clock // 300,
            CAMERA_WIDTH: clock // 30 // 2,
            CAMERA_PERIOD: clock // 30,
            CAMERA_COUNT: 1,
            CAMERA_DELAY: 0,
            POLARITY: 0,
            CHANNELS: 0x1B,
            FILTER: 0,
        }
        self._committed = {period: self._settings[width] for period, width in _WIDTH_OF.items()}
        self._margin = clock // 50000  # 20 us: an edge that is so old has reached memory
        self._counter_high = 0
        self._is_triggering = False
        self._events = []
        self._queue = deque((), QUEUE_DEPTH)  # noqa: RUF037 - MicroPython's deque has no default
        self._forget()
        self._is_armed = False
        self._set_up_lines()

    def receive(self, data: bytes, now_ms: int) -> bytes:
        """Take bytes of the line as they come, none included; give the bytes of the replies."""
        replies = b""
        self._reader.idle(now_ms)
        for byte in data:
            command = self._reader.feed(byte, now_ms)
            if command is not None:
                operation, tag, address, value = command
                refusal = self._refusal(operation, address, value)
                if refusal == NONE and operation == WRITE:
                    self._write(address, value)
                value = 0 if refusal == UNKNOWN_REGISTER else self._read(address)
                replies += pack_reply(refusal=refusal, tag=tag, address=address, value=value)
        return replies

    def work(self) -> None:
        """Take what the pins did since the last time; to be called every second at least."""
        self._take_edges(self._chip.now() - self._margin)
        self._look_at_train()

    def next_record(self) -> bytes:
        """Bytes of the oldest record that waits, none if there is none."""
        return self._queue.popleft() if self._queue else b""

    def _refusal(self, operation, address, value):
        """Why a command is refused, in the order of the FPGA's circuit."""
        if address not in _LIMITS and address not in _READ_ONLY:
            return UNKNOWN_REGISTER
        if operation > WRITE:
            return BAD_VALUE
        if operation != WRITE:
            return NONE
        if address in _READ_ONLY:
            return READ_ONLY
        self._look_at_train()
        is_busy = self._is_armed or self._is_triggering
        if address != COMMAND and is_busy:
            return BUSY
        lowest, highest = _LIMITS[address]
        if not lowest <= value <= highest or not self._fits(address, value):
            return BAD_VALUE
        if address == COMMAND and value == ARM:
            if is_busy:
                return BUSY
            if any(self._settings[width] != self._committed[period] for period, width in _WIDTH_OF.items()):
                return BAD_VALUE
        if address == COMMAND and value == START:
            if not self._is_armed:
                return NOT_ARMED
            if self._is_triggering or self._is_finished:
                return BUSY
        return NONE

    def _fits(self, address, value):
        """Whether this chip can do what the register map allows."""
        if address in _WIDTH_OF:
            width = self._settings[_WIDTH_OF[address]]
            return width >= SHORTEST_COUNTS and value - width >= SHORTEST_COUNTS
        return address != CHANNELS or not value & ~self._chip.channels

    def _write(self, address, value):
        if address == COMMAND:
            (self._arm, self._start, self._stop)[value - 1]()
            return
        self._settings[address] = value
        if address in _WIDTH_OF:
            self._committed[address] = self._settings[_WIDTH_OF[address]]
        if address == CHOPPER_PERIOD:
            self._chip.set_chopper(width=self._committed[address], period=value)
        if address == POLARITY:
            self._chip.set_polarity(value)
        if address in (POLARITY, CHANNELS, FILTER):
            self._set_up_lines()

    def _read(self, address):
        if address in self._fixed:
            return self._fixed[address]
        if address in self._settings:
            return self._settings[address]
        if address == COUNTER_LOW:
            now = self._chip.now()
            self._counter_high = now >> 32 & 0xFFFF
            return now & _LARGEST
        if address == COUNTER_HIGH:
            return self._counter_high
        if address == STATUS:
            return self._status()
        counted = {WRITTEN: self._written & _LARGEST, LOST: self._lost, GARBLED: self._reader.garbled}
        return min(counted[address], _LARGEST)

    def _status(self):
        self._look_at_train()
        is_empty = not self._queue and not self._events
        return (
            self._is_armed * ARMED
            | self._is_triggering * TRIGGERING
            | self._is_finished * FINISHED
            | (self._lost > 0) * LOSS_STATUS
            | is_empty * QUEUE_EMPTY
        )

    def _set_up_lines(self):
        settings = self._settings
        for line in self._chip.lines:
            line.set_up(
                channels=settings[CHANNELS],
                polarity=settings[POLARITY],
                filter_counts=settings[FILTER],
                # The edges of the chip's own pulses are read back from the pin, through the same synchroniser.
                shift=0 if line.is_filtered else -INPUT_LATENCY_COUNTS,
            )

    def _forget(self):
        """As it must be when recording begins."""
        while self._queue:
            self._queue.popleft()
        self._written = self._lost = 0
        self._is_after_loss = self._is_finished = False
        self._from = self._chip.now()

    def _arm(self):
        self.work()  # what the lines did before is no event
        self._forget()
        self._is_armed = True

    def _start(self):
        settings = self._settings
        self._is_triggering = True
        self._is_stopped = False
        self._chip.start_train(
            width=settings[CAMERA_WIDTH],
            period=settings[CAMERA_PERIOD],
            count=settings[CAMERA_COUNT],
            delay=settings[CAMERA_DELAY],
        )

    def _stop(self):
        until = self._chip.now() + 1
        self._look_at_train()
        if self._is_triggering:
            self._is_stopped = True
            self._chip.stop_train()
        if self._is_armed:
            while self._chip.now() < until + self._margin:
                pass  # some microseconds, until the last edges have reached memory
            self._take_edges(until)
            self._events.clear()
        self._is_armed = False

    def _look_at_train(self):
        if self._is_triggering and self._chip.is_train_over():
            self._is_triggering = False
            self._is_finished = not self._is_stopped

    def _take_edges(self, until):
        """Edges into events and, those that no event can precede any more, into records; all before ``until`` have come."""
        for line, lost in self._chip.read_edges():
            if lost and self._is_armed and line.is_recorded:
                self._lost += lost
                self._is_after_loss = True
            line.settle(until)
            if line.events:
                self._events += line.events
                line.events = []
        self._release(until - INPUT_LATENCY_COUNTS)  # by so much times of own pulses are moved back

    def _release(self, before):
        """Events before that count into records, those of one count together; the others wait."""
        events = self._events
        if not self._is_armed:
            events.clear()
        if not events:
            return
        events.sort()
        time, channels, taken = -1, 0, 0
        for event_time, mask in events:
            if event_time >= before:
                break
            if event_time != time:
                self._record(time, channels)
                time, channels = event_time, 0
            channels |= mask
            taken += 1
        self._record(time, channels)
        self._events = events[taken:]

    def _record(self, time, channels):
        if time < self._from:
            return
        if len(self._queue) == QUEUE_DEPTH:
            self._lost += 1
            self._is_after_loss = True
            return
        if self._is_after_loss:
            channels |= LOSS
            self._is_after_loss = False
        self._queue.append(pack_record(channels=channels, number=self._written & 0xFFFF, time=time))
        self._written += 1
