"""Does the circuit of the trigger generator do what its model says? Many scenarios, a measurement of the paper, many events.

The circuit is its Verilog, compiled. Records, their first cycle on the line, losses and output pins must be equal to the cycle;
the first difference ends the program.

    .venv/bin/python benchmarks/gateware_scenarios.py --scenarios 10000
    .venv/bin/python benchmarks/gateware_scenarios.py --full-run
    .venv/bin/python benchmarks/gateware_scenarios.py --events 1000000
"""

import argparse
import sys
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "gateware"))

from scenarios import (
    FIRST_CYCLE,
    NAMES,
    Played,
    Scenario,
    assert_equal,
    coincident,
    command_cycles,
    done_cycle,
    expected,
    play,
    random_scenario,
)

from irtiming.gateware.compiled import CompiledCircuit
from irtiming.gateware.event_model import PinChanges, Run, Settings, camera_pin, recorded_events
from irtiming.gateware.register_map import Channel

ALL = int(sum(Channel))


def many_scenarios(count: int) -> None:
    """Random short measurements with a queue of 8 records and 4 cycles a bit, each on a circuit after its reset."""
    rng = np.random.default_rng(2023)
    written = lost = together = cycles = longer_delays = 0
    begin = time.perf_counter(), time.process_time()
    for _ in range(count):
        with CompiledCircuit(clock_frequency_hz=4_000_000, queue_depth=8) as circuit:
            scenario = random_scenario(rng, bit_cycles=4, queue_depth=8)
            sent = assert_equal(scenario, play(scenario, circuit))
            cycles += circuit.cycle
        written, lost, together = written + sent.written, lost + sent.lost, together + coincident(sent)
        longer_delays += scenario.settings.camera_delay > scenario.settings.camera_period
    print(f"{count} scenarios equal: {written} records, {lost} lost and told, {together} of more than one channel")
    print(f"  delay beyond the period in {longer_delays} of them; {cycles} cycles; {_duration(begin)}")


def full_run() -> None:
    """The scheme of the paper at 48 MHz: 1000 triggers in 33 s, irregular slots, four edges, a camera that answers."""
    turn, period, n = 16_000_000, 1_584_000, 1000
    settings = Settings(
        chopper_width=80_000, chopper_period=160_000, camera_width=48_000, camera_period=period, camera_count=n,
        camera_delay=2_400_000, channels=ALL, filter=48, bit_cycles=48,
    )  # fmt: skip
    armed = FIRST_CYCLE + command_cycles(48) * len(NAMES)
    started = armed + 2 * command_cycles(48)
    run = Run(first_trigger_cycle=done_cycle(started, 48) + 1)
    end = (run.first_trigger_cycle or 0) + (n - 1) * period + settings.camera_delay + settings.camera_width
    stopped = end + 1_000_000
    rng = np.random.default_rng(3)
    grid = turn // n  # on it a slot without error meets a trigger once in the run
    turns = (
        turn * np.arange(stopped // turn + 1)[:, None] + ((run.first_trigger_cycle or 0) - 3 - settings.filter) % grid
    )
    slots = turn // 100 * np.arange(100) + 400 * rng.integers(-3, 4, 100)  # up to 25 us at 3 Hz
    edges = np.rint(turn * (np.array([0, 90.21, 180.07, 269.84]) / 360)).astype(np.int64)
    exposures = camera_pin(settings, run)
    inputs = {
        Channel.CONTROL_SLOT: _toggles((turns + np.sort(np.concatenate([slots, slots + turn // 200]))).ravel()),
        Channel.APPLICATION_SLOT: _toggles((turns + edges).ravel()),
        Channel.CAMERA_INPUT: replace(exposures, cycle=exposures.cycle + 27_271),
    }
    inputs = {pin: _before(changes, stopped) for pin, changes in inputs.items()}
    reads = tuple(range(started + 48_000_000, stopped - 100_000, 48_000_000))
    scenario = Scenario(settings=settings, armed=armed, started=started, stopped=stopped, reads=reads, inputs=inputs)
    begin = time.perf_counter(), time.process_time()
    with CompiledCircuit() as circuit:
        played = play(scenario, circuit)
        sent = assert_equal(scenario, played)
        cycles = circuit.cycle
    triggers = sum(bool(record.channels & Channel.CAMERA_TRIGGER_DELAYED) for record in played.records)
    print(
        f"full run equal: {cycles / 48e6:.3f} s of the device, {cycles} cycles, {sent.written} records, {sent.lost} lost"
    )
    print(f"  {triggers} delayed triggers, {coincident(sent)} records of more than one channel; {_duration(begin)}")


def many_events(count: int) -> None:
    """One long measurement whose rate goes up and down around what the line carries."""
    rng = np.random.default_rng(7)
    bit = 4
    settings = Settings(
        chopper_width=100, chopper_period=700, camera_width=300, camera_period=4001, camera_count=1,
        camera_delay=123_456, channels=ALL, filter=2, bit_cycles=bit,
    )  # fmt: skip
    armed = FIRST_CYCLE + command_cycles(bit) * len(NAMES)
    started = armed + 2 * command_cycles(bit)
    per_block, per_pin = 500, count // 5 * 2  # three pins give an event with every second change, one with each
    blocks = per_pin // per_block + 1
    inputs = {}
    for pin in (Channel.CAMERA_INPUT, Channel.CONTROL_SLOT, Channel.APPLICATION_SLOT, Channel.SPARE):
        mean = np.repeat(np.exp(rng.uniform(np.log(120), np.log(5000), blocks)), per_block)[:per_pin]
        inputs[pin] = _toggles(started + 500 + np.cumsum(np.ceil(rng.exponential(mean)).astype(np.int64)))
    stopped = max(int(pin.cycle[-1]) for pin in inputs.values()) + 10_000
    settings = replace(settings, camera_count=stopped // settings.camera_period)  # more than there is time for
    scenario = Scenario(settings=settings, armed=armed, started=started, stopped=stopped, reads=(), inputs=inputs)
    begin = time.perf_counter(), time.process_time()
    with CompiledCircuit(clock_frequency_hz=bit * 1_000_000) as circuit:
        played = play(scenario, circuit)
        cycles = circuit.cycle
    flags = _account(scenario, played)
    sent = assert_equal(scenario, played)
    events = sum(record.channels.bit_count() for record in played.records)
    print(
        f"{sent.written + sent.lost} cycles with events: {sent.written} records with {events} events, {sent.lost} lost"
    )
    print(
        f"  each of {flags} gaps told by the next record, none out of order, no time wrong; {cycles} cycles; {_duration(begin)}"
    )


def _account(scenario: Scenario, played: Played) -> int:
    """Every event is in a record, or the next record says that some were lost; without the model of the queue."""
    run, _ = expected(scenario)
    events = recorded_events(scenario.settings, scenario.inputs, run=run)
    place = {time: i for i, time in enumerate(events.time_ticks.tolist())}
    got = [place[record.time_ticks] for record in played.records]  # a wrong time is a KeyError
    assert all(events.channels[i] == record.channels for i, record in zip(got, played.records, strict=True))
    assert all(record.number == i % 2**16 for i, record in enumerate(played.records))
    flags = 0
    for (before, after), record in zip(pairwise([-1, *got]), played.records, strict=True):
        assert after > before
        assert record.is_after_loss == (after > before + 1)
        flags += record.is_after_loss
    return flags


def _toggles(cycle: np.ndarray) -> PinChanges:
    return PinChanges(cycle=cycle, level=(np.arange(cycle.size) + 1) % 2)


def _before(pin: PinChanges, until: int) -> PinChanges:
    inside = pin.cycle < until
    return PinChanges(cycle=pin.cycle[inside], level=pin.level[inside], initial=pin.initial)


def _duration(begin: tuple[float, float]) -> str:
    return f"{time.perf_counter() - begin[0]:.1f} s by the clock, {time.process_time() - begin[1]:.1f} s of processor"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenarios", type=int, default=0)
    parser.add_argument("--full-run", action="store_true")
    parser.add_argument("--events", type=int, default=0)
    choice = parser.parse_args()
    if choice.scenarios:
        many_scenarios(choice.scenarios)
    if choice.full_run:
        full_run()
    if choice.events:
        many_events(choice.events)


if __name__ == "__main__":
    main()
