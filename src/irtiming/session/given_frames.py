"""Frames of any file with the events that a result counts from: by the file itself, by stamps beside it, or by a period alone.

Frames that were lost are known by the numbers of those that are there. Stamps in another file are those of the same numbers, and
a period goes from number to number; where one source of times contradicts another, none is chosen in silence.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

import numpy as np

from irtiming.apply import conditions
from irtiming.apply.camera_timing import CameraTiming
from irtiming.apply.stamps import EventTimes, Generator
from irtiming.archive.frames.opening import open_frames
from irtiming.archive.frames.source import FrameFacts, FrameSource
from irtiming.errors import EstimationError, about
from irtiming.records.arrays import Array, Ticks
from irtiming.records.recording import FrameStack
from irtiming.session import frame_stamps
from irtiming.session.frame_stamps import Stamped, StampsWanted
from irtiming.units import first_of, readable_time

_GAP = 1.5  # intervals: by how much farther apart stamps must be where a frame is missing
_NAMED = 4


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class GivenFrames:
    """Frames with their events.

    ``kept`` are indices of the frames that have one, ``numbers`` what the source numbers them by, or the indices; shapes (n,).
    """

    stack: FrameStack | FrameSource
    events: EventTimes
    kept: Ticks
    numbers: Ticks
    unit: str = "DN"


def read(
    source: Path, camera: CameraTiming, *, stamps: Path | None = None, period_s: float | None = None,
    generator: Generator | None = None,
) -> GivenFrames:  # fmt: skip
    """Frames of a recording or of any other file, each with its event.

    Parameters
    ----------
    source
        The frames.
    camera
        Of the result, which must hold for them.
    stamps, period_s
        What a person says of the times of frames that a file does not tell: a CSV of stamps, or the time between frames.
    generator
        What is known of the trigger generator that stamped recordings; None: nothing.

    Raises
    ------
    IrTimingError
        If a file cannot be read, the frames tell no times, two sources of times contradict each other, or the result does not
        hold for the frames.
    """
    if stamps is not None and period_s is not None:
        raise EstimationError("stamps and a period are given, from which times of frames follow; give one of them")
    if stamps is None and period_s is None:
        return _by_itself(source, camera, generator=generator)
    stack = open_frames(source)
    facts, numbers = stack.facts, np.arange(stack.shape[0])
    kept, remarks = numbers, conditions.require(camera.conditions, conditions.of_facts(facts), where=str(source))
    if stamps is not None:
        with about(stamps):
            stamped = frame_stamps.read(StampsWanted(source=stamps), camera, generator=generator)
            events, numbers = _of_numbers(stamped, facts), stamped.numbers
    else:
        with about(source):
            events = _every(period_s or 0.0, facts)
    events = replace(events, remarks=(*events.remarks, *remarks))
    numbers = numbers if facts.frame_id is None else facts.frame_id
    return GivenFrames(stack=stack, events=events, kept=kept, numbers=numbers, unit=facts.unit)


def _by_itself(source: Path, camera: CameraTiming, *, generator: Generator | None) -> GivenFrames:
    """Frames that tell their times."""
    with about(source):
        stamped = frame_stamps.read(StampsWanted(source=source), camera, generator=generator)
    events, kept, numbers = stamped.events, stamped.frames, stamped.numbers
    if stamped.recording is not None:
        return GivenFrames(stack=stamped.recording.frames, events=events, kept=kept, numbers=numbers)
    stack = open_frames(source)
    return GivenFrames(stack=stack, events=events, kept=kept, numbers=numbers, unit=stack.facts.unit)


def _of_numbers(stamped: Stamped, facts: FrameFacts) -> EventTimes:
    """Events of the frames: those of their numbers where both are numbered, else one after the other."""
    own, events = facts.frame_id, stamped.events
    if own is not None and stamped.is_numbered:
        order = np.argsort(stamped.numbers, kind="stable")
        at = order[np.minimum(np.searchsorted(stamped.numbers, own, sorter=order), order.size - 1)]
        if not np.all(there := stamped.numbers[at] == own):
            missing = [str(number) for number in own[~there]]
            raise EstimationError(
                f"has no stamp of {len(missing)} of {own.size} frames: of number {first_of(missing, most=_NAMED)}; both must "
                f"number frames alike: they are {own[0]} to {own[-1]} in the frames "
                f"and {stamped.numbers[0]} to {stamped.numbers[-1]} here"
            )
        return replace(events, time_s=events.time_s[at])
    if events.time_s.size != facts.frames:
        raise EstimationError(
            f"has {events.time_s.size} stamps for {facts.frames} frames; give one for each, or number both: a column 'frame' "
            "here, and frames whose file tells their numbers"
        )
    if own is not None:
        _require_gaps(own, events.time_s)
    return events


def _require_gaps(own: Ticks, time_s: Array) -> None:
    """Refuse stamps that leave no time for frames that are missing by the frames' own numbers."""
    steps, intervals_s = np.diff(own), np.diff(time_s)
    if not np.any(steps == 1) or not np.any(steps > 1):
        return
    usual_s = float(np.median(intervals_s[steps == 1]))
    short = (steps > 1) & (intervals_s < _GAP * usual_s)
    if np.any(short):
        raise EstimationError(
            f"leaves no time for frames that are missing by their own numbers, the first after number {own[:-1][short][0]}: the "
            f"stamps there are {readable_time(float(intervals_s[short][0]))} apart, as elsewhere; number the stamps in a column "
            "'frame'"
        )


def _every(period_s: float, facts: FrameFacts) -> EventTimes:
    """Events that follow each other in a period, from number to number; refused where the file itself tells its times."""
    own_s = facts.times_s if facts.trigger_times_s is None else facts.trigger_times_s
    if own_s is not None and own_s.size > 1 and np.all(np.diff(own_s) > 0):
        raise EstimationError(
            f"tells when its frames were, every {readable_time(float(np.median(np.diff(own_s))))}, and a period of "
            f"{readable_time(period_s)} is given as well; leave the period out, or give the times of all frames as stamps"
        )
    numbers = np.arange(facts.frames) if facts.frame_id is None else facts.frame_id - facts.frame_id[0]
    if not np.all(np.diff(numbers) > 0):
        at = int(np.argmax(np.diff(numbers) <= 0))
        raise EstimationError(
            f"numbers frame {at + 1} no higher than the one before, so that a period does not tell their times; give the times "
            "of all frames as stamps"
        )
    return EventTimes(time_s=period_s * numbers.astype(np.float64), scale="s since the event of the first frame")
