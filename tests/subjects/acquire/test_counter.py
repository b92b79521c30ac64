"""When a tick of the trigger generator was, at the earliest."""

import asyncio

import pytest

from irtiming.acquire import counter as counter_module
from irtiming.acquire.counter import Counter

CLOCK_HZ = 1000


class _Device:
    """A counter on the clock of this test that stands still from 2 s to 3 s, as that of a simulated device may."""

    clock_frequency_hz = CLOCK_HZ

    def __init__(self):
        self.now_s = 0.0

    async def counter_ticks(self):
        return round(CLOCK_HZ * min(self.now_s, max(2.0, self.now_s - 1.0)))


def _read_at(monkeypatch, times_s):
    """A counter that was read at these times."""
    device = _Device()
    monkeypatch.setattr(counter_module, "monotonic", lambda: device.now_s)
    counter = Counter(device)

    async def read():
        for time_s in times_s:
            device.now_s = time_s
            await counter.now()

    asyncio.run(read())
    return counter


@pytest.mark.parametrize("every_s", [0.1, 0.7, 3.1])
def test_a_device_that_is_held_up_is_never_thought_to_be_later_than_it_was(monkeypatch, every_s):
    """Oracle: the device's own time at each tick; before it was held up, to the tick."""
    counter = _read_at(monkeypatch, [every_s * k for k in range(round(6 / every_s) + 1)])
    for ticks in range(0, 5000, 7):
        truly_s = ticks / CLOCK_HZ + (ticks > 2000)
        assert counter.earliest_s(ticks) <= truly_s + 1e-9
        if ticks < 2000:
            assert counter.earliest_s(ticks) == pytest.approx(truly_s)


def test_readings_after_it_was_held_up_tell_of_it(monkeypatch):
    """Oracle: by hand, tick 4000 is at 5 s; the reading at 4.9 s says so."""
    counter = _read_at(monkeypatch, [0.7 * k for k in range(8)])
    assert counter.earliest_s(4000) == pytest.approx(5.0)


def test_the_pace_is_that_of_the_whole(monkeypatch):
    """Oracle: 5 s of the device in 6 s."""
    assert _read_at(monkeypatch, [0, 2, 6]).pace() == pytest.approx(5 / 6)
