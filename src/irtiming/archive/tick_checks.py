"""Checks of the timestamps against each other: wheel speed, slots per turn, triggers, lost frames."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from irtiming.archive import layout
from irtiming.archive.finding import error_at, warning_at
from irtiming.archive.line_checks import is_exchanged
from irtiming.records.finding import Finding
from irtiming.units import counted, readable_time

if TYPE_CHECKING:
    from irtiming.archive.consistency import Contents
    from irtiming.archive.layout import Field
    from irtiming.records.arrays import Ticks

_OF_THE_GATES = (layout.CONTROL_SLOT, layout.APPLICATION_SLOT)
_SPEED_TOLERANCE = 0.02
_LOCKED = 2e-3
"""Of the wheel's speed: a chopper that is locked to its reference keeps it much better, one that is not is some per cent off."""

_TWO_CRYSTALS = 200e-6
"""Of the camera period: by as much an interval may be off where another clock made it than the one that stamped it."""

_TRIGGER_TOLERANCE_TICKS = 1


def check_ticks(contents: "Contents") -> list[Finding]:
    """Warnings and errors about triggers, slots and edges; fields that are None or go back are left out."""
    contents = {field: None if _goes_back(field, value) else value for field, value in contents.items()}
    if is_exchanged(contents):
        contents = {field: None if field in _OF_THE_GATES else value for field, value in contents.items()}
    return [
        *_lost_timestamps(contents),
        *_triggers_within(contents),
        *_trigger_intervals(contents),
        *_rotation_speed(contents),
        *_wheel_period(contents),
        *_half_turns(contents),
        *_slots_per_turn(contents),
        *_slots_among_edges(contents),
        *_lost_frames(contents),
        *_window_within_the_period(contents),
    ]


def _goes_back(field: "Field", value: object) -> bool:
    return field.kind in ("ticks", "index") and value is not None and bool(np.any(np.diff(np.asarray(value)) < 0))


def _lost_timestamps(contents: "Contents") -> Iterator[Finding]:
    lost: Ticks | None = contents.get(layout.LOST_AFTER)
    triggers: Ticks | None = contents.get(layout.CAMERA_TRIGGER)
    clock = contents.get(layout.CLOCK_FREQUENCY)
    if lost is None or lost.size == 0 or triggers is None or clock is None:
        return
    after_s = float(lost[0] - triggers[0]) / clock
    yield error_at(
        layout.LOST_AFTER.path,
        f"states that timestamps were lost at {counted(lost.size, 'place')}, the first {after_s:.6f} s after the first trigger",
        code="timestamps-lost",
        cure="record again; check the line to the trigger generator, and what else the computer did",
    )


def _triggers_within(contents: "Contents") -> Iterator[Finding]:
    triggers: Ticks | None = contents.get(layout.CAMERA_TRIGGER)
    if triggers is None:
        return
    for field in (layout.CONTROL_SLOT, layout.APPLICATION_SLOT):
        edges: Ticks | None = contents.get(field)
        if edges is None:
            continue
        before, after = int(np.count_nonzero(triggers < edges[0])), int(np.count_nonzero(triggers > edges[-1]))
        outside = before + after
        if outside:
            change = "start the timestamps before the first" if before else "stop the timestamps after the last"
            yield Finding(
                code="triggers-outside-ticks",
                severity="error" if outside == triggers.size else "warning",
                where=layout.CAMERA_TRIGGER.path,
                what=f"has {outside} of {triggers.size} triggers outside the ticks of {field.path}",
                cure=f"{change} trigger",
            )


def _trigger_intervals(contents: "Contents") -> Iterator[Finding]:
    triggers: Ticks | None = contents.get(layout.CAMERA_TRIGGER)
    period = contents.get(layout.CAMERA_PERIOD)
    if triggers is None or period is None or triggers.size < 2:
        return
    off = np.abs(np.diff(triggers) - period) > _TRIGGER_TOLERANCE_TICKS
    if n_off := int(np.count_nonzero(off)):
        at = int(np.argmax(off))
        far = bool(np.any(np.abs(np.diff(triggers) - period) > _TRIGGER_TOLERANCE_TICKS + _TWO_CRYSTALS * period))
        yield Finding(
            code="trigger-intervals-odd",
            severity="doubt" if far else "warning",
            where=layout.CAMERA_TRIGGER.path,
            what=f"has {counted(n_off, 'interval')} other than camera_period = {period} ticks, the first of "
            f"{triggers[at + 1] - triggers[at]} ticks after trigger {at}",
            cure="check the trigger generator; the analysis uses the ticks as they are",
        )


def _rotation_speed(contents: "Contents") -> Iterator[Finding]:
    edges: Ticks | None = contents.get(layout.APPLICATION_SLOT)
    clock, nominal = contents.get(layout.CLOCK_FREQUENCY), contents.get(layout.ROTATION_SPEED)
    if edges is None or clock is None or nominal is None or edges.size < 3:
        return
    if float(np.median(np.diff(edges))) == 0:
        yield error_at(
            layout.APPLICATION_SLOT.path,
            "repeats the tick before in most of its entries: no wheel turns so",
            code="application-slots-at-one-tick",
            cure="check the application light gate and the program that wrote the ticks; record again",
        )
        return
    speed = clock / (2 * half_turn_ticks(edges))
    if abs(speed / nominal - 1) > _SPEED_TOLERANCE:
        yield error_at(
            layout.ROTATION_SPEED.path,
            f"= {nominal:g} Hz, but the application slots pass at {speed:.6g} turns per second",
            code="rotation-speed-contradicted",
            cure="correct rotation_speed or clock_frequency; two edges belong to a turn",
        )
    elif abs(speed / nominal - 1) > _LOCKED:
        yield Finding(
            code="rotation-speed-off",
            severity="doubt",
            where=layout.ROTATION_SPEED.path,
            what=f"= {nominal:g} Hz, but the application slots pass at {speed:.6g} turns per second, "
            f"{100 * (speed / nominal - 1):+.2f} %: by as much all times are wrong if it is clock_frequency that is wrong",
            cure="correct clock_frequency or rotation_speed, and see that the chopper is locked",
        )


def half_turn_ticks(edges: "Ticks") -> float:
    """Half of the usual turn, by the edges of the application slots: two belong to one, and need not be half a turn apart.

    Parameters
    ----------
    edges
        Shape (n,), at least 3.
    """
    return float(np.median(edges[2:] - edges[:-2])) / 2


def _wheel_period(contents: "Contents") -> Iterator[Finding]:
    period, clock = contents.get(layout.WHEEL_PERIOD), contents.get(layout.CLOCK_FREQUENCY)
    nominal = contents.get(layout.ROTATION_SPEED)
    if period is None or clock is None or nominal is None:
        return
    if abs(clock / period / nominal - 1) > _SPEED_TOLERANCE:
        yield warning_at(
            layout.WHEEL_PERIOD.path,
            f"= {period} ticks is {clock / period:.6g} Hz, rotation_speed is {nominal:g} Hz",
            code="wheel-period-contradicted",
            cure="one of the two is wrong; correct it",
        )


def _half_turns(contents: "Contents") -> Iterator[Finding]:
    edges: Ticks | None = contents.get(layout.APPLICATION_SLOT)
    if edges is None or edges.size < 3:
        return
    intervals = np.diff(edges)
    usual = float(np.median(intervals))
    for odd, name in ((intervals > 1.5 * usual, "missing"), (intervals < 0.5 * usual, "doubled or spurious")):
        if n_odd := int(np.count_nonzero(odd)):
            yield warning_at(
                layout.APPLICATION_SLOT.path,
                f"has {counted(n_odd, f'{name} edge')}, the first after entry {int(np.argmax(odd))}",
                code="application-edges-odd",
                cure="check the application light gate",
            )


def _slots_per_turn(contents: "Contents") -> Iterator[Finding]:
    slots: Ticks | None = contents.get(layout.CONTROL_SLOT)
    edges: Ticks | None = contents.get(layout.APPLICATION_SLOT)
    if slots is None or edges is None or edges.size < 3:
        return
    counts = np.diff(np.searchsorted(slots, edges[::2]))
    usual = int(np.bincount(counts).argmax())
    if usual == 0:
        yield error_at(
            layout.CONTROL_SLOT.path,
            "has no ticks between the application slots",
            code="control-slots-absent",
            cure="both must be values of one counter; check the control light gate",
        )
    elif n_odd := int(np.count_nonzero(counts != usual)):
        turn = int(np.argmax(counts != usual))
        yield warning_at(
            layout.CONTROL_SLOT.path,
            f"has {n_odd} of {counts.size} turns without the usual {usual} slots, the first is turn {turn} "
            f"with {counts[turn]}",
            code="control-slots-odd",
            cure="check the control light gate",
        )


def _slots_among_edges(contents: "Contents") -> Iterator[Finding]:
    slots: Ticks | None = contents.get(layout.APPLICATION_SLOT)
    edges: Ticks | None = contents.get(layout.APPLICATION_EDGES)
    if slots is None or edges is None:
        return
    inside = slots[(slots >= edges[0]) & (slots <= edges[-1])]
    strange = inside[~np.isin(inside, edges)]
    if strange.size:
        yield warning_at(
            layout.APPLICATION_EDGES.path,
            f"lacks {counted(strange.size, 'tick')} of application_slot, the first is {strange[0]}",
            code="application-edges-incomplete",
            cure="edges 0 and 2 belong to all four; check the modified circuit",
        )


def _lost_frames(contents: "Contents") -> Iterator[Finding]:
    numbers: Ticks | None = contents.get(layout.FRAME_NUMBER)
    triggers: Ticks | None = contents.get(layout.CAMERA_TRIGGER)
    if numbers is None or triggers is None or numbers.size == 0:
        return
    if (n_lost := triggers.size - numbers.size) > 0:
        gaps = np.flatnonzero(np.diff(numbers) > 1)
        first = 0 if numbers[0] > 0 else int(numbers[gaps[0]]) + 1 if gaps.size else int(numbers[-1]) + 1
        yield warning_at(
            layout.FRAME_NUMBER.path,
            f"leaves out {n_lost} of {triggers.size} triggers, the first is {first}: lost frames",
            code="frames-lost",
            cure="check the link to the camera; lost frames are left out",
        )


def _window_within_the_period(contents: "Contents") -> Iterator[Finding]:
    """A frame's integration has ended when the next one begins; a period stated in ticks stands before that of the triggers."""
    window_s, clock = contents.get(layout.INTEGRATION_TIME), contents.get(layout.CLOCK_FREQUENCY)
    triggers: Ticks | None = contents.get(layout.CAMERA_TRIGGER)
    period = contents.get(layout.CAMERA_PERIOD)
    if period is None and triggers is not None and triggers.size > 1:
        period = float(np.median(np.diff(triggers)))
    if window_s is None or clock is None or not period or contents.get(layout.CAMERA_TYPE) != "photon":
        return
    if window_s > (1 + _TWO_CRYSTALS) * period / clock:
        yield error_at(
            layout.INTEGRATION_TIME.path,
            f"= {readable_time(window_s)}, but frames follow each other by {readable_time(period / clock)}: no camera integrates "
            "into the next frame",
            code="integration-time-beyond-period",
            cure="correct count_time, its unit (s) first, or clock_frequency",
        )


def duration(contents: "Contents") -> str:
    """Time from the first to the last trigger, as people read it; empty where it is not known."""
    triggers: Ticks | None = contents.get(layout.CAMERA_TRIGGER)
    clock = contents.get(layout.CLOCK_FREQUENCY)
    if triggers is None or clock is None:
        return ""
    return readable_time(int(triggers[-1] - triggers[0]) / clock)
