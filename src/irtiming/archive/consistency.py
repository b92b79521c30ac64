"""Checks that need more than one field; the reader raises the first error, verify shows them all."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from irtiming.archive import layout
from irtiming.archive.layout import Field
from irtiming.records.finding import Finding

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
        *_reference(contents),
    ]


def check_temperatures(temperatures: dict[Field, float | None]) -> list[Finding]:
    """Complain where the reference called low is not colder than the one called high; temperatures in K."""
    low, high = temperatures.get(layout.REFERENCE_LOW), temperatures.get(layout.REFERENCE_HIGH)
    if low is None or high is None or low < high:
        return []
    return [
        _error(
            layout.REFERENCE_LOW,
            f"is at {low:g} K, high at {high:g} K",
            cure="low must be the colder one; swap them",
        )
    ]


def _ending(contents: Contents) -> Iterator[Finding]:
    ending = contents.get(layout.ENDING)
    if ending is not None and ending.startswith(layout.NOT_TRUSTED):
        yield _error(layout.ENDING, f"says: {ending}", cure="its frames may belong to other triggers; record it again")
    elif ending is not None and ending != layout.COMPLETE:
        yield _warning(
            layout.ENDING, f"says: {ending}", cure="the recording is shorter than planned, what is in it is sound"
        )


def _streams(contents: Contents) -> Iterator[Finding]:
    for field in layout.FIELDS:
        ticks: Ticks | None = contents.get(field) if field.kind == "ticks" else None
        if ticks is None or ticks.size < 2:
            continue
        steps = np.diff(ticks)
        if (back := int(np.argmax(steps < 0))) or steps[0] < 0:
            yield _error(
                field,
                f"goes back at entry {back + 1}: {ticks[back + 1]} after {ticks[back]}",
                cure="ticks must be values of one unwrapped counter; unwrap it or record again",
            )
        elif n_equal := int(np.count_nonzero(steps == 0)):
            at = int(np.argmax(steps == 0))
            what = f"has {n_equal} repeated ticks, the first {ticks[at]} at entry {at + 1}"
            if field is layout.CAMERA_TRIGGER:
                yield _error(field, what, cure="two triggers cannot be at one time; record again")
            else:
                yield _warning(field, what, cure="an edge was stamped twice; check the light gate")


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
        yield _error(where, f"has {numbers.size} entries for {n_frames} frames", cure="write one number per frame")
        return
    steps = np.diff(numbers)
    if steps.size and int(steps.min()) < 1:
        at = int(np.argmax(steps < 1))
        yield _error(
            where,
            f"is {numbers[at + 1]} at frame {at + 1} after {numbers[at]}",
            cure="it must increase from frame to frame; write the index of the trigger that made each frame",
        )
    elif numbers[0] < 0 or (triggers is not None and numbers[-1] >= triggers.size):
        n_triggers = "the" if triggers is None else triggers.size
        yield _error(
            where,
            f"runs from {numbers[0]} to {numbers[-1]} for {n_triggers} triggers",
            cure="it must be the index of a trigger, counted from 0",
        )


def _without_numbers(n_frames: int, n_triggers: int) -> Iterator[Finding]:
    if n_frames > n_triggers:
        yield _error(
            layout.FRAMES,
            f"has {n_frames} frames for {n_triggers} triggers in {layout.CAMERA_TRIGGER.path}",
            cure="every frame needs its trigger; record again with the camera in triggered mode",
        )
    elif n_frames < n_triggers:
        yield _warning(
            layout.FRAMES,
            f"has {n_frames} frames for {n_triggers} triggers and no frame_number",
            cure="frame i is taken to belong to trigger i; write frame_number if frames were lost in between",
        )


def _reference(contents: Contents) -> Iterator[Finding]:
    shape = contents.get(layout.FRAMES)
    low, high = contents.get(layout.REFERENCE_LOW), contents.get(layout.REFERENCE_HIGH)
    if (low is None) != (high is None):
        there, gone = ("low", layout.REFERENCE_HIGH) if high is None else ("high", layout.REFERENCE_LOW)
        yield _error(gone, f"is missing while {there} is there", cure="write both reference stacks or none")
    for field, reference in ((layout.REFERENCE_LOW, low), (layout.REFERENCE_HIGH, high)):
        if reference is None:
            continue
        if shape is not None and tuple(reference[1:]) != tuple(shape[1:]):
            yield _error(
                field,
                f"has frames of {_size(reference)} pixels, {layout.FRAMES.path} of {_size(shape)}",
                cure="all frames of a file must have one size; record the reference with the same window",
            )
        if reference[0] == 1:
            yield _warning(field, "has a single frame", cure="its noise is unknown; record ten or more")


def _size(shape: tuple[int, int, int]) -> str:
    return f"{shape[1]} x {shape[2]}"


def _error(field: Field, what: str, *, cure: str) -> Finding:
    return Finding(severity="error", where=field.path, what=what, cure=cure)


def _warning(field: Field, what: str, *, cure: str) -> Finding:
    return Finding(severity="warning", where=field.path, what=what, cure=cure)
