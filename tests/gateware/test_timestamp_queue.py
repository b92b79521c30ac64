"""The queue of records in Amaranth's simulator."""

import random
from collections import deque

import pytest

pytest.importorskip("amaranth")

from amaranth.sim import Simulator

from irtiming.errors import GatewareError
from irtiming.gateware.timestamp_queue import SaturatingCounter, TimestampQueue

DEPTH = 4


def _simulate(circuit, bench) -> None:
    simulator = Simulator(circuit)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()


class _Model:
    """A queue as it is described: a list, and the account of what found no room."""

    def __init__(self):
        self.clear()

    def clear(self):
        self.waiting, self.written, self.lost, self.after_loss = deque(), 0, 0, False

    def step(self, *, write, pop, clear, time):
        """One cycle; the record that left, if one did. Room is judged before anything moves."""
        is_full = len(self.waiting) == DEPTH
        left = self.waiting.popleft() if pop else None
        if write and is_full:
            self.lost, self.after_loss = self.lost + 1, True
        elif write:
            self.waiting.append((time % 128, self.after_loss, self.written % 2**16, time))
            self.written, self.after_loss = self.written + 1, False
        if clear:
            self.clear()
        return left


def _run(steps) -> tuple[int, int]:
    """Hold queue and model against each other in every cycle; numbers of records that left and were lost."""
    queue, model = TimestampQueue(depth=DEPTH), _Model()
    left_count, lost_count = [], []

    async def bench(ctx):
        left = None
        for cycle, (write, pop, clear) in enumerate(steps):
            pop = pop and bool(model.waiting)
            time = 2**47 + 12345 * cycle
            for port, value in ((queue.write, write), (queue.pop, pop), (queue.clear, clear)):
                ctx.set(port, value)
            ctx.set(queue.channels, time % 128)
            ctx.set(queue.time, time)
            assert ctx.get(queue.is_empty) == (not model.waiting)
            assert ctx.get(queue.written) == model.written
            assert ctx.get(queue.lost) == model.lost
            assert ctx.get(queue.is_lossy) == (model.lost > 0)
            if left is not None:
                record = ctx.get(queue.record)
                assert (record.channels, record.is_after_loss, record.number, record.time) == left
            before = model.lost
            popped = model.step(write=write, pop=pop, clear=clear, time=time)
            left_count.extend([1] * (popped is not None))
            lost_count.extend([1] * (model.lost - before if not clear else 0))
            left = popped if popped is not None else left
            await ctx.tick()

    _simulate(queue, bench)
    return len(left_count), len(lost_count)


def test_records_come_out_in_order_and_losses_are_told():
    """Oracle: by hand: 4 of 7 find room, 3 do not; the one after them says so."""
    write, pop, rest = (1, 0, 0), (0, 1, 0), (0, 0, 0)
    assert _run([*[write] * 7, *[pop] * 2, *[write] * 2, *[pop] * 5, rest]) == (6, 3)


def test_a_record_that_comes_as_another_leaves_a_full_queue_is_lost():
    """Oracle: by hand; room is what there was before the cycle."""
    assert _run([*[(1, 0, 0)] * 4, (1, 1, 0), (1, 0, 0), (0, 1, 0), (0, 1, 0), (0, 1, 0), (0, 1, 0), (0, 0, 0)]) == (
        5,
        1,
    )


def test_clear_forgets_records_losses_and_numbers():
    """Oracle: by hand."""
    assert _run([*[(1, 0, 0)] * 6, (0, 0, 1), (0, 0, 0), *[(1, 0, 0)] * 2, (0, 1, 0), (0, 1, 0), (0, 0, 0)]) == (2, 2)


@pytest.mark.parametrize("seed", range(4))
def test_any_order_of_writes_and_pops(seed):
    """Oracle: the list in `_Model`, compared in every cycle of 3000."""
    random_ = random.Random(seed)
    steps = []
    for _ in range(30):
        busy, fast = random_.random(), random_.random()
        steps += [(random_.random() < busy, random_.random() < fast, random_.random() < 0.01) for _ in range(100)]
    left, lost = _run(steps)
    assert left > 300
    assert lost > 100


@pytest.mark.parametrize("depth", [0, 1, 3, 500])
def test_a_depth_that_is_no_power_of_two_is_refused(depth):
    """Oracle: powers of two by hand."""
    with pytest.raises(GatewareError, match=f"a queue of {depth} records"):
        Simulator(TimestampQueue(depth=depth))


def test_a_counter_stays_at_its_largest_value():
    """Oracle: min(events, 7) for a counter of 3 bits, again after it was cleared."""
    counter = SaturatingCounter(bits=3)
    seen = []

    async def bench(ctx):
        ctx.set(counter.event, 1)
        for cycle in range(25):
            ctx.set(counter.clear, cycle == 12)
            seen.append(ctx.get(counter.count))
            await ctx.tick()

    _simulate(counter, bench)
    assert seen == [min(cycle, 7) for cycle in range(13)] + [min(cycle, 7) for cycle in range(12)]
