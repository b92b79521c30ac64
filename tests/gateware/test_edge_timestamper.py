"""From pins to timed events, in Amaranth's simulator."""

import pytest

pytest.importorskip("amaranth")

from amaranth.sim import Simulator

from irtiming.gateware.edge_timestamper import Counter, EdgeDetector, EdgeTimestamper
from irtiming.gateware.register_map import INPUT_LATENCY_CYCLES, Channel, Polarity

ALL = int(sum(Channel))
PINS = {
    Channel.CAMERA_INPUT: "camera_in",
    Channel.CONTROL_SLOT: "control_in",
    Channel.APPLICATION_SLOT: "application_in",
    Channel.SPARE: "spare_in",
}


def _simulate(circuit, bench) -> None:
    simulator = Simulator(circuit)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()


def _edges(toggles: list[int], filter_cycles: int, cycles: int) -> tuple[list[int], list[int]]:
    """Cycles of ``rising`` and ``falling`` of a pin that changes during each cycle of ``toggles``."""
    detector = EdgeDetector()
    rising, falling = [], []

    async def bench(ctx):
        level = 0
        ctx.set(detector.filter, filter_cycles)
        for cycle in range(cycles):
            level ^= cycle in toggles
            ctx.set(detector.pin, level)
            rising.extend([cycle] * ctx.get(detector.rising))
            falling.extend([cycle] * ctx.get(detector.falling))
            await ctx.tick()

    _simulate(detector, bench)
    return rising, falling


@pytest.mark.parametrize("filter_cycles", [0, 1, 2, 7, 255])
def test_latency_of_an_input(filter_cycles):
    """Oracle: n + 1 + 2 + FILTER, by the description of the registers."""
    rising, falling = _edges([5, 300], filter_cycles, 600)
    assert rising == [5 + 1 + INPUT_LATENCY_CYCLES + filter_cycles]
    assert falling == [300 + 1 + INPUT_LATENCY_CYCLES + filter_cycles]


@pytest.mark.parametrize("filter_cycles", [0, 1, 4])
@pytest.mark.parametrize("length", [1, 2, 3, 4, 5, 6])
@pytest.mark.parametrize("is_dip", [False, True])
def test_a_glitch_that_does_not_outlast_the_filter_leaves_no_trace(filter_cycles, length, is_dip):
    """Oracle: a level must last 1 + FILTER cycles; an edge after the glitch comes with its usual latency."""
    lead = [2] if is_dip else []
    rising, falling = _edges([*lead, 20, 20 + length, 40], filter_cycles, 60)
    late = 3 + filter_cycles
    passes = length > filter_cycles
    glitch, back = ([20 + late] if passes else []), ([20 + length + late] if passes else [])
    if is_dip:
        assert (rising, falling) == ([2 + late, *back], [*glitch, 40 + late])
    else:
        assert (rising, falling) == ([*glitch, 40 + late], back)


def test_a_train_of_glitches_is_no_edge_until_the_level_rests():
    """Oracle: by hand: levels of 3 cycles under a filter of 3, then one that stays."""
    rising, falling = _edges([10, 13, 16, 19, 22, 25, 28], 3, 50)
    assert (rising, falling) == ([28 + 1 + INPUT_LATENCY_CYCLES + 3], [])


def test_the_counter_carries_and_wraps():
    """Oracle: the number of the cycle modulo 64, with halves of 3 bits."""
    counter = Counter(bits=6)
    seen = []

    async def bench(ctx):
        for _ in range(150):
            seen.append(ctx.get(counter.value))
            await ctx.tick()

    _simulate(counter, bench)
    assert seen == [cycle % 64 for cycle in range(150)]


def _recorded(changes: dict[int, dict[str, int]], *, cycles: int = 60, **settings: int) -> list[tuple[int, int]]:
    """Times and channels of all events; ``changes`` gives what each port is set to during a cycle."""
    timestamper = EdgeTimestamper()
    events = []

    async def bench(ctx):
        for name, value in ({"is_recording": 1, "channels": ALL} | settings).items():
            ctx.set(getattr(timestamper, name), value)
        for cycle in range(cycles):
            assert ctx.get(timestamper.counter) == cycle
            for name, value in changes.get(cycle, {}).items():
                ctx.set(getattr(timestamper, name), value)
            if ctx.get(timestamper.is_event):
                events.append((ctx.get(timestamper.time), ctx.get(timestamper.happened)))
            await ctx.tick()

    _simulate(timestamper, bench)
    return events


@pytest.mark.parametrize("is_inverted", [False, True])
@pytest.mark.parametrize("channel", PINS)
def test_each_pin_has_its_channel_and_its_polarity(channel, is_inverted):
    """Oracle: by hand; the application slot alone has a channel for its other edge."""
    polarity = int(Polarity[channel.name]) if is_inverted else 0x7F & ~int(Polarity[channel.name])
    changes = {10: {PINS[channel]: 1}, 20: {PINS[channel]: 0}}
    other = Channel.APPLICATION_OTHER_EDGE if channel == Channel.APPLICATION_SLOT else Channel(0)
    first, second = (other, channel) if is_inverted else (channel, other)
    wanted = [(time, int(mask)) for time, mask in ((13, first), (23, second)) if mask]
    assert _recorded(changes, polarity=polarity) == wanted


def test_events_of_one_cycle_are_one_record():
    """Oracle: by hand; own edges carry the cycle itself, those of pins come 3 cycles after the change."""
    changes = {
        10: dict.fromkeys(PINS.values(), 1),
        13: {"camera_trigger": 1, "camera_trigger_delayed": 1},
        14: {"camera_trigger": 0},
        15: {"camera_trigger_delayed": 0},
    }
    assert _recorded(changes) == [(13, ALL & ~Channel.APPLICATION_OTHER_EDGE), (14, Channel.CAMERA_TRIGGER_DELAYED)]


@pytest.mark.parametrize("channel", list(Channel))
def test_a_channel_that_is_masked_is_not_recorded(channel):
    """Oracle: by hand, each channel alone."""
    changes = {
        10: dict.fromkeys(PINS.values(), 1),
        13: {"camera_trigger": 1, "camera_trigger_delayed": 1},
        14: {"camera_trigger": 0, "camera_trigger_delayed": 0},
        20: {"application_in": 0},
    }
    time = 23 if channel == Channel.APPLICATION_OTHER_EDGE else 13
    assert _recorded(changes, channels=int(channel)) == [(time, channel)]


@pytest.mark.parametrize(
    ("first", "last", "is_kept"), [(13, 13, True), (0, 12, False), (14, 59, False), (13, 59, True)]
)
def test_only_cycles_in_which_is_recording_is_high_count(first, last, is_kept):
    """Oracle: the event of cycle 13, by the window of cycles first .. last."""
    changes = {10: {"control_in": 1}, last + 1: {"is_recording": 0}}
    changes[first] = changes.get(first, {}) | {"is_recording": 1}
    assert _recorded(changes, is_recording=0) == ([(13, Channel.CONTROL_SLOT)] if is_kept else [])
