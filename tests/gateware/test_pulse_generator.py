"""Trains of edges and pulses in Amaranth's simulator."""

import pytest

pytest.importorskip("amaranth")

from amaranth.sim import Simulator

from irtiming.gateware.pulse_generator import EdgeTrain, Pulse

STARTED = 3


def _simulate(circuit, bench) -> None:
    simulator = Simulator(circuit)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()


def _edges(*, delay: int, period: int, count: int, stopped: int | None = None) -> tuple[list[int], list[int], int]:
    """Cycles of edges, of those that say that they are the last, and the last cycle in which the train runs."""
    train = EdgeTrain()
    edges, last, runs = [], [], []

    async def bench(ctx):
        ctx.set(train.delay, delay)
        ctx.set(train.period, period)
        ctx.set(train.count, count)
        for cycle in range(STARTED + delay + period * count + 10):
            ctx.set(train.start, cycle == STARTED)
            ctx.set(train.stop, cycle == stopped)
            edges.extend([cycle] * ctx.get(train.edge))
            last.extend([cycle] * ctx.get(train.is_last))
            runs.extend([cycle] * ctx.get(train.is_running))
            await ctx.tick()

    _simulate(train, bench)
    return edges, last, max(runs)


def _levels(*, edges: dict[int, int], idles_high: int = 0, cycles: int = 60) -> tuple[list[int], list[int]]:
    """Pin and ``is_high`` in each cycle; ``edges`` gives the width of the pulse that each one begins."""
    pulse = Pulse()
    pins, highs = [], []

    async def bench(ctx):
        ctx.set(pulse.idles_high, idles_high)
        for cycle in range(cycles):
            ctx.set(pulse.edge, cycle in edges)
            ctx.set(pulse.width, edges.get(cycle, 7))
            pins.append(ctx.get(pulse.pin))
            highs.append(ctx.get(pulse.is_high))
            await ctx.tick()

    _simulate(pulse, bench)
    return pins, highs


@pytest.mark.parametrize("delay", [0, 1, 2, 9, 10, 11, 37])
@pytest.mark.parametrize(("period", "count"), [(2, 5), (3, 4), (10, 1), (10, 2), (10, 4)])
def test_edges_of_a_train(delay, period, count):
    """Oracle: s + 1 + D + k C in closed form, for delays below, at and beyond the period."""
    edges, last, runs_until = _edges(delay=delay, period=period, count=count)
    assert edges == [STARTED + 1 + delay + k * period for k in range(count)]
    assert last == edges[-1:]
    assert runs_until == edges[-1]


@pytest.mark.parametrize("stopped", range(STARTED + 1, STARTED + 30))
def test_no_edge_comes_after_the_cycle_of_stop(stopped):
    """Oracle: the closed form up to and with the cycle of stop."""
    edges, last, runs_until = _edges(delay=4, period=5, count=4, stopped=stopped)
    wanted = [STARTED + 1 + 4 + k * 5 for k in range(4)]
    assert edges == [edge for edge in wanted if edge <= stopped]
    assert last == [edge for edge in wanted[-1:] if edge <= stopped]
    assert runs_until == min(stopped, wanted[-1])


def test_an_endless_train_begins_at_reset_and_changes_its_period_at_an_edge():
    """Oracle: by hand: 0, 5, 10; the period 3 that comes in cycle 11 holds from edge 15 on."""
    train = EdgeTrain(is_endless=True)
    edges = []

    async def bench(ctx):
        for cycle in range(28):
            ctx.set(train.period, 5 if cycle < 11 else 3 if cycle < 22 else 2)
            edges.extend([cycle] * ctx.get(train.edge))
            await ctx.tick()

    _simulate(train, bench)
    assert edges == [0, 5, 10, 15, 18, 21, 24, 26]


@pytest.mark.parametrize("idles_high", [0, 1])
@pytest.mark.parametrize("width", [1, 2, 3, 9])
def test_a_pulse_is_as_long_as_it_should_be(width, idles_high):
    """Oracle: cycles n + 1 .. n + width by hand; a width of one less than the period leaves one cycle between."""
    begins = (4, 14, 24)
    pins, highs = _levels(edges=dict.fromkeys(begins, width), idles_high=idles_high)
    wanted = [any(n < cycle <= n + width for n in begins) for cycle in range(60)]
    assert highs == wanted
    assert pins[1:] == [level ^ idles_high for level in wanted][1:]  # before the first edge of the clock a pin is low


def test_each_pulse_has_the_width_that_held_at_its_edge():
    """Oracle: by hand."""
    _, highs = _levels(edges={2: 3, 10: 1, 20: 9})
    assert [cycle for cycle, is_high in enumerate(highs) if is_high] == [3, 4, 5, 11, *range(21, 30)]
