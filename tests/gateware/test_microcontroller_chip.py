"""The microcontroller's whole firmware on an emulated RP2040: pins, state machines, DMA, records."""

import random
import sys
from itertools import pairwise
from types import ModuleType

import numpy as np
import pytest
from emulated_pico import PINS, EmulatedPico, load_firmware

from irtiming.gateware import event_model, messages, register_map
from irtiming.gateware.messages import CommandMessage, Operation
from irtiming.gateware.register_map import ADDRESS, Channel, Command, Polarity, Refusal, Status

CHOPPER, CAMERA, NOMINAL, CONTROL, APPLICATION = (
    PINS[name] for name in ("chopper", "camera", "camera_nominal", "control", "application")
)
TRIGGERS = Channel.CAMERA_TRIGGER | Channel.CAMERA_TRIGGER_DELAYED


class Board:
    """The emulated board with its firmware, as it is after it was switched on."""

    def __init__(self, monkeypatch, **constants):
        pytest.importorskip("rp2040py")
        self.pico = EmulatedPico().install(monkeypatch)
        for pin in (CONTROL, APPLICATION):
            self.pico.drive(pin, [(0, 0)])
        self.chip_file, self.generator_file = load_firmware(monkeypatch, "chip", "generator")
        for name, value in constants.items():
            monkeypatch.setattr(self.chip_file, name, value)
        self.chip = self.chip_file.Chip(PINS)
        self.generator = self.generator_file.Generator(self.chip)

    def write(self, name, value):
        command = CommandMessage(operation=Operation.WRITE, tag=0, address=ADDRESS[name], value=value)
        return self._answer(command).refusal

    def read(self, name):
        return self._answer(CommandMessage(operation=Operation.READ, tag=0, address=ADDRESS[name])).value

    def _answer(self, command):
        return messages.unpack_reply(self.generator.receive(messages.pack_command(command), 0))

    def set_up(self, **settings):
        for name, value in settings.items():
            assert self.write(name, value) == Refusal.NONE

    def work(self, cycles):
        """Let the main loop run for so long; give the records."""
        until, found = self.pico.cycle + cycles, []
        while self.pico.cycle < until:
            self.generator.work()
            while data := self.generator.next_record():
                found.append(messages.unpack_record(data))
        return found

    def count_after(self, cycle):
        """First count at or after a cycle."""
        return -(-(cycle - self.pico.zero_cycle) // 2)

    def edges(self, pin, level, *, since=0):
        return [cycle for cycle, new in self.pico.changes[pin] if new == level and cycle >= since]


@pytest.fixture
def board(monkeypatch):
    return Board(monkeypatch)


def _times(records, channel):
    return [record.time_ticks for record in records if record.channels & channel]


@pytest.mark.parametrize("seed", range(5))
def test_pins_and_records_of_a_train_are_exact(monkeypatch, seed):
    """Oracle: t0 + k C and t0 + D + k C of the event model in counts; the pins in cycles of the system clock."""
    draw = random.Random(seed)
    width = draw.randrange(8, 40)
    period, count = width + draw.randrange(8, 200), draw.randrange(1, 12)
    delay = draw.choice([0, 1, period, draw.randrange(3 * period)])
    board = Board(monkeypatch)
    board.set_up(CAMERA_WIDTH=width, CAMERA_PERIOD=period, CAMERA_COUNT=count, CAMERA_DELAY=delay, COMMAND=Command.ARM)
    board.set_up(COMMAND=Command.START)
    records = board.work(2 * (count * period + delay) + 12_000)
    for pin, shift in ((NOMINAL, 0), (CAMERA, 2 * delay)):
        rises, falls = board.edges(pin, 1), board.edges(pin, 0, since=board.pico.zero_cycle)
        first = board.edges(NOMINAL, 1)[0] + shift
        assert rises == [first + 2 * period * k for k in range(count)]
        assert falls == [rise + 2 * width for rise in rises]
    settings = event_model.Settings(
        chopper_width=1, chopper_period=2, camera_width=width, camera_period=period, camera_count=count,
        camera_delay=delay, channels=0x7F, bit_cycles=1,
    )  # fmt: skip
    t0 = board.count_after(board.edges(NOMINAL, 1)[0])
    nominal, delayed = event_model.trigger_ticks(settings, event_model.Run(first_trigger_cycle=t0))
    assert _times(records, Channel.CAMERA_TRIGGER) == nominal.tolist()
    assert _times(records, Channel.CAMERA_TRIGGER_DELAYED) == delayed.tolist()
    assert len(records) == len({*nominal.tolist(), *delayed.tolist()})  # one record for what comes in one count
    assert Status(board.read("STATUS")) == Status.ARMED | Status.FINISHED | Status.QUEUE_EMPTY


@pytest.mark.parametrize("glitch_filter", [0, 40])
def test_edges_of_the_inputs_are_those_of_the_event_model(board, glitch_filter):
    """Oracle: event_model.recorded_events with edges at any cycle; less than one count late, none early, none missing."""
    draw = random.Random(glitch_filter)
    board.set_up(CHANNELS=0x3B, FILTER=glitch_filter, POLARITY=Polarity.APPLICATION_SLOT, COMMAND=Command.ARM)
    begin, pins = board.pico.cycle + 500, {}
    for channel, pin in ((Channel.CONTROL_SLOT, CONTROL), (Channel.APPLICATION_SLOT, APPLICATION)):
        lengths = [draw.randrange(10, 400) for _ in range(120)]
        cycles = (begin + np.cumsum(lengths)).tolist()
        levels = [(i + 1) % 2 for i in range(len(cycles))]
        board.pico.drive(pin, list(zip(cycles, levels, strict=True)))
        counts = np.array([board.count_after(cycle) for cycle in cycles])
        later = register_map.INPUT_LATENCY_CYCLES + 1 - board.read("INPUT_LATENCY")
        pins[channel] = event_model.PinChanges(cycle=counts - later, level=np.array(levels))
    records = board.work(120 * 400 + 12_000)
    settings = event_model.Settings(
        chopper_width=1, chopper_period=2, camera_width=1, camera_period=2, camera_count=1, channels=0x3B,
        polarity=Polarity.APPLICATION_SLOT, filter=glitch_filter, bit_cycles=1,
    )  # fmt: skip
    events = event_model.recorded_events(settings, pins, run=event_model.Run())
    assert [(r.time_ticks, r.channels) for r in records] == list(
        zip(events.time_ticks.tolist(), events.channels.tolist(), strict=True)
    )
    assert len(records) > (150 if glitch_filter == 0 else 80)
    assert board.read("RECORDS_LOST") == 0


def test_times_go_on_beyond_what_a_word_holds(board):
    """Oracle: the cycle of each edge plus the counts that were left out: the machines pass 2^31 and 2^32, times do not wrap."""
    for skipped in (2**31 - 2000, 2**31):
        board.chip._elapsed_us += skipped // 60
        for machine in board.pico.chip.pio[0].machines:
            machine.x = (machine.x - skipped // 60 * 60) % 2**32
    added = (2**31 - 2000) // 60 * 60 + 2**31 // 60 * 60
    board.set_up(COMMAND=Command.ARM)
    cycles = [board.pico.cycle + 300 + 400 * k for k in range(20)]
    board.pico.drive(CONTROL, [(cycle, (k + 1) % 2) for k, cycle in enumerate(cycles)])
    records = board.work(22_000)
    assert [r.time_ticks for r in records] == [board.count_after(cycle) + 1 + added for cycle in cycles[::2]]
    assert records[0].time_ticks < 2**32 < records[-1].time_ticks + 10_000


def test_the_counter_that_is_read_is_never_ahead_and_at_most_twenty_microseconds_behind(board):
    """Oracle: the emulator's cycle; 20 us is what the main loop allows for."""
    for _ in range(50):
        now = board.chip.now()
        true = (board.pico.cycle - board.pico.zero_cycle) // 2
        assert 0 <= true - now <= 20 * 60


def test_the_chopper_runs_from_the_start_and_is_not_disturbed_by_a_measurement(board):
    """Oracle: n T' in cycles; a train is armed, started and stopped meanwhile."""
    board.set_up(CHOPPER_WIDTH=50, CHOPPER_PERIOD=150)
    board.pico.run(410_000)  # the first period, 1/300 s, is over
    since = board.pico.cycle
    board.set_up(CAMERA_WIDTH=20, CAMERA_PERIOD=90, CAMERA_COUNT=20, COMMAND=Command.ARM)
    for command in (Command.START, Command.STOP):
        board.set_up(COMMAND=command)
        board.work(4000)
    rises = board.edges(CHOPPER, 1, since=since)
    assert rises == [rises[0] + 300 * k for k in range(len(rises))]
    assert len(rises) > 20
    falls = board.edges(CHOPPER, 0, since=rises[0])
    assert falls == [rise + 100 for rise in rises[: len(falls)]]


def test_new_chopper_settings_hold_from_the_end_of_the_running_period(board):
    """Oracle: by hand: whole periods of the old length, one of the next, then of the last; each pulse has its width."""
    board.set_up(CHOPPER_WIDTH=40, CHOPPER_PERIOD=8000)
    board.pico.run(410_000)
    board.pico.changes[CHOPPER].clear()
    board.pico.run(30_000)
    board.set_up(CHOPPER_WIDTH=300, CHOPPER_PERIOD=700)
    board.set_up(CHOPPER_WIDTH=9, CHOPPER_PERIOD=99)  # never taken: the next one comes before
    board.set_up(CHOPPER_WIDTH=10, CHOPPER_PERIOD=2000)
    board.work(40_000)
    changes = board.pico.changes[CHOPPER]
    pulses = list(zip([c for c, level in changes if level], [c for c, level in changes if not level], strict=False))
    seen = [((fall - rise) // 2, (following - rise) // 2) for (rise, fall), (following, _) in pairwise(pulses)]
    assert seen == sorted(seen, key=[(40, 8000), (300, 700), (10, 2000)].index)
    assert set(seen) == {(40, 8000), (300, 700), (10, 2000)}
    assert seen.count((300, 700)) == 1


def test_stop_lets_a_pulse_end_and_no_other_begin(board):
    """Oracle: pins in cycles: each pulse 400 counts; after STOP no rise; the device is free once the pulse is over."""
    board.set_up(CAMERA_WIDTH=400, CAMERA_PERIOD=1000, CAMERA_COUNT=50, CAMERA_DELAY=5000, COMMAND=Command.ARM)
    board.set_up(COMMAND=Command.START)
    while len(board.edges(CAMERA, 1)) < 3:
        board.work(100)
    assert board.pico.changes[CAMERA][-1][1] == 1
    stopped = board.pico.cycle
    board.set_up(COMMAND=Command.STOP)
    board.work(6000)
    rises, falls = board.edges(CAMERA, 1), board.edges(CAMERA, 0, since=board.pico.zero_cycle)
    assert falls == [rise + 800 for rise in rises]
    assert max(board.edges(NOMINAL, 1) + rises) < stopped + 300
    assert Status(board.read("STATUS")) & (Status.ARMED | Status.TRIGGERING | Status.FINISHED) == 0
    board.set_up(CAMERA_COUNT=2, CAMERA_DELAY=0, COMMAND=Command.ARM)
    board.set_up(COMMAND=Command.START)
    times = [record.time_ticks for record in board.work(16_000)]
    assert len(times) == 2
    assert times[1] - times[0] == 1000


def test_stop_before_the_delay_is_over_lets_no_pulse_reach_the_camera(board):
    """Oracle: the camera's pin never rises, and the next train starts as if nothing had been."""
    board.set_up(CAMERA_WIDTH=20, CAMERA_PERIOD=100, CAMERA_DELAY=2**32 - 1, COMMAND=Command.ARM)
    board.set_up(COMMAND=Command.START)
    board.work(2000)
    assert Status(board.read("STATUS")) & Status.TRIGGERING
    board.set_up(COMMAND=Command.STOP)
    assert Status(board.read("STATUS")) & Status.TRIGGERING == 0
    assert board.edges(CAMERA, 1) == []
    board.set_up(CAMERA_DELAY=7, COMMAND=Command.ARM)
    board.set_up(COMMAND=Command.START)
    assert [record.channels for record in board.work(12_000)] == [
        Channel.CAMERA_TRIGGER, Channel.CAMERA_TRIGGER_DELAYED,
    ]  # fmt: skip


def test_inverted_outputs_idle_high_and_are_recorded_at_their_falling_edge(board):
    """Oracle: levels of the pins, and the counts of the camera pin's falling edges."""
    board.set_up(POLARITY=Polarity.CAMERA_OUTPUT | Polarity.CHOPPER_OUTPUT)
    board.work(1000)
    assert board.pico.changes[CAMERA][-1][1] == 1
    since = board.pico.cycle
    board.set_up(CAMERA_WIDTH=20, CAMERA_PERIOD=100, CAMERA_COUNT=3, COMMAND=Command.ARM)
    board.set_up(COMMAND=Command.START)
    records = board.work(12_000)
    falls = board.edges(CAMERA, 0, since=since)
    assert _times(records, Channel.CAMERA_TRIGGER_DELAYED) == [board.count_after(cycle) for cycle in falls]
    assert [record.channels for record in records] == [TRIGGERS] * 3
    assert board.edges(CAMERA, 1, since=since) == [fall + 40 for fall in falls]


def test_a_queue_that_nobody_empties_loses_words_but_no_time(board):
    """Oracle: by hand: with DMA held, the chip's four words fill; RXSTALL, then the loss bit; later times are still exact."""
    board.set_up(COMMAND=Command.ARM)
    held = board.pico.chip.dma.channels[2]  # the control line's
    control = held.read_uint32(0x10)
    held.write_uint32(0x10, control & ~1)
    cycles = [board.pico.cycle + 400 + 200 * k for k in range(12)]
    board.pico.drive(CONTROL, [(cycle, (k + 1) % 2) for k, cycle in enumerate(cycles)])
    board.pico.run(3500)
    held.write_uint32(0x10, control)
    late = [board.pico.cycle + 2000 + 200 * k for k in range(4)]
    board.pico.drive(CONTROL, [(cycle, (k + 1) % 2) for k, cycle in enumerate(late)])
    records = board.work(16_000)
    kept = [*cycles[:4:2], *late[::2]]
    assert [record.time_ticks for record in records] == [board.count_after(cycle) + 1 for cycle in kept]
    assert [record.is_after_loss for record in records].count(True) == 1
    assert board.read("RECORDS_LOST") >= 1
    assert Status(board.read("STATUS")) & Status.LOSS


def test_a_ring_that_overflows_is_a_loss(monkeypatch):
    """Oracle: by hand: 16 words of memory, 30 edges before the main loop looks again, all lost; the next is right."""
    board = Board(monkeypatch, RING_WORDS=16, _RING_SHIFT=6)
    board.set_up(COMMAND=Command.ARM)
    board.pico.drive(CONTROL, [(board.pico.cycle + 300 + 60 * k, (k + 1) % 2) for k in range(30)])
    board.pico.run(3000)
    late = board.pico.cycle + 3000
    board.pico.drive(CONTROL, [(late, 1)])
    (record,) = board.work(14_000)
    assert (record.time_ticks, record.is_after_loss) == (board.count_after(late) + 1, True)
    assert board.read("RECORDS_LOST") == 30


def test_a_dma_channel_that_has_done_its_count_is_started_again_in_time(monkeypatch):
    """Oracle: the cycle of every edge: 90 edges through channels of 20 transfers, and through a ring of 16 words."""
    board = Board(monkeypatch, TRANSFERS=20, RING_WORDS=16, _RING_SHIFT=6)
    board.set_up(COMMAND=Command.ARM)
    cycles = [board.pico.cycle + 300 + 900 * k for k in range(90)]
    board.pico.drive(CONTROL, [(cycle, (k + 1) % 2) for k, cycle in enumerate(cycles)])
    records = board.work(95_000)
    assert [record.time_ticks for record in records] == [board.count_after(cycle) + 1 for cycle in cycles[::2]]
    assert board.read("RECORDS_LOST") == 0


def test_what_an_rp2350_is_told(monkeypatch):
    """Oracle: the data sheet of the RP2350, by hand: third PIO, its DREQs, the one write that starts all, bits 12 and 13."""
    written, transfers = [], []

    class Memory:
        def __getitem__(self, address):
            return 0

        def __setitem__(self, address, value):
            written.append((address, value))

    class Dma:
        count = 0x0FFFFFFF

        def pack_ctrl(self, **settings):
            return settings

        def config(self, **settings):
            transfers.append((settings["read"], settings["ctrl"]["treq_sel"], settings["write"] % 4096))

    machine, rp2, uctypes = (ModuleType(name) for name in ("machine", "rp2", "uctypes"))
    frequencies = []
    machine.mem32, machine.freq = Memory(), frequencies.append
    machine.Pin = type("Pin", (), {"IN": 0, "PULL_UP": 1, "__init__": lambda *_: None})
    rp2.DMA, uctypes.addressof = Dma, lambda _: 0x20000008
    for module in (machine, rp2, uctypes):
        monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setattr(sys.implementation, "_machine", "Raspberry Pi Pico2 with RP2350", raising=False)
    monkeypatch.setattr("time.ticks_us", lambda: 0, raising=False)
    monkeypatch.setattr("time.ticks_diff", lambda a, b: a - b, raising=False)
    (chip_file,) = load_firmware(monkeypatch, "chip")
    chip = chip_file.Chip(PINS)
    assert (frequencies, chip.counts_per_second, chip.channels) == ([150_000_000], 75_000_000, 0x7F)
    assert chip.counts_per_second % 3000 == 0
    assert written[-1] == (0x50200000, 1 << 24 | 0b0011 << 16 | 0b1111)
    pio0, pio2 = 0x50200000, 0x50400000
    sources = [(pio0 + 0x20 + 4 * n, 4 + n, 0) for n in range(4)] + [(pio2 + 0x20 + 4 * n, 20 + n, 0) for n in range(2)]
    assert transfers == sources
    chip.set_polarity(Polarity.CAMERA_OUTPUT)
    controls = dict(written[-3:])
    assert controls == {0x40028004 + 8 * CHOPPER: 7, 0x40028004 + 8 * CAMERA: 7 | 1 << 12, 0x40028004 + 8 * NOMINAL: 7}


def test_unused_names_of_pins_are_not_needed(monkeypatch):
    """Oracle: an RP2040 has no machine for two of the pins; the firmware must not ask for their numbers."""
    pytest.importorskip("rp2040py")
    EmulatedPico().install(monkeypatch)
    (chip_file,) = load_firmware(monkeypatch, "chip")
    chip = chip_file.Chip({name: pin for name, pin in PINS.items() if name not in ("camera_input", "spare")})
    assert chip.channels == 0x3B
