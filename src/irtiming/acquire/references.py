"""Frames of the bare blackbody at two temperatures, wheel and mask out of the way, from which non-uniformity is corrected."""

import asyncio
from contextlib import suppress
from dataclasses import replace

import numpy as np

from irtiming.acquire.attendant import Attendant
from irtiming.acquire.rig import Rig
from irtiming.acquire.temperature import celsius, settled
from irtiming.archive.frame_stack import ArrayFrames
from irtiming.archive.reader import nonuniformity_of
from irtiming.errors import InstrumentError
from irtiming.records.arrays import Pixels
from irtiming.records.recording import NonuniformityReference
from irtiming.records.series_plan import BlackbodyWishes, ReferenceWishes
from irtiming.records.trigger_plan import PlannedRun

_PATIENCE_S = 3.0
_CLEARLY = 3.0
"""Least difference of the two temperatures' frames, in standard deviations of a pixel."""


async def record_references(
    rig: Rig,
    wishes: ReferenceWishes,
    *,
    run: PlannedRun,
    attendant: Attendant,
    runs_free: bool = False,
) -> NonuniformityReference | None:
    """Record the bare blackbody, colder and warmer.

    Parameters
    ----------
    rig
        With a blackbody, camera set.
    wishes
        Temperatures and number of frames.
    run
        Whose frame rate is taken; the chopper's reference goes on as for that run.
    attendant
        Takes wheel and mask away before and brings them back after, learns what is waited for, and may leave.
    runs_free
        Whether the camera makes its frames without triggers.

    Returns
    -------
    Reference with its raw frames, None if it was ended.

    Raises
    ------
    InstrumentError
        If a device fails, frames are missing, or the two do not differ.
    """
    await attendant.move_wheel("remove")
    try:
        found = await _two_stacks(rig, wishes, run=run, attendant=attendant, runs_free=runs_free)
    except InstrumentError:
        attendant.says("wheel and mask are still out of the way; bring them back before the next run")
        raise
    await attendant.move_wheel("insert")
    return found


async def _two_stacks(
    rig: Rig, wishes: ReferenceWishes, *, run: PlannedRun, attendant: Attendant, runs_free: bool
) -> NonuniformityReference | None:
    """Frames at both temperatures, None if a person wants to leave."""
    stacks: list[Pixels] = []
    temperatures: list[float] = []
    for target_k in (wishes.low_k, wishes.high_k):
        if target_k is None:
            raise InstrumentError("[references] names no temperatures; write low and high")
        state = await settled(
            rig,
            target_k,
            wishes=BlackbodyWishes(temperatures_k=(target_k,)),
            attendant=attendant,
        )
        if state is None:
            return None
        attendant.says(f"recording {wishes.frames} frames of the bare blackbody at {celsius(state.temperature_k)}")
        stacks.append(await _bare_frames(rig, run, n_frames=wishes.frames, runs_free=runs_free))
        temperatures.append(state.temperature_k)
    low, high = map(ArrayFrames, stacks)
    found = nonuniformity_of(low, high, low_k=temperatures[0], high_k=temperatures[1])
    step = float(np.median(found.high_dn - found.low_dn))
    noise = float(np.hypot(np.median(found.low_noise_dn), np.median(found.high_noise_dn)))
    if step < -_CLEARLY * noise:
        raise InstrumentError(
            f"the bare blackbody at {celsius(temperatures[1])} is {-step:.4g} DN darker than at {celsius(temperatures[0])}, at a "
            f"noise of {noise:.2g} DN: its contrast is turned over; set the camera to white hot, or to raw values"
        )
    if not step > _CLEARLY * noise:
        raise InstrumentError(
            f"the bare blackbody at {celsius(temperatures[1])} is {step:.4g} DN brighter than at "
            f"{celsius(temperatures[0])}, at a noise of {noise:.2g} DN; take wheel and mask out of the way, or "
            "choose temperatures further apart"
        )
    return found


def drift(before: NonuniformityReference, after: NonuniformityReference) -> tuple[float, float]:
    """How far the camera has drifted from one reference to the next, as shares of the contrast between their temperatures.

    Parameters
    ----------
    before, after
        Of one camera at the same two temperatures.

    Returns
    -------
    Mean change of the pixels, which moves all alike and does no harm; and the root mean square of what is left, which
    correction by the first reference leaves in the frames. The larger of the two temperatures' each.
    """
    contrast = float(np.median(before.high_dn - before.low_dn))
    changes = [after.low_dn - before.low_dn, after.high_dn - before.high_dn]
    means = [float(np.median(change)) / contrast for change in changes]
    spreads = [float(np.std(change)) / contrast for change in changes]
    return max(means, key=abs), max(spreads)


async def _bare_frames(rig: Rig, run: PlannedRun, *, n_frames: int, runs_free: bool) -> Pixels:
    """So many whole frames at the frame rate of a run, triggered or not, shape (frame, row, column)."""
    generator, camera = rig.generator, rig.camera
    repeats = -(-n_frames // run.scheme.samples_per_turn) + 1  # a few more, for frames that come damaged
    await generator.load(
        replace(run, trigger_delay_ticks=0, repeats=repeats), clock_frequency_hz=generator.clock_frequency_hz
    )
    frame_hz = generator.clock_frequency_hz / run.scheme.camera_period_ticks
    await (camera.arm(free_hz=frame_hz) if runs_free else camera.arm())
    stack: list[Pixels] = []
    frames = camera.frames()
    periods_s = 20 * run.scheme.camera_period_ticks / generator.clock_frequency_hz
    patience_s = max(_PATIENCE_S, rig.host_s(_PATIENCE_S + periods_s))  # a fast simulated rig may be on a slow computer
    try:
        await generator.arm()
        if not runs_free:
            await generator.start()
        while len(stack) < n_frames:
            frame = await asyncio.wait_for(anext(frames), patience_s)
            if frame.is_whole:
                stack.append(frame.pixels.copy())
    except (TimeoutError, StopAsyncIteration) as error:
        raise InstrumentError(
            f"{camera.name} sent {len(stack)} of {n_frames} reference frames; check its trigger line and TriggerSource"
        ) from error
    finally:
        with suppress(InstrumentError):
            await generator.stop()
        await camera.disarm()
    return np.stack(stack)
