"""One planned run on a trigger generator: wheel at speed, arm, trigger, collect."""

import asyncio
from collections.abc import Callable

import numpy as np

from irtiming.errors import InstrumentError
from irtiming.gateware.event_model import COUNTER_CYCLES
from irtiming.instruments.protocols import TriggerGenerator
from irtiming.records.timestamps import Timestamps
from irtiming.records.trigger_plan import PlannedRun
from irtiming.units import readable_time

_TURNS_AROUND = 2
"""Turns of the wheel that are recorded before the first trigger and after the last."""

_SPEED_TOLERANCE = 0.005
_SETTLING_S = 30.0
"""Time of the device within which the wheel must have come to the speed of its reference."""

Progress = Callable[[int, int], None]
"""Told the camera triggers that were made and all of them."""


async def measure(
    generator: TriggerGenerator,
    run: PlannedRun,
    *,
    clock_frequency_hz: int,
    progress: Progress | None = None,
    poll_s: float = 0.2,
) -> Timestamps:
    """Timestamps of one run: from two turns before its first trigger to two turns after its last.

    The chopper's reference is set first. Recording begins when the wheel follows it.

    Parameters
    ----------
    generator
        Open and identified.
    run
        Of a plan.
    clock_frequency_hz
        That the plan was made for.
    progress
        Called as triggers are made.
    poll_s
        How often the device is asked how far it is, s.

    Returns
    -------
    All timestamps, those of lost records excepted: ``lost_after_ticks`` tells.

    Raises
    ------
    InstrumentError
        If the device or the wheel fails; ``generator.captured()`` then has what arrived.
    """
    await generator.load(run, clock_frequency_hz=clock_frequency_hz)
    turns = _TURNS_AROUND * run.scheme.turn_period_ticks
    await _wheel_at_speed(generator, run, poll_s=poll_s)
    await generator.arm()
    await _pass(generator, turns, poll_s=poll_s)
    await generator.start()
    n_triggers = run.scheme.samples_per_turn * run.repeats
    begun = await generator.counter_ticks()
    while not await generator.has_finished():
        if progress is not None:
            past = (await generator.counter_ticks() - begun) % COUNTER_CYCLES
            progress(min(past // run.scheme.camera_period_ticks, n_triggers - 1), n_triggers)
        await asyncio.sleep(poll_s)
    if progress is not None:
        progress(n_triggers, n_triggers)
    await _pass(
        generator, turns + run.scheme.camera_period_ticks, poll_s=poll_s
    )  # the last frame is read within a period
    return await generator.stop()


async def _pass(generator: TriggerGenerator, ticks: int, *, poll_s: float) -> None:
    """Wait until the device's counter has gone on by so many ticks."""
    begun = await generator.counter_ticks()
    while (past := (await generator.counter_ticks() - begun) % COUNTER_CYCLES) < ticks:
        await asyncio.sleep(min((ticks - past) / generator.clock_frequency_hz, poll_s))


async def _wheel_at_speed(generator: TriggerGenerator, run: PlannedRun, *, poll_s: float) -> None:
    """Listen to the wheel for two turns, again and again, until it turns at the period of the plan."""
    wanted = run.scheme.control_slot_period_ticks
    begun = await generator.counter_ticks()
    while True:
        await generator.arm()
        await _pass(generator, _TURNS_AROUND * run.scheme.turn_period_ticks, poll_s=poll_s)
        heard = await generator.stop()
        slots = heard.control_slot_ticks
        seen = float(np.median(np.diff(slots))) if slots.size > 1 else np.inf
        if abs(seen / wanted - 1) <= _SPEED_TOLERANCE and heard.application_slot_ticks.size > 1:
            return
        past = (await generator.counter_ticks() - begun) % COUNTER_CYCLES
        if past > _SETTLING_S * generator.clock_frequency_hz:
            raise InstrumentError(_not_at_speed(heard, wanted))


def _not_at_speed(heard: Timestamps, wanted: int) -> str:
    clock, slots = heard.clock_frequency_hz, heard.control_slot_ticks
    if slots.size < 2:
        return f"{slots.size} control slots came; check the chopper, the control light gate and its line"
    if heard.application_slot_ticks.size < 2:
        what = f"{heard.application_slot_ticks.size} application slots came while {slots.size} control slots did"
        return f"{what}; check the application light gate and its line"
    seen = readable_time(float(np.median(np.diff(slots))) / clock)
    return (
        f"a control slot passes every {seen}, it must be every {readable_time(wanted / clock)}; check that the chopper takes its "
        "reference from the trigger generator, and has the number of slots that was planned for"
    )
