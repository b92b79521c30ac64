"""The PIO programs of the microcontroller: every path the same length, every pulse and every time exact."""

import re
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest
from emulated_pico import FIRMWARE

ROOT = Path(__file__).parents[2]
JMP, X_DEC, PIN = 0, 2, 6
PROGRAMS = runpy.run_path(str(FIRMWARE / "pio_programs.py"))
EDGES, TRAIN, CHOPPER = PROGRAMS["EDGES"], PROGRAMS["TRAIN"], PROGRAMS["CHOPPER"]
STATUS_INTO_X, ONES_INTO_X = 0xA025, 0xA02B
SAMPLES = {"high": 10, "low": 18}


def _is_jump(word, condition):
    return word >> 13 == JMP and word >> 5 & 7 == condition


def _cycles(word, side_set=0):
    return 1 + (word >> 8 & (31 >> side_set))


def _side(word):
    return word >> 12 & 1


def _successors(program, at):
    """Where a program may go from an instruction, each with the decrements of X on the way."""
    word = program["code"][at]
    following = program["wrap_target"] if at == program["wrap"] else at + 1
    decrements = int(_is_jump(word, X_DEC))
    if word >> 13 != JMP:
        return {(following, 0)}
    places = {word & 31} if _is_jump(word, 0) else {word & 31, following}
    return {(place, decrements) for place in places}


def _paths_to_next_sample(program, start):
    """All ways from one look at the pin to the next: cycles, decrements and instructions of each."""
    paths, open_ends = [], [(start, 0, 0, ())]
    while open_ends:
        at, cycles, decrements, trace = open_ends.pop()
        assert len(trace) < 20, "a path that never looks at the pin again"
        if trace and _is_jump(program["code"][at], PIN):
            paths.append((cycles, decrements, (*trace, at)))
            continue
        cycles += _cycles(program["code"][at])
        for place, more in _successors(program, at):
            open_ends.append((place, cycles, decrements + more, (*trace, at)))
    return paths


def _words_of_pins(changes, *, cycles, x=None):
    """Words that the edge timer gives for one pin, by the emulator pioemu: changes as (cycle, level)."""
    pioemu = pytest.importorskip("pioemu")
    level = np.zeros(cycles + 64, dtype=np.int64)
    for cycle, value in changes:
        level[cycle:] = value
    seen = level.tolist()

    def pin(clock: int) -> int:
        return seen[clock]

    start = (
        pioemu.State()
        if x is None
        else pioemu.State(program_counter=SAMPLES["low"], x_register=x, y_register=2**32 - 1)
    )
    words = []
    steps = pioemu.emulate(
        list(EDGES["code"]), stop_when=lambda _, state: state.clock >= cycles, initial_state=start, input_source=pin,
        jmp_pin=0, shift_isr_right=False, wrap_target=EDGES["wrap_target"], wrap_top=EDGES["wrap"],
    )  # fmt: skip
    for _, state in steps:
        while state.receive_fifo:
            words.append(state.receive_fifo.popleft())
    return words


def _random_changes(seed, *, count, shortest):
    lengths = shortest + np.random.default_rng(seed).integers(0, 300, count)
    return [(int(cycle), (i + 1) % 2) for i, cycle in enumerate(np.cumsum(lengths))]


def test_the_opcodes_are_what_the_text_says(monkeypatch, capsys):
    """Oracle: Adafruit's assembler; if this fails, run scripts/assemble-pio as its first lines say."""
    pytest.importorskip("adafruit_pioasm")
    monkeypatch.setattr(sys, "argv", ["assemble-pio", str(FIRMWARE / "programs.pio")])
    runpy.run_path(str(ROOT / "scripts" / "assemble-pio"), run_name="__main__")
    assert capsys.readouterr().out == (FIRMWARE / "pio_programs.py").read_text()


def test_programs_fit_into_their_blocks():
    """Oracle: 32 instructions to a block; the first and third hold the edge timer, the second both pulse programs."""
    assert len(EDGES["code"]) <= 32
    assert len(TRAIN["code"]) + len(CHOPPER["code"]) <= 32


@pytest.mark.parametrize("sample", SAMPLES.values(), ids=SAMPLES)
def test_every_path_of_the_edge_timer_counts_once_in_two_cycles(sample):
    """Oracle: all paths of the program's graph, both ways out of each jump; so zero of the counter costs nothing either."""
    paths = _paths_to_next_sample(EDGES, sample)
    assert {(cycles, decrements) for cycles, decrements, _ in paths} == {(2, 1), (8, 4)}
    for cycles, _, trace in paths:
        assert (trace[-1] != sample) == (cycles == 8), "an edge, and nothing else, leads to the other level"


def test_an_edge_is_pushed_once_with_its_level_and_before_the_counter_goes_on():
    """Oracle: the instructions on the two edge paths, by hand: 31 bits of X, then one bit of Y (ones) or of null."""
    for sample, bit in ((SAMPLES["low"], 0x4041), (SAMPLES["high"], 0x4061)):
        (trace,) = {trace[1:4] for cycles, _, trace in _paths_to_next_sample(EDGES, sample) if cycles == 8}
        assert [EDGES["code"][at] for at in trace] == [0x403F, bit, 0x8000]


@pytest.mark.parametrize(
    ("program", "body"), [(TRAIN, slice(8, 16)), (CHOPPER, slice(4, 11))], ids=["train", "chopper"]
)
def test_a_pulse_costs_what_the_chip_subtracts(program, body):
    """Oracle: width - 2 and gap - 5 (chip.py) in counts of two cycles, for 32-bit settings, from the sum of the instructions."""
    words = program["code"][body]
    for side, counts in ((1, 2), (0, 5)):
        assert sum(_cycles(word, 1) for word in words if _side(word) == side) == 2 * counts
    loops = [(at, word) for at, word in enumerate(program["code"]) if _is_jump(word, X_DEC) and word & 31 == at]
    assert all(_cycles(word, 1) == 2 for _, word in loops)
    assert len(loops) == (3 if program is TRAIN else 2)


def test_taking_new_settings_is_as_long_as_keeping_the_old():
    """Oracle: cycles of the two ways from the chopper's look at its queue to its next pulse."""
    load, keep = CHOPPER["code"][:4], CHOPPER["code"][10]
    assert sum(_cycles(word, 1) for word in load) == _cycles(keep, 1) == 4


def test_times_of_edges_are_at_most_one_count_late_and_never_drift():
    """Oracle: the cycle of each edge; 400 edges, the last as exact as the first, the level alternating."""
    changes = _random_changes(1, count=400, shortest=9)
    words = _words_of_pins(changes, cycles=changes[-1][0] + 40)
    first_sample = 3
    late = [
        (0x7FFFFFFF - (word >> 1)) - (cycle - first_sample) / 2 for word, (cycle, _) in zip(words, changes, strict=True)
    ]
    assert [word & 1 for word in words] == [level for _, level in changes]
    assert set(late) == {0, 0.5}


def test_times_go_on_when_the_counter_passes_zero():
    """Oracle: the cycle of each edge, modulo 2^31; the counter starts 300 counts before zero."""
    changes = _random_changes(2, count=12, shortest=9)
    words = _words_of_pins(changes, cycles=changes[-1][0] + 40, x=300)
    counts = [(300 - -(-cycle // 2)) % 2**31 for cycle, _ in changes]
    assert min(counts) < 300 < max(counts)
    assert [word >> 1 for word in words] == counts


def test_an_edge_too_soon_after_another_is_late_by_four_counts_at_most_and_later_ones_are_right():
    """Oracle: eight cycles of dead time after an edge (the path above), and the cycles of the others."""
    changes = [(100, 1), (103, 0), (200, 1), (300, 0)]
    times = [0x7FFFFFFF - (word >> 1) for word in _words_of_pins(changes, cycles=400)]
    assert times[0] == 49
    assert 50 < times[1] <= 54
    assert times[2:] == [99, 149]


@pytest.mark.parametrize(("width", "period", "count", "delay"), [(8, 16, 5, 0), (20, 101, 3, 37), (100, 108, 4, 250)])
def test_pulses_of_a_train_are_exact(width, period, count, delay):
    """Oracle: t0 + D + k C, from the second emulator, pioemu; its STATUS, which it lacks, replaced by ones (keep going)."""
    pioemu = pytest.importorskip("pioemu")
    from collections import deque

    code = [ONES_INTO_X if word == STATUS_INTO_X else word for word in TRAIN["code"]]
    settings = deque([width - 2, count - 1, delay, period - width - 5])
    start = pioemu.State(transmit_fifo=settings, pin_directions=1)
    levels = [0]
    steps = pioemu.emulate(
        code,
        stop_when=lambda at, _: at == TRAIN["labels"]["done"],
        initial_state=start,
        side_set_count=1,
        side_set_base=0,
    )
    edges = []
    for before, after in steps:
        level = after.pin_values & 1
        if level != levels[-1]:
            edges.append((before.clock, level))
            levels.append(level)
    rises = [cycle for cycle, level in edges if level]
    falls = [cycle for cycle, level in edges if not level]
    first = 7 + 2 * (delay + 1) + 2
    assert rises == [first + 2 * period * k for k in range(count)]
    assert falls == [rise + 2 * width for rise in rises]


def test_the_text_has_one_program_for_each_table():
    """Oracle: the names of the programs in the text."""
    names = re.findall(r"^\.program (\w+)", (FIRMWARE / "programs.pio").read_text(), flags=re.MULTILINE)
    assert names == ["edges", "train", "chopper"]
