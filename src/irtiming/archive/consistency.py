"""Checks that need more than one field; the reader raises the first error, verify shows them all."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from irtiming.archive import layout
from irtiming.archive.finding import error_at, warning_at
from irtiming.archive.layout import Field
from irtiming.records.finding import Finding
from irtiming.units import counted

if TYPE_CHECKING:
    from irtiming.records.arrays import Ticks

Contents: TypeAlias = dict[Field, Any]
"""Value of each field as `fields.read_field` gives it; None where it is absent or unreadable."""


def check(contents: Contents) -> list[Finding]:
    """Everything that the fields say against each other; empty for a sound recording.

    Fields that are None are left out of the checks.
    """
    return [
        *_ending(contents),
        *_streams(contents),
        *_frame_numbers(contents),
        *_events(contents),
        *_reference(contents),
    ]


def check_temperatures(temperatures: dict[Field, float | None]) -> list[Finding]:
    """Complain where the reference called low is not colder than the one called high; temperatures in K."""
    low, high = temperatures.get(layout.REFERENCE_LOW), temperatures.get(layout.REFERENCE_HIGH)
    if low is None or high is None or low < high:
        return []
    return [
        error_at(
            layout.REFERENCE_LOW.path,
            f"is at {low:g} K, high at {high:g} K",
            code="reference-temperatures-swapped",
            cure="low must be the colder one; swap them",
        )
    ]


def _ending(contents: Contents) -> Iterator[Finding]:
    ending = contents.get(layout.ENDING)
    if ending == layout.UNPROVEN:
        yield error_at(
            layout.ENDING.path,
            f"says: {ending}",
            code="recording-not-proven",
            cure="record it again, or, where no trigger and no frame was missed for certain, irtiming recover --trust",
        )
    elif ending is not None and ending.startswith(layout.NOT_TRUSTED):
        yield error_at(
            layout.ENDING.path,
            f"says: {ending}",
            code="recording-not-trusted",
            cure="its frames may belong to other triggers; record it again",
        )
    elif ending is not None and ending != layout.COMPLETE:
        yield warning_at(
            layout.ENDING.path,
            f"says: {ending}",
            code="recording-ended-early",
            cure="the recording is shorter than planned, what is in it is sound",
        )


def _streams(contents: Contents) -> Iterator[Finding]:
    for field in layout.FIELDS:
        ticks: Ticks | None = contents.get(field) if field.kind == "ticks" else None
        if ticks is None or ticks.size < 2:
            continue
        steps = np.diff(ticks)
        if (back := int(np.argmax(steps < 0))) or steps[0] < 0:
            yield error_at(
                field.path,
                f"goes back at entry {back + 1}: {ticks[back + 1]} after {ticks[back]}",
                code="ticks-go-back",
                cure="ticks must be values of one unwrapped counter; unwrap it or record again",
            )
        elif n_equal := int(np.count_nonzero(steps == 0)):
            at = int(np.argmax(steps == 0))
            what = f"has {counted(n_equal, 'repeated tick')}, the first {ticks[at]} at entry {at + 1}"
            if field is layout.CAMERA_TRIGGER:
                yield error_at(
                    field.path, what, code="trigger-repeated", cure="two triggers cannot be at one time; record again"
                )
            else:
                yield warning_at(
                    field.path, what, code="tick-repeated", cure="an edge was stamped twice; check the light gate"
                )


def _frame_numbers(contents: Contents) -> Iterator[Finding]:
    shape, triggers = contents.get(layout.FRAMES), contents.get(layout.CAMERA_TRIGGER)
    numbers: Ticks | None = contents.get(layout.FRAME_NUMBER)
    if shape is None:
        return
    n_frames = int(shape[0])
    if numbers is None:
        if triggers is not None:
            yield from _without_numbers(n_frames, triggers.size)
        return
    where = layout.FRAME_NUMBER
    if numbers.size != n_frames:
        yield error_at(
            where.path,
            f"has {numbers.size} entries for {n_frames} frames",
            code="frame-number-count",
            cure="write one number per frame",
        )
        return
    steps = np.diff(numbers)
    if steps.size and int(steps.min()) < 1:
        at = int(np.argmax(steps < 1))
        yield error_at(
            where.path,
            f"is {numbers[at + 1]} at frame {at + 1} after {numbers[at]}",
            code="frame-number-not-rising",
            cure="it must increase from frame to frame; write the index of the trigger that made each frame",
        )
    elif numbers[0] < 0 or (triggers is not None and numbers[-1] >= triggers.size):
        n_triggers = "the" if triggers is None else triggers.size
        yield error_at(
            where.path,
            f"runs from {numbers[0]} to {numbers[-1]} for {n_triggers} triggers",
            code="frame-number-out-of-range",
            cure="it must be the index of a trigger, counted from 0",
        )


def _without_numbers(n_frames: int, n_triggers: int) -> Iterator[Finding]:
    if n_frames > n_triggers:
        yield error_at(
            layout.FRAMES.path,
            f"has {n_frames} frames for {n_triggers} triggers in {layout.CAMERA_TRIGGER.path}",
            code="more-frames-than-triggers",
            cure="every frame needs its trigger; record again with the camera in triggered mode",
        )
    elif n_frames < n_triggers:
        yield warning_at(
            layout.FRAMES.path,
            f"has {n_frames} frames for {n_triggers} triggers and no frame_number",
            code="fewer-frames-than-triggers",
            cure="frame i is taken to belong to trigger i; write frame_number if frames were lost in between",
        )


def _events(contents: Contents) -> Iterator[Finding]:
    """Every event needs the field that holds it, every exchange its three columns."""
    event = contents.get(layout.FRAME_EVENT) or "trigger"
    for needed in _NEEDED.get(event, ()):
        if contents.get(needed) is None:
            yield error_at(
                needed.path,
                f"is missing while {layout.FRAME_EVENT.name} is '{event}' ({needed.meaning})",
                code="frame-event-without-field",
                cure=f"write it, or another {layout.FRAME_EVENT.name}; see {layout.REFERENCE_PAGE}",
            )
    set_s = contents.get(layout.TRIGGER_DELAY_TIME_SET) or 0.0
    if event != "trigger" and set_s:
        yield error_at(
            layout.TRIGGER_DELAY_TIME_SET.path,
            f"is {set_s:g} s while {layout.FRAME_EVENT.name} is '{event}'",
            code="set-delay-without-trigger",
            cure="a camera that runs free knows no set delay; leave it out",
        )
    for fields in layout.EXCHANGES:
        sizes = [None if contents.get(field) is None else len(contents[field]) for field in fields]
        if len(set(sizes)) > 1:
            counts = ", ".join(f"{field.name} {size or 0}" for field, size in zip(fields, sizes, strict=True))
            yield error_at(
                fields[1].path,
                f"has not as many entries as its two times ({counts})",
                code="exchanges-incomplete",
                cure="write before, reading and after of each exchange",
            )
        elif sizes[0] and bool(np.any(~(np.asarray(contents[fields[2]]) >= np.asarray(contents[fields[0]])))):
            yield error_at(
                fields[2].path,
                "is earlier than exchange_before at some entry, or no number",
                code="exchange-ends-before-it-begins",
                cure="both must be of one clock of the computer that is never set",
            )


_NEEDED: dict[str, tuple[Field, ...]] = {
    "strobe": (layout.CAMERA_INPUT,),
    "stamp": (layout.FRAME_TIMESTAMP, layout.TIMESTAMP_FREQUENCY),
    "arrival": (layout.FRAME_HOST_TIME,),
}
"""What holds the events of a camera that runs free."""


def _reference(contents: Contents) -> Iterator[Finding]:
    shape = contents.get(layout.FRAMES)
    low, high = contents.get(layout.REFERENCE_LOW), contents.get(layout.REFERENCE_HIGH)
    if (low is None) != (high is None):
        there, gone = ("low", layout.REFERENCE_HIGH) if high is None else ("high", layout.REFERENCE_LOW)
        yield error_at(
            gone.path,
            f"is missing while {there} is there",
            code="reference-incomplete",
            cure="write both reference stacks or none",
        )
    for field, reference in ((layout.REFERENCE_LOW, low), (layout.REFERENCE_HIGH, high)):
        if reference is None:
            continue
        if shape is not None and tuple(reference[1:]) != tuple(shape[1:]):
            yield error_at(
                field.path,
                f"has frames of {_size(reference)} pixels, {layout.FRAMES.path} of {_size(shape)}",
                code="reference-size-differs",
                cure="all frames of a file must have one size; record the reference with the same window",
            )
        if reference[0] == 1:
            yield warning_at(
                field.path,
                "has a single frame",
                code="reference-single-frame",
                cure="its noise is unknown; record ten or more",
            )


def _size(shape: tuple[int, int, int]) -> str:
    return f"{shape[1]} x {shape[2]}"
