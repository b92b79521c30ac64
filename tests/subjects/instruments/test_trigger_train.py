"""One planned run: the wheel must turn as planned before the first trigger."""

import asyncio
from dataclasses import replace

import pytest

from irtiming.acquire import trigger_train
from irtiming.acquire.trigger_train import measure
from irtiming.errors import InstrumentError
from irtiming.gateware.model_device import ModelDevice
from irtiming.gateware.register_map import Channel
from irtiming.instruments.generator.register_link import Patience
from irtiming.instruments.generator.trigger_generator import SerialTriggerGenerator

CLOCK_HZ = 48_000_000


def _measured(line, run):
    async def session():
        generator = SerialTriggerGenerator(line, patience=Patience(reply_s=0.2, poll_s=0.0))
        try:
            await generator.identify()
            return await measure(generator, run, clock_frequency_hz=CLOCK_HZ, poll_s=0.0)
        finally:
            await generator.close()

    return asyncio.run(asyncio.wait_for(session(), timeout=20))


@pytest.fixture
def hasty(monkeypatch):
    """Wait for the wheel for 3 s of the device's time instead of 30."""
    monkeypatch.setattr(trigger_train, "_SETTLING_S", 3.0)


class _Without:
    """A wheel some of whose lines see nothing."""

    def __init__(self, wheel, *lines):
        self.wheel, self.lines = wheel, lines

    def turn(self, until_cycle, *, slot_period_cycles):
        changes = self.wheel.turn(until_cycle, slot_period_cycles=slot_period_cycles)
        return {line: pin for line, pin in changes.items() if line not in self.lines}


class _Slow:
    """A wheel that follows its reference only after a while, or at another speed."""

    def __init__(self, wheel, from_cycle=0, of=1):
        self.wheel, self.from_cycle, self.of = wheel, from_cycle, of

    def turn(self, until_cycle, *, slot_period_cycles):
        changes = self.wheel.turn(until_cycle, slot_period_cycles=slot_period_cycles // self.of)
        return changes if until_cycle > self.from_cycle else {}


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        ((Channel.CONTROL_SLOT,), "0 control slots came; check the chopper, the control light gate"),
        ((Channel.APPLICATION_SLOT,), r"0 application slots came while \d+ control slots did; check the application"),
    ],
)  # fmt: skip
def test_a_light_gate_that_sees_nothing_is_told_before_the_run(
    memory_line, steady_wheel, short_run, hasty, lines, says
):
    """Oracle: the words."""
    line = memory_line(ModelDevice(_Without(steady_wheel(), *lines)), step_cycles=2_000_000)
    with pytest.raises(InstrumentError, match=says):
        _measured(line, short_run)


def test_a_wheel_at_another_speed_is_told(memory_line, steady_wheel, short_run, hasty):
    """Oracle: slots every 1 ms / 2 where 1 ms was planned, by hand."""
    wheel = steady_wheel(slot_period=24_000)
    line = memory_line(ModelDevice(_Slow(wheel, of=2)), step_cycles=2_000_000)
    with pytest.raises(InstrumentError, match=r"a control slot passes every (499|500)\.\d+ µs, it must be every 1 ms"):
        _measured(line, short_run)


def test_a_wheel_that_needs_time_is_waited_for(memory_line, steady_wheel, short_run):
    """Oracle: a wheel that stands for 2 s after the reference was set; nothing of that is in the timestamps."""
    line = memory_line(ModelDevice(_Slow(steady_wheel(), from_cycle=96_000_000)), step_cycles=500_000)
    found = _measured(line, short_run)
    assert found.is_whole
    assert found.camera_trigger_ticks.size == 16
    assert found.control_slot_ticks[0] > 96_000_000


def test_repeats_go_on_without_a_gap(memory_line, steady_wheel, short_run):
    """Oracle: 3 N triggers, all C apart."""
    found = _measured(memory_line(ModelDevice(steady_wheel())), replace(short_run, repeats=3))
    assert found.camera_trigger_ticks.size == 48
    assert set((found.camera_trigger_ticks[1:] - found.camera_trigger_ticks[:-1]).tolist()) == {510_000}
