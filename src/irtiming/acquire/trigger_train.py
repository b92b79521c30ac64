"""One planned run on a trigger generator: wheel at speed, arm, trigger, collect."""

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.acquire.counter import Counter
from irtiming.errors import InstrumentError
from irtiming.instruments.protocols import TriggerGenerator
from irtiming.records.timestamps import Timestamps
from irtiming.records.trigger_plan import PlannedRun
from irtiming.units import readable_time

_TURNS_AROUND = 2
"""Turns of the wheel that are recorded before the first trigger and after the last."""

SPEED_TOLERANCE = 0.005
"""By how much the wheel may differ from its reference, relative."""

_SETTLING_S = 30.0
"""Time of the device within which the wheel must have come to the speed of its reference."""

Progress = Callable[[int, int], None]
"""Given the camera triggers that were made and all of them."""


async def _nothing() -> None:
    """What is done before the first trigger where nothing is."""


@final
@dataclass(frozen=True, kw_only=True)
class Accompaniment:
    """What goes on beside a train of triggers.

    ``before_start`` is awaited when the generator records and the wheel has made two turns, just before the first trigger.
    ``is_over`` is asked again and again: once it says so, the train is ended early. ``progress`` learns how far it is.
    """

    before_start: Callable[[], Awaitable[None]] = _nothing
    is_over: Callable[[], bool] = lambda: False
    progress: Progress = lambda made, total: None


ALONE = Accompaniment()
"""Nothing goes on beside the train."""


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
    await wheel_at_speed(generator, run, poll_s=poll_s)
    beside = ALONE if progress is None else Accompaniment(progress=progress)
    return await trigger(generator, run, counter=Counter(generator), beside=beside, poll_s=poll_s)


async def wheel_at_speed(
    generator: TriggerGenerator,
    run: PlannedRun,
    *,
    poll_s: float,
    is_over: Callable[[], bool] = lambda: False,
) -> None:
    """Listen to the wheel for two turns, again and again, until it turns at the period of the run that is loaded.

    Parameters
    ----------
    generator, run, poll_s
        As for `measure`; the run is loaded.
    is_over
        Once it says so, nothing is waited for any more.

    Raises
    ------
    InstrumentError
        If it does not within 30 s of the device's time.
    """
    wanted, counter = run.scheme.control_slot_period_ticks, Counter(generator)
    begun = await counter.now()
    while not is_over():
        await generator.arm()
        await _pass(counter, _TURNS_AROUND * run.scheme.turn_period_ticks, generator=generator, poll_s=poll_s)
        heard = await generator.stop()
        slots = heard.control_slot_ticks
        actual = float(np.median(np.diff(slots))) if slots.size > 1 else np.inf
        if abs(actual / wanted - 1) <= SPEED_TOLERANCE and heard.application_slot_ticks.size > 1:
            return
        if await counter.now() - begun > _SETTLING_S * generator.clock_frequency_hz:
            raise InstrumentError(_not_at_speed(heard, wanted))


async def trigger(
    generator: TriggerGenerator,
    run: PlannedRun,
    *,
    counter: Counter,
    beside: Accompaniment = ALONE,
    poll_s: float = 0.2,
) -> Timestamps:
    """The train of triggers of the run that is loaded, with two turns of the wheel before and after it.

    Parameters
    ----------
    generator, run, poll_s
        As for `measure`.
    counter
        Keeps its readings.
    beside
        What goes on meanwhile, and may end the train early.

    Returns
    -------
    All timestamps; as many triggers as were made.

    Raises
    ------
    InstrumentError
        If the device fails, or what ``beside.before_start`` raises; ``generator.captured()`` then has what arrived.
    """
    turns = _TURNS_AROUND * run.scheme.turn_period_ticks
    n_triggers = run.scheme.samples_per_turn * run.repeats
    await generator.arm()
    await _pass(counter, turns, generator=generator, poll_s=poll_s)
    await beside.before_start()
    if not beside.is_over():
        await generator.start()
        begun = await counter.now()
        while not beside.is_over() and not await generator.has_finished():
            past = await counter.now() - begun
            beside.progress(min(past // run.scheme.camera_period_ticks, n_triggers - 1), n_triggers)
            await asyncio.sleep(poll_s)
    if not beside.is_over():
        beside.progress(n_triggers, n_triggers)
        after = turns + run.scheme.camera_period_ticks  # the last frame is read within a period
        await _pass(counter, after, generator=generator, poll_s=poll_s, is_over=beside.is_over)
    return await generator.stop()


@final
@dataclass(frozen=True, kw_only=True)
class FreeAccompaniment:
    """What goes on beside a camera that runs free.

    ``start_camera`` is awaited when the generator records and the wheel has made two turns, ``look`` again and again, before and
    after as well, ``stop_camera`` once ``has_all`` or ``is_over`` says so; ``progress`` then learns how far it is.
    """

    start_camera: Callable[[], Awaitable[None]]
    look: Callable[[], Awaitable[None]]
    stop_camera: Callable[[], Awaitable[None]]
    has_all: Callable[[], bool]
    is_over: Callable[[], bool]
    progress: Callable[[], None]


async def listen(
    generator: TriggerGenerator,
    run: PlannedRun,
    *,
    counter: Counter,
    beside: FreeAccompaniment,
    poll_s: float = 0.2,
) -> Timestamps:
    """Timestamps while a camera runs free: no triggers, and the camera is silent before its start and after its stop.

    Parameters
    ----------
    generator, run, poll_s
        As for `measure`; the run is loaded.
    counter
        Keeps its readings.
    beside
        What goes on meanwhile; starts and stops the camera.

    Returns
    -------
    All timestamps.

    Raises
    ------
    InstrumentError
        If the device fails, or what ``beside`` raises; ``generator.captured()`` then has what arrived.
    """
    turns = _TURNS_AROUND * run.scheme.turn_period_ticks
    await generator.arm()
    await _pass(counter, turns, generator=generator, poll_s=poll_s)
    await beside.look()
    await beside.start_camera()
    while not beside.is_over() and not beside.has_all():
        await asyncio.sleep(poll_s)
        await beside.look()
        beside.progress()
    await beside.stop_camera()
    await beside.look()
    after = turns + run.scheme.camera_period_ticks
    await _pass(counter, after, generator=generator, poll_s=poll_s)
    return await generator.stop()


async def _pass(
    counter: Counter,
    ticks: int,
    *,
    generator: TriggerGenerator,
    poll_s: float,
    is_over: Callable[[], bool] = lambda: False,
) -> None:
    """Wait until the counter has gone on by so many ticks."""
    begun = await counter.now()
    while not is_over() and (past := await counter.now() - begun) < ticks:
        await asyncio.sleep(min((ticks - past) / generator.clock_frequency_hz, poll_s))


def _not_at_speed(heard: Timestamps, wanted: int) -> str:
    clock, slots = heard.clock_frequency_hz, heard.control_slot_ticks
    if slots.size < 2:
        return f"{slots.size} control slots came; check the chopper, the control light gate and its line"
    if heard.application_slot_ticks.size < 2:
        what = f"{heard.application_slot_ticks.size} application slots came while {slots.size} control slots did"
        return f"{what}; check the application light gate and its line"
    actual = readable_time(float(np.median(np.diff(slots))) / clock)
    return (
        f"a control slot passes every {actual}, it must be every {readable_time(wanted / clock)}; check that the chopper takes "
        "its reference from the trigger generator, and has the number of slots that was planned for"
    )
